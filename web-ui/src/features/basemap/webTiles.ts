// Pictures out of a PMTiles file: the web's usual tiles, in one file. The reader of the format is loaded with the first file.

import type { PMTiles } from 'pmtiles';
import { t } from '../../language/language.svelte';
import { BaseMapError, MOST_SHOWN, common } from './ground';
import type { Ground, Patch } from './ground';
import { cornerOf, levelFor, tilesOf } from './tileMath';
import type { Piece, Tile } from './tileMath';

/** How much coarser what lies below is: it is there sooner, and where the finer level has nothing. */
const COARSER = 2;

export class WebTiles implements Ground {
  readonly atOnce = 8;

  private constructor(
    readonly name: string,
    readonly least: number,
    readonly most: number,
    readonly piece: Piece,
    readonly source: PMTiles,
  ) {}

  static async open(file: File): Promise<WebTiles> {
    const { FileSource, PMTiles, TileType } = await import('pmtiles');
    const source = new PMTiles(new FileSource(file));
    const header = await source.getHeader().catch(() => {
      throw new BaseMapError(t('{file} is no PMTiles file', { file: file.name }));
    });
    if (![TileType.Png, TileType.Jpeg, TileType.Webp, TileType.Avif].includes(header.tileType)) {
      throw new BaseMapError(t('{file} holds no pictures (PNG, JPEG, WebP or AVIF)', { file: file.name }));
    }
    const piece = { south: header.minLat, west: header.minLon, north: header.maxLat, east: header.maxLon };
    return new WebTiles(file.name, header.minZoom, header.maxZoom, piece, source);
  }

  patches(view: Piece, metresPerPixel: number): Patch[] {
    const piece = common(view, this.piece);
    if (!piece) return [];
    const level = levelFor(metresPerPixel, (piece.south + piece.north) / 2, this.least, this.most);
    const levels = level - COARSER >= this.least ? [level - COARSER, level] : [level];
    return levels.flatMap((z) => tilesOf(piece, z, MOST_SHOWN)).map((tile) => this.#patch(tile));
  }

  close(): void {
    // A file of the browser is let go when nobody holds it any more.
  }

  #patch({ z, x, y }: Tile): Patch {
    return {
      key: `${z}/${x}/${y}`,
      upperLeft: cornerOf(z, x, y),
      upperRight: cornerOf(z, x + 1, y),
      lowerLeft: cornerOf(z, x, y + 1),
      load: async () => {
        const answer = await this.source.getZxy(z, x, y);
        return answer ? createImageBitmap(new Blob([answer.data])) : null;
      },
    };
  }
}
