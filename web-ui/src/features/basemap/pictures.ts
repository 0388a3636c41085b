// The operator's own base map: tiles with pictures out of one PMTiles file of this computer. Nothing is fetched from anywhere and nothing is
// sent. The reader of the format is loaded with the first file. Must never keep more tiles than it may.

import type { PMTiles } from 'pmtiles';
import { levelFor, tilesOf } from './tileMath';
import type { Piece, Tile } from './tileMath';

/** Pictures that are kept; the longest unused go first. */
const MOST_KEPT = 200;
/** Tiles of one view. */
const MOST_SHOWN = 80;
const MOST_LOADING = 8;

/** Why a file is no base map, in words. */
export class BaseMapError extends Error {
  override name = 'BaseMapError';
}

export class BaseMap {
  /** In the order of their last use; null: the file has no such tile. */
  readonly #kept = new Map<string, ImageBitmap | null>();
  readonly #loading = new Set<string>();

  private constructor(
    readonly name: string,
    readonly least: number,
    readonly most: number,
    readonly piece: Piece,
    readonly source: PMTiles,
    readonly onpicture: () => void,
  ) {}

  /** Opens a file; `onpicture` is called whenever a tile has come. */
  static async open(file: File, onpicture: () => void): Promise<BaseMap> {
    const { FileSource, PMTiles, TileType } = await import('pmtiles');
    const source = new PMTiles(new FileSource(file));
    const header = await source.getHeader().catch(() => {
      throw new BaseMapError(`${file.name} is no PMTiles file`);
    });
    if (![TileType.Png, TileType.Jpeg, TileType.Webp, TileType.Avif].includes(header.tileType)) {
      throw new BaseMapError(`${file.name} holds no pictures (PNG, JPEG, WebP or AVIF)`);
    }
    const piece = { south: header.minLat, west: header.minLon, north: header.maxLat, east: header.maxLon };
    return new BaseMap(file.name, header.minZoom, header.maxZoom, piece, source, onpicture);
  }

  /** The pictures that are there for a piece of Earth, coarser ones below finer ones; what is missing is loaded. */
  shown(view: Piece, metresPerPixel: number): { tile: Tile; picture: ImageBitmap }[] {
    const piece = {
      south: Math.max(view.south, this.piece.south), west: Math.max(view.west, this.piece.west),
      north: Math.min(view.north, this.piece.north), east: Math.min(view.east, this.piece.east),
    };
    if (!(piece.south < piece.north && piece.west < piece.east)) return [];
    const level = levelFor(metresPerPixel, (piece.south + piece.north) / 2, this.least, this.most);
    const found: { tile: Tile; picture: ImageBitmap }[] = [];
    for (const z of level - 2 >= this.least ? [level - 2, level] : [level]) {
      for (const tile of tilesOf(piece, z, MOST_SHOWN)) {
        const picture = this.#picture(tile);
        if (picture) found.push({ tile, picture });
      }
    }
    return found;
  }

  close(): void {
    for (const picture of this.#kept.values()) picture?.close();
    this.#kept.clear();
  }

  #picture(tile: Tile): ImageBitmap | null {
    const key = `${tile.z}/${tile.x}/${tile.y}`;
    const kept = this.#kept.get(key);
    if (kept !== undefined) {
      this.#kept.delete(key);
      this.#kept.set(key, kept);
      return kept;
    }
    if (!this.#loading.has(key) && this.#loading.size < MOST_LOADING) void this.#load(key, tile);
    return null;
  }

  async #load(key: string, { z, x, y }: Tile): Promise<void> {
    this.#loading.add(key);
    let picture: ImageBitmap | null = null;
    try {
      const answer = await this.source.getZxy(z, x, y);
      if (answer) picture = await createImageBitmap(new Blob([answer.data]));
    } catch {
      // A tile that cannot be read is one that is not there.
    }
    this.#loading.delete(key);
    this.#kept.set(key, picture);
    for (const [oldest, old] of this.#kept) {
      if (this.#kept.size <= MOST_KEPT) break;
      old?.close();
      this.#kept.delete(oldest);
    }
    this.onpicture();
  }
}
