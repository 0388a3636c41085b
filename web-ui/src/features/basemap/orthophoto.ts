// A GeoTIFF as the ground of the map: which patches a view needs and where they lie. What is in the file a worker reads. Must never show a
// picture whose place is not certain.

import { t } from '../../language/language.svelte';
import type { Facts, Fault } from './geotiffFile';
import type { Answered, Asked } from './geotiffWorker';
import { Georeference, affineOf, codeOf, definitionOf, rim } from './georeference';
import { BaseMapError, MOST_SHOWN, common } from './ground';
import type { Ground, Patch } from './ground';
import { boxOf, levelFor, levelsOf, patchesIn, pictureFor } from './pixelPyramid';
import type { Box, Place, Size } from './pixelPyramid';
import type { Piece } from './tileMath';

/** How much coarser what lies below is. */
const COARSER = 2;
/** A level below is read only where the file has an overview for it: made of finer pixels it would cost more than what lies on it. */
const MOST_STEP = 2;
/** Places that are kept: those of all levels of a picture of 16,000 pixels each way. */
const MOST_PLACED = 6000;

/** The file as the worker knows it. */
class Reader {
  readonly #worker = new Worker(new URL('./geotiffWorker.ts', import.meta.url), { type: 'module' });
  readonly #waiting = new Map<number, (picture: ImageBitmap | null) => void>();
  #next = 0;

  open(file: File): Promise<Facts> {
    return new Promise((done, failed) => {
      this.#worker.onerror = () => {
        failed(new BaseMapError(t('{file} could not be read', { file: file.name })));
        this.#giveUp();
      };
      this.#worker.onmessage = ({ data }: MessageEvent<Answered>) => {
        if ('facts' in data) done(data.facts);
        else if ('fault' in data) failed(new BaseMapError(wordsFor(data.fault, file.name)));
        else this.#hand(data.id, data.picture);
      };
      this.#ask({ open: file });
    });
  }

  picture(place: Place): Promise<ImageBitmap | null> {
    const id = this.#next++;
    return new Promise((done) => {
      this.#waiting.set(id, done);
      this.#ask({ id, place });
    });
  }

  close(): void {
    this.#worker.terminate();
    this.#giveUp();
  }

  /** What has been asked for will not come any more. */
  #giveUp(): void {
    for (const done of this.#waiting.values()) done(null);
    this.#waiting.clear();
  }

  #ask(asked: Asked): void {
    this.#worker.postMessage(asked);
  }

  #hand(id: number, picture: ImageBitmap | null): void {
    this.#waiting.get(id)?.(picture);
    this.#waiting.delete(id);
  }
}

function wordsFor(fault: Fault, file: string): string {
  switch (fault.kind) {
    case 'no-tiff':
      return t('{file} is no GeoTIFF file', { file });
    case 'colours':
      return t('{file} holds no picture in colours, in grey or with a palette', { file });
    case 'large-blocks':
      return t('{file} is stored in parts that are too large: write it anew with tiles', { file });
    case 'damaged':
      return t('{file} is damaged or not complete', { file });
    case 'depth':
      return t('{file} holds values of {bits} bits, such as heights: only pictures of 8 bits are shown', { file, bits: fault.bits });
    case 'compression':
      return t('{file} is compressed in a way that is not known here: {method}', { file, method: fault.method });
  }
}

/** Where the file lies, or a `BaseMapError`. */
function placed({ tags }: Facts, file: string): Georeference {
  const affine = affineOf(tags);
  const code = codeOf(tags.keys);
  if (!affine || code === null) throw new BaseMapError(t('{file} does not say where on Earth it lies', { file }));
  if (code === 'own') throw new BaseMapError(t('{file} is in a projection without an EPSG code', { file }));
  const definition = definitionOf(code);
  if (!definition) throw new BaseMapError(t('{file} is in a projection that is not known here: EPSG:{code}', { file, code }));
  return new Georeference(affine, definition);
}

export class Orthophoto implements Ground {
  /** The worker reads one after the other; the second is there when it has finished. What is no longer looked at is not waited for. */
  readonly atOnce = 2;
  readonly #full: Size;
  readonly #piece: Piece;
  readonly #pixelM: number;
  readonly #levels: number;
  #placed = new Map<string, Patch>();

  private constructor(
    readonly name: string,
    readonly facts: Facts,
    readonly reference: Georeference,
    readonly reader: Reader,
  ) {
    this.#full = facts.pictures[0]!;
    const { widthPx, heightPx } = this.#full;
    this.#piece = reference.pieceOf(widthPx, heightPx);
    this.#pixelM = reference.pixelM(widthPx / 2, heightPx / 2);
    this.#levels = levelsOf(this.#full);
    if (![...Object.values(this.#piece), this.#pixelM].every(Number.isFinite)) {
      throw new BaseMapError(t('{file} does not say where on Earth it lies', { file: name }));
    }
  }

  static async open(file: File): Promise<Orthophoto> {
    const reader = new Reader();
    try {
      const facts = await reader.open(file);
      return new Orthophoto(file.name, facts, placed(facts, file.name), reader);
    } catch (error) {
      reader.close();
      throw error;
    }
  }

  patches(view: Piece, metresPerPixel: number): Patch[] {
    const piece = common(view, this.#piece);
    if (!piece) return [];
    const box = this.#boxOf(piece);
    let level = levelFor(metresPerPixel, this.#pixelM, this.#levels);
    let fine = patchesIn(box, level, this.#full, MOST_SHOWN);
    // On a very large screen: rather all of it coarser than a hole at its edge.
    while (!fine) fine = patchesIn(box, ++level, this.#full, MOST_SHOWN);
    const below = level + COARSER;
    const coarse = below < this.#levels && pictureFor(below, this.facts.pictures).step <= MOST_STEP ? patchesIn(box, below, this.#full, MOST_SHOWN) : null;
    return [...(coarse ?? []), ...fine].map((place) => this.#patch(place));
  }

  close(): void {
    this.reader.close();
  }

  /** The pixels that lie in a piece of Earth. */
  #boxOf({ south, west, north, east }: Piece): Box {
    const pixels = rim([west, south, east, north]).map(([longitudeDeg, latitudeDeg]) => this.reference.toPixel({ latitudeDeg, longitudeDeg }));
    const [columns, rows] = [pixels.map((p) => p.column), pixels.map((p) => p.row)];
    return { left: Math.min(...columns), top: Math.min(...rows), right: Math.max(...columns), bottom: Math.max(...rows) };
  }

  #patch(place: Place): Patch {
    const key = `${place.level}/${place.column}/${place.row}`;
    const kept = this.#placed.get(key);
    if (kept) return kept;
    const { left, top, right, bottom } = boxOf(place, this.#full);
    const patch: Patch = {
      key,
      upperLeft: this.reference.toDegrees(left, top),
      upperRight: this.reference.toDegrees(right, top),
      lowerLeft: this.reference.toDegrees(left, bottom),
      load: () => this.reader.picture(place),
    };
    if (this.#placed.size >= MOST_PLACED) this.#placed.clear();
    this.#placed.set(key, patch);
    return patch;
  }
}
