// Tiles of the web's usual pyramid (Web Mercator): where they are on Earth, and which of them a piece of the map needs. Pure.

export type Tile = { z: number; x: number; y: number };
export type Degrees = { latitudeDeg: number; longitudeDeg: number };
/** A piece of Earth in degrees. */
export type Piece = { south: number; west: number; north: number; east: number };

const EARTH_CIRCUMFERENCE_M = 40_075_016.686;
const TILE_PX = 256;
/** The pyramid ends there. */
const MERCATOR_LIMIT_DEG = 85.0511;
const RAD = Math.PI / 180;

/** Column and row of a place, with the part of the tile behind the point. */
export function tileAt(latitudeDeg: number, longitudeDeg: number, z: number): { x: number; y: number } {
  const n = 2 ** z;
  const lat = Math.max(-MERCATOR_LIMIT_DEG, Math.min(MERCATOR_LIMIT_DEG, latitudeDeg)) * RAD;
  return { x: ((longitudeDeg + 180) / 360) * n, y: ((1 - Math.asinh(Math.tan(lat)) / Math.PI) / 2) * n };
}

/** The upper left corner of a tile; that of the next one is its lower right. */
export function cornerOf(z: number, x: number, y: number): Degrees {
  const n = 2 ** z;
  return { latitudeDeg: Math.atan(Math.sinh(Math.PI * (1 - (2 * y) / n))) / RAD, longitudeDeg: (x / n) * 360 - 180 };
}

/** The level whose tiles are about as fine as the map is. */
export function levelFor(metresPerPixel: number, latitudeDeg: number, least: number, most: number): number {
  const exact = Math.log2((EARTH_CIRCUMFERENCE_M * Math.cos(latitudeDeg * RAD)) / TILE_PX / metresPerPixel);
  if (!Number.isFinite(exact)) return least;
  return Math.max(least, Math.min(most, Math.round(exact)));
}

/** The tiles of a level that lie in a piece of Earth, nearest to its middle first, `most` of them. */
export function tilesOf(piece: Piece, z: number, most: number): Tile[] {
  const n = 2 ** z;
  const from = tileAt(piece.north, piece.west, z);
  const to = tileAt(piece.south, piece.east, z);
  const [x0, x1] = [Math.max(0, Math.floor(from.x)), Math.min(n - 1, Math.floor(to.x))];
  const [y0, y1] = [Math.max(0, Math.floor(from.y)), Math.min(n - 1, Math.floor(to.y))];
  // A level that is far too fine for the piece would make a list without end.
  if (!((x1 - x0 + 1) * (y1 - y0 + 1) <= most * 4)) return [];
  const middle = { x: (from.x + to.x) / 2 - 0.5, y: (from.y + to.y) / 2 - 0.5 };
  const tiles: Tile[] = [];
  for (let y = y0; y <= y1; y++) for (let x = x0; x <= x1; x++) tiles.push({ z, x, y });
  const distance = (t: Tile) => Math.hypot(t.x - middle.x, t.y - middle.y);
  return tiles.sort((a, b) => distance(a) - distance(b)).slice(0, most);
}
