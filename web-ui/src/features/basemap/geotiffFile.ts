// A GeoTIFF file of this computer: what is in it, and its pixels for one patch at a time. Knows no map and no page: it runs in a worker, and in
// tests without one. Must never read more of the file than it needs.

import { GeoTIFF } from 'geotiff';
import type { GeoTIFFImage } from 'geotiff';
import { paint, samplesOf } from './geotiffColours';
import type { Colouring } from './geotiffColours';
import type { GeoTags } from './georeference';
import { BlockCache, MOST_BLOCK_BYTES, Raster } from './geotiffRaster';
import { boxOf, pictureFor } from './pixelPyramid';
import type { Place, Size } from './pixelPyramid';

/** Why a file cannot be shown; words are put to it where it is shown. */
export type Fault =
  | { readonly kind: 'no-tiff' | 'colours' | 'large-blocks' | 'damaged' }
  | { readonly kind: 'depth'; readonly bits: number }
  | { readonly kind: 'compression'; readonly method: string };

export class FaultyFile extends Error {
  constructor(readonly fault: Fault) {
    super(fault.kind);
  }
}

/** What the map has to know of a file. */
export type Facts = {
  /** Finest first; the others are its overviews. */
  readonly pictures: readonly Size[];
  readonly tags: GeoTags;
};

/** Nothing that is read at once is larger: a table or a packed block. */
const MOST_READ_BYTES = 128 * 2 ** 20;
/** A chain of pictures that is longer is taken for one that bites its tail. */
const MOST_PICTURES = 64;

const REDUCED = 1;
const MASK = 4;
const JPEG = 7;
/** Unpacking JPEG takes about so many times what comes out. */
const JPEG_ROOM = 4;
/** Nothing, LZW, JPEG, deflate (two numbers), PackBits, WebP. What needs WebAssembly (ZSTD, LERC) the page may not run. */
const KNOWN_METHODS: readonly number[] = [1, 5, JPEG, 8, 32946, 32773, 50001];
const METHOD_NAMES: Readonly<Record<number, string>> = { 6: 'JPEG (TIFF 6.0)', 34712: 'JPEG 2000', 34887: 'LERC', 50000: 'ZSTD', 50002: 'JPEG XL' };

/** Reads pieces of a blob, in a page, a worker or a test. */
class BlobSource {
  readonly fileSize = null;

  constructor(readonly blob: Blob) {}

  async fetch(slices: readonly { offset: number; length: number }[]): Promise<ArrayBuffer[]> {
    return Promise.all(slices.map(async (slice) => (await this.fetchSlice(slice)).data));
  }

  async fetchSlice({ offset, length }: { offset: number; length: number }) {
    if (!(length <= MOST_READ_BYTES)) throw new RangeError('more than may be read at once');
    return { offset, length, data: await this.blob.slice(offset, offset + length).arrayBuffer() };
  }

  async close(): Promise<void> {
    // There is nothing to close.
  }
}

export class GeotiffFile {
  readonly facts: Facts;

  private constructor(
    readonly rasters: readonly Raster[],
    /** For each picture where it is to be seen, if the file says so in a picture of its own. */
    readonly masks: readonly (Raster | null)[],
    readonly colouring: Colouring,
    tags: GeoTags,
  ) {
    this.facts = { pictures: rasters.map(({ widthPx, heightPx }) => ({ widthPx, heightPx })), tags };
  }

  /** Throws a `FaultyFile`. */
  static async open(blob: Blob): Promise<GeotiffFile> {
    let images: GeoTIFFImage[];
    try {
      images = await imagesOf(await GeoTIFF.fromSource(new BlobSource(blob)));
    } catch {
      throw new FaultyFile({ kind: 'no-tiff' });
    }
    try {
      return await GeotiffFile.#of(images);
    } catch (error) {
      throw error instanceof FaultyFile ? error : new FaultyFile({ kind: 'damaged' });
    }
  }

  static async #of(images: readonly GeoTIFFImage[]): Promise<GeotiffFile> {
    const [full] = images as [GeoTIFFImage];
    refuseWhatCannotBeShown(full);
    const colouring = await colouringOf(full);
    const tags = await geoTagsOf(full);
    const cache = new BlockCache();
    const all = images.map((image, k) => ({ raster: new Raster(image, `${k}`, cache), type: Number(image.fileDirectory.getValue('NewSubfileType') ?? 0) }));
    const rasters = all
      .filter(({ raster, type }, k) => k === 0 || ((type & REDUCED) !== 0 && (type & MASK) === 0 && isAlike(full, raster.image)))
      .map(({ raster }) => raster)
      .sort((a, b) => b.widthPx - a.widthPx);
    const masks = rasters.map((raster) => {
      const mask = all.find(({ raster: other, type }) => (type & MASK) !== 0 && other.widthPx === raster.widthPx && other.heightPx === raster.heightPx);
      return mask?.raster ?? null;
    });
    const file = new GeotiffFile(rasters, masks, colouring, tags);
    const most = methodOf(full) === JPEG ? MOST_BLOCK_BYTES / JPEG_ROOM : MOST_BLOCK_BYTES;
    for (const raster of [...rasters, ...masks]) {
      if (raster && raster.blockBytes > most) throw new FaultyFile({ kind: 'large-blocks' });
    }
    // The last block is what a file lacks that was not copied to its end.
    await rasters[0]!.read(Int32Array.of(full.getWidth() - 1), Int32Array.of(full.getHeight() - 1), [0]);
    return file;
  }

  /** The pixels of a patch, or null where there is nothing to be seen. */
  async patch(place: Place): Promise<{ pixels: Uint8ClampedArray<ArrayBuffer>; size: Size } | null> {
    const [full] = this.facts.pictures as [Size];
    const box = boxOf(place, full);
    const { index } = pictureFor(place.level, this.facts.pictures);
    const raster = this.rasters[index]!;
    const factor = 2 ** place.level;
    // The middle of each pixel decides.
    const columns = nearest(box.left, factor, box.widthPx, full.widthPx, raster.widthPx);
    const rows = nearest(box.top, factor, box.heightPx, full.heightPx, raster.heightPx);
    const pixels = new Uint8ClampedArray(box.widthPx * box.heightPx * 4);
    const seen = paint(await raster.read(columns, rows, samplesOf(this.colouring)), this.colouring, pixels);
    const mask = seen ? await this.masks[index]?.read(columns, rows, [0]) : undefined;
    mask?.forEach((visible, k) => {
      if (visible === 0) pixels[k * 4 + 3] = 0;
    });
    return seen ? { pixels, size: { widthPx: box.widthPx, heightPx: box.heightPx } } : null;
  }
}

