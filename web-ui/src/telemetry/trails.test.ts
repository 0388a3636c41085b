import { describe, expect, it } from 'vitest';
import { TRAIL_POINTS, Trails } from './trails';

function points(trails: Trails, index: number): [number, number][] {
  const all: [number, number][] = [];
  trails.forEach(index, (north, east) => all.push([north, east]));
  return all;
}

describe('Trails', () => {
  it('takes a point only after a metre of way', () => {
    const trails = new Trails(2);
    for (const north of [0, 0.4, 0.9, 1.1, 1.5, 2.3]) trails.push(1, north, 0);
    expect(points(trails, 1).map(([n]) => Math.round(n * 10) / 10)).toEqual([0, 1.1, 2.3]);
    expect(trails.length(0)).toBe(0);
  });

  it('forgets the oldest when it is full', () => {
    const trails = new Trails(1);
    for (let k = 0; k < TRAIL_POINTS + 10; k++) trails.push(0, k * 2, -k);
    const all = points(trails, 0);
    expect(all).toHaveLength(TRAIL_POINTS);
    expect(all[0]).toEqual([20, -10]);
    expect(all.at(-1)).toEqual([(TRAIL_POINTS + 9) * 2, -(TRAIL_POINTS + 9)]);
  });

  it('keeps what it has when it grows', () => {
    const trails = new Trails(1);
    trails.push(0, 5, 6);
    trails.grow(8);
    trails.push(7, 1, 2);
    expect(points(trails, 0)).toEqual([[5, 6]]);
    expect(points(trails, 7)).toEqual([[1, 2]]);
  });
});
