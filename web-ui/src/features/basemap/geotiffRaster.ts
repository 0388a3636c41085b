// The values of one picture in a TIFF file, read block by block: its strips or tiles. Must never hold more of it than the blocks that it may
// keep, however large the piece that is asked for.

import { getDecoder } from 'geotiff';
import type { BaseDecoder, GeoTIFFImage } from 'geotiff';

/** What one block may take when it is unpacked, and what all kept ones may. */
export const MOST_BLOCK_BYTES = 96 * 2 ** 20;

/** Unpacked blocks, kept for the patches beside; the longest unused go first. */
export class BlockCache {
  readonly #kept = new Map<string, Uint8Array>();
  #bytes = 0;

  constructor(readonly most = MOST_BLOCK_BYTES) {}

  async get(key: string, read: () => Promise<Uint8Array>): Promise<Uint8Array> {
    const kept = this.#kept.get(key);
    if (kept) {
      this.#kept.delete(key);
      this.#kept.set(key, kept);
      return kept;
    }
    const block = await read();
    this.#kept.set(key, block);
    this.#bytes += block.byteLength;
    for (const [oldest, old] of this.#kept) {
      if (this.#bytes <= this.most || oldest === key) break;
      this.#kept.delete(oldest);
      this.#bytes -= old.byteLength;
    }
    return block;
  }
}

/** Which of the columns or rows that are asked for lie in which block. */
function runs(wanted: Int32Array, size: number): { block: number; from: number; to: number }[] {
  const found: { block: number; from: number; to: number }[] = [];
  for (let k = 0; k < wanted.length; k++) {
    const block = Math.floor(wanted[k]! / size);
    const last = found.at(-1);
    if (last?.block === block) last.to = k + 1;
    else found.push({ block, from: k, to: k + 1 });
  }
  return found;
}

export class Raster {
  readonly widthPx: number;
  readonly heightPx: number;
  readonly blockBytes: number;
  readonly #separate: boolean;
  readonly #perPixel: number;
  #decoder: Promise<BaseDecoder> | null = null;

  /** `name` keeps its blocks apart from those of the file's other pictures. */
  constructor(
    readonly image: GeoTIFFImage,
    readonly name: string,
    readonly cache: BlockCache,
  ) {
    this.widthPx = image.getWidth();
    this.heightPx = image.getHeight();
    this.#separate = image.planarConfiguration === 2;
    this.#perPixel = this.#separate ? 1 : image.getSamplesPerPixel();
    this.blockBytes = image.getTileWidth() * image.getTileHeight() * this.#perPixel;
  }

  /** The values at these columns and rows (both ascending), row by row, `samples` of each pixel one after the other. */
  async read(columns: Int32Array, rows: Int32Array, samples: readonly number[]): Promise<Uint8Array> {
    const out = new Uint8Array(columns.length * rows.length * samples.length);
    const blockWidth = this.image.getTileWidth();
    const blockHeight = this.image.getTileHeight();
    for (const row of runs(rows, blockHeight)) {
      for (const column of runs(columns, blockWidth)) {
        for (const [k, sample] of samples.entries()) {
          const block = await this.#block(column.block, row.block, this.#separate ? sample : 0);
          const offset = this.#separate ? 0 : sample;
          for (let r = row.from; r < row.to; r++) {
            const line = (rows[r]! - row.block * blockHeight) * blockWidth - column.block * blockWidth;
            for (let c = column.from; c < column.to; c++) {
              out[(r * columns.length + c) * samples.length + k] = block[(line + columns[c]!) * this.#perPixel + offset]!;
            }
          }
        }
      }
    }
    return out;
  }

  async #block(column: number, row: number, sample: number): Promise<Uint8Array> {
    return this.cache.get(`${this.name}/${sample}/${column}/${row}`, async () => {
      const { data } = await this.image.getTileOrStrip(column, row, sample, await (this.#decoder ??= this.#makeDecoder()));
      const block = new Uint8Array(data);
      const lines = Math.min(this.image.getTileHeight(), this.heightPx - row * this.image.getTileHeight());
      if (block.length < lines * this.image.getTileWidth() * this.#perPixel) throw new RangeError('a block that is too short');
      return block;
    });
  }

  async #makeDecoder(): Promise<BaseDecoder> {
    const { fileDirectory: tags } = this.image;
    // Where the blocks are is asked for every one of them: the whole table at once spares a read of the file for each.
    for (const table of this.image.isTiled ? (['TileOffsets', 'TileByteCounts'] as const) : (['StripOffsets', 'StripByteCounts'] as const)) {
      await tags.loadValue(table);
    }
    const parameters = {
      tileWidth: this.image.getTileWidth(),
      tileHeight: this.image.getTileHeight(),
      predictor: Number((await tags.loadValue('Predictor')) ?? 1),
      bitsPerSample: Array.from((await tags.loadValue('BitsPerSample')) ?? [1]),
      planarConfiguration: this.image.planarConfiguration,
      samplesPerPixel: this.image.getSamplesPerPixel(),
      JPEGTables: await tags.loadValue('JPEGTables'),
    };
    return getDecoder(Number((await tags.loadValue('Compression')) ?? 1), parameters);
  }
}