function nearest(from: number, factor: number, count: number, fullPx: number, sizePx: number): Int32Array {
  return Int32Array.from({ length: count }, (_, k) => Math.min(sizePx - 1, Math.floor(((from + (k + 0.5) * factor) * sizePx) / fullPx)));
}

async function imagesOf(tiff: GeoTIFF): Promise<GeoTIFFImage[]> {
  const images = [await tiff.getImage(0)];
  try {
    while (images.length < MOST_PICTURES) images.push(await tiff.getImage(images.length));
  } catch {
    // That was the last one, or what follows is broken: the first one can be shown without.
  }
  return images;
}

function refuseWhatCannotBeShown(image: GeoTIFFImage): void {
  if (!(image.getWidth() > 0 && image.getHeight() > 0 && image.getTileWidth() > 0 && image.getTileHeight() > 0)) throw new FaultyFile({ kind: 'damaged' });
  const samples = image.getSamplesPerPixel();
  const bits = Array.from({ length: samples }, (_, k) => image.getBitsPerSample(k) ?? 0);
  const most = Math.max(...bits);
  // Heights and raw values: which colour they would have nobody has said.
  if (most > 8 || image.getSampleFormat() !== 1) throw new FaultyFile({ kind: 'depth', bits: most });
  if (!(bits.every((b) => b === 8) || (samples === 1 && [1, 2, 4].includes(most)))) throw new FaultyFile({ kind: 'colours' });
  const method = methodOf(image);
  if (!KNOWN_METHODS.includes(method)) throw new FaultyFile({ kind: 'compression', method: METHOD_NAMES[method] ?? `${method}` });
}

const methodOf = (image: GeoTIFFImage): number => Number(image.fileDirectory.getValue('Compression') ?? 1);

/** An overview has to be made as the picture is, or its colours would be wrong ones. */
function isAlike(full: GeoTIFFImage, overview: GeoTIFFImage): boolean {
  const sameAs = (tag: 'PhotometricInterpretation' | 'SamplesPerPixel') => full.fileDirectory.getValue(tag) === overview.fileDirectory.getValue(tag);
  return sameAs('PhotometricInterpretation') && sameAs('SamplesPerPixel') && full.getBitsPerSample() === overview.getBitsPerSample();
}

async function colouringOf(image: GeoTIFFImage): Promise<Colouring> {
  const { fileDirectory: tags } = image;
  const samples = image.getSamplesPerPixel();
  const noData = image.getGDALNoData();
  const meaning = Number(tags.getValue('PhotometricInterpretation'));
  const colours = meaning === 2 || meaning === 6 ? 3 : 1;
  const extra = Array.from((await tags.loadValue('ExtraSamples')) ?? []).map(Number);
  // 0: a value of another kind, such as infrared.
  const at = extra.findIndex((kind) => kind === 1 || kind === 2);
  const alpha = at >= 0 && colours + at < samples ? colours + at : null;
  if (samples < colours) throw new FaultyFile({ kind: 'colours' });
  if (meaning === 0 || meaning === 1) return { kind: 'grey', most: 2 ** image.getBitsPerSample() - 1, inverted: meaning === 0, alpha, noData };
  if (meaning === 2) return { kind: 'rgb', alpha, premultiplied: extra[at] === 1, noData };
  if (meaning === 3) {
    const map = await tags.loadValue('ColorMap');
    if (map && typeof map !== 'number') return { kind: 'palette', map: map as ArrayLike<number>, noData };
  }
  // Outside of JPEG its colours may lie in fewer pixels than its light.
  if (meaning === 6 && methodOf(image) === JPEG) return { kind: 'ycbcr', alpha, premultiplied: false, noData };
  throw new FaultyFile({ kind: 'colours' });
}

async function geoTagsOf(image: GeoTIFFImage): Promise<GeoTags> {
  const numbers = async (tag: 'ModelPixelScale' | 'ModelTiepoint' | 'ModelTransformation'): Promise<number[] | null> => {
    const value = await image.fileDirectory.loadValue(tag);
    return value && typeof value === 'object' ? Array.from(value as ArrayLike<number>) : null;
  };
  const keys = Object.fromEntries(Object.entries(image.getGeoKeys() ?? {}).filter(([, value]) => typeof value === 'number' || typeof value === 'string'));
  return { pixelScale: await numbers('ModelPixelScale'), tiepoints: await numbers('ModelTiepoint'), transformation: await numbers('ModelTransformation'), keys };
}
