// What a file must offer to be the ground of the map, whatever its kind. Types only, and the reason why a file is refused.

import type { Degrees, Piece } from './tileMath';

/** Patches of one view and one level. */
export const MOST_SHOWN = 80;

/** One picture of the file and where it lies. So small that three corners place it. */
export type Patch = {
  /** The same for the same picture, as long as the file is open. */
  readonly key: string;
  readonly upperLeft: Degrees;
  readonly upperRight: Degrees;
  readonly lowerLeft: Degrees;
  /** Reads the picture; null: there is nothing at this place. */
  readonly load: () => Promise<ImageBitmap | null>;
};

export interface Ground {
  /** Name of the file. */
  readonly name: string;
  /** Patches that are read at the same time. */
  readonly atOnce: number;
  /** What belongs to a piece of Earth when it is looked at so closely: coarse patches first, those of a level from the middle outwards. */
  patches(view: Piece, metresPerPixel: number): readonly Patch[];
  close(): void;
}

/** Why a file is no base map, in words. */
export class BaseMapError extends Error {
  override name = 'BaseMapError';
}

/** What of a view lies on the ground of a file, or null. */
export function common(view: Piece, ground: Piece): Piece | null {
  const piece = {
    south: Math.max(view.south, ground.south), west: Math.max(view.west, ground.west),
    north: Math.min(view.north, ground.north), east: Math.min(view.east, ground.east),
  };
  return piece.south < piece.north && piece.west < piece.east ? piece : null;
}
