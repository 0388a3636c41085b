import { describe, expect, it } from 'vitest';
import { cornerOf, levelFor, tileAt, tilesOf } from './tileMath';

describe('tileAt', () => {
  it.each([
    [0, 0, 1, 1, 1],
    [51.5074, -0.1278, 10, 511, 340],
    [47.397742, 8.545594, 17, 68647, 45888],
  ])('%d, %d is on level %d in tile %d/%d', (latitude, longitude, z, x, y) => {
    const at = tileAt(latitude, longitude, z);
    expect([Math.floor(at.x), Math.floor(at.y)]).toEqual([x, y]);
  });

  it('goes from a corner to the tile and back', () => {
    const corner = cornerOf(15, 17_161, 11_477);
    const at = tileAt(corner.latitudeDeg, corner.longitudeDeg, 15);
    expect(at.x).toBeCloseTo(17_161, 6);
    expect(at.y).toBeCloseTo(11_477, 6);
  });
});

describe('levelFor', () => {
  it('a pixel of the equator on level 0 is as wide as the Earth in 256', () => {
    expect(levelFor(156_543, 0, 0, 22)).toBe(0);
    expect(levelFor(156_543 / 2 ** 17, 0, 0, 22)).toBe(17);
    expect(levelFor(156_543 / 2 ** 17, 60, 0, 22)).toBe(16);
  });

  it('stays within what the file has', () => {
    expect(levelFor(0.01, 47, 5, 14)).toBe(14);
    expect(levelFor(1e6, 47, 5, 14)).toBe(5);
    expect(levelFor(0, 47, 5, 14)).toBe(5);
  });
});

describe('tilesOf', () => {
  it('covers a piece, its middle first', () => {
    const a = cornerOf(10, 500.2, 300.2);
    const b = cornerOf(10, 502.8, 302.8);
    const tiles = tilesOf({ north: a.latitudeDeg, west: a.longitudeDeg, south: b.latitudeDeg, east: b.longitudeDeg }, 10, 50);
    expect(tiles).toHaveLength(9);
    expect(tiles[0]).toEqual({ z: 10, x: 501, y: 301 });
    expect(tilesOf({ north: a.latitudeDeg, west: a.longitudeDeg, south: b.latitudeDeg, east: b.longitudeDeg }, 10, 3)).toHaveLength(3);
  });

  it('is empty where the level is much too fine, and for what is no piece', () => {
    expect(tilesOf({ north: 80, west: -170, south: -80, east: 170 }, 15, 50)).toEqual([]);
    expect(tilesOf({ north: NaN, west: NaN, south: NaN, east: NaN }, 3, 50)).toEqual([]);
  });
});
