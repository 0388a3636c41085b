import { describe, expect, it } from 'vitest';
import { boxOf, levelFor, levelsOf, patchesIn, pictureFor } from './pixelPyramid';

const size = (widthPx: number, heightPx: number) => ({ widthPx, heightPx });

describe('levels', () => {
  it('end with one patch', () => {
    expect([levelsOf(size(1, 1)), levelsOf(size(256, 256)), levelsOf(size(257, 3)), levelsOf(size(3, 1024)), levelsOf(size(20_000, 30_000))]).toEqual([1, 1, 2, 3, 8]);
  });

  it('are as fine as the map', () => {
    const at = (metresPerPixel: number) => levelFor(metresPerPixel, 0.05, 7);
    expect([at(0.01), at(0.05), at(0.1), at(0.4), at(1e6), at(0), at(NaN)]).toEqual([0, 0, 1, 3, 6, 0, 0]);
  });
});

describe('pictureFor', () => {
  const pictures = [size(10_001, 8000), size(5001, 4000), size(2501, 2000), size(626, 500)];

  it.each([[0, 0, 1], [1, 1, 1], [2, 2, 1], [3, 2, 2], [4, 3, 1], [6, 3, 4]])('level %d is read from picture %d, every %dth pixel', (level, index, step) => {
    const found = pictureFor(level, pictures);
    expect(found.index).toBe(index);
    expect(found.step).toBeCloseTo(step, 1);
  });

  it('without overviews it is always the full one', () => {
    expect(pictureFor(5, [size(9000, 9000)])).toEqual({ index: 0, step: 32 });
  });

  it('takes one that was rounded down for what was meant', () => {
    expect(pictureFor(1, [size(1001, 999), size(500, 499)]).index).toBe(1);
  });
});

describe('patches', () => {
  it('are those in a box, the middle first', () => {
    const places = patchesIn({ left: 300, top: 300, right: 900, bottom: 900 }, 0, size(2000, 2000), 80)!;
    expect(places).toHaveLength(9);
    expect(places[0]).toEqual({ level: 0, column: 2, row: 2 });
    expect(patchesIn({ left: 300, top: 300, right: 900, bottom: 900 }, 0, size(2000, 2000), 8)).toBeNull();
  });

  it('are none outside, and none of what is no box', () => {
    const where = size(2000, 2000);
    expect(patchesIn({ left: 2100, top: 0, right: 2200, bottom: 10 }, 0, where, 80)).toEqual([]);
    expect(patchesIn({ left: NaN, top: NaN, right: NaN, bottom: NaN }, 0, where, 80)).toEqual([]);
  });

  it('end at the edge, with a whole pixel of their level', () => {
    expect(boxOf({ level: 0, column: 3, row: 0 }, size(1000, 1000))).toEqual({ left: 768, top: 0, right: 1000, bottom: 256, widthPx: 232, heightPx: 256 });
    expect(boxOf({ level: 2, column: 0, row: 0 }, size(999, 1000))).toEqual({ left: 0, top: 0, right: 1000, bottom: 1000, widthPx: 250, heightPx: 250 });
  });
});
