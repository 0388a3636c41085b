import { describe, expect, it } from 'vitest';
import { LINE, LineSet } from './lineSet';

const lines = (set: LineSet) => Array.from({ length: set.count }, (_, k) => [...set.data.subarray(k * LINE, (k + 1) * LINE)]);

describe('LineSet', () => {
  it('holds as many lines as come, and forgets them together', () => {
    const set = new LineSet('trail', 1);
    for (let k = 0; k < 500; k++) set.add(k, 1, 2, 3, 4, 5);
    expect(lines(set)[499]).toEqual([499, 1, 2, 3, 4, 5]);
    set.clear();
    expect(lines(set)).toEqual([]);
    set.add(7, 7, 7, 8, 8, 8);
    expect(lines(set)).toEqual([[7, 7, 7, 8, 8, 8]]);
  });

  it('breaks a line into pieces', () => {
    const set = new LineSet('trail', 1);
    set.broken([0, 0, 0], [20, 0, 10], 2, 0.5);
    expect(lines(set)).toEqual([[0, 0, 0, 5, 0, 2.5], [10, 0, 5, 15, 0, 7.5]]);
  });

  it('a ring ends where it began, and every corner is on it', () => {
    const set = new LineSet('slot', 1);
    set.ring(10, -5, 3, 2, 12);
    const all = lines(set);
    expect(all).toHaveLength(12);
    for (const [north, east, up] of all) {
      expect(Math.hypot(north! - 10, east! + 5)).toBeCloseTo(2, 5);
      expect(up).toBe(3);
    }
    expect(all[11]![3]).toBeCloseTo(all[0]![0]!, 5);
    expect(all[11]![4]).toBeCloseTo(all[0]![1]!, 5);
  });
});
