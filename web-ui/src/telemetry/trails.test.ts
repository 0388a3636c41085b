import { describe, expect, it } from 'vitest';
import { TRAIL_POINTS, Trails } from './trails';

type Point = [north: number, east: number, altitude: number];

function points(trails: Trails, index: number, from = 0, to = Infinity, stride = 1): Point[] {
  const all: Point[] = [];
  trails.visit(index, from, to, stride, (...point) => all.push(point));
  return all;
}

describe('Trails', () => {
  it('takes a point only after a metre of way', () => {
    const trails = new Trails(2);
    for (const north of [0, 0.4, 0.9, 1.1, 1.5, 2.3]) trails.push(1, north, 0, 500);
    expect(points(trails, 1).map(([n]) => Math.round(n * 10) / 10)).toEqual([0, 1.1, 2.3]);
    expect(trails.length(0)).toBe(0);
  });

  it('a climb on the spot is way too', () => {
    const trails = new Trails(1);
    for (const altitude of [488, 488.5, 489.25, 491]) trails.push(0, 3, 4, altitude);
    expect(points(trails, 0)).toEqual([[3, 4, 488], [3, 4, 489.25], [3, 4, 491]]);
  });

  it('forgets the oldest when it is full', () => {
    const trails = new Trails(1);
    for (let k = 0; k < TRAIL_POINTS + 10; k++) trails.push(0, k * 2, -k, 0);
    const all = points(trails, 0);
    expect(all).toHaveLength(TRAIL_POINTS);
    expect(all[0]).toEqual([20, -10, 0]);
    expect(all.at(-1)).toEqual([(TRAIL_POINTS + 9) * 2, -(TRAIL_POINTS + 9), 0]);
  });

  it('keeps what it has when it grows', () => {
    const trails = new Trails(1);
    trails.push(0, 5, 6, 7);
    trails.grow(8);
    trails.push(7, 1, 2, 3);
    expect(points(trails, 0)).toEqual([[5, 6, 7]]);
    expect(points(trails, 7)).toEqual([[1, 2, 3]]);
  });

  it('gives a part, thinned out, and always its newest point', () => {
    const trails = new Trails(1);
    for (let k = 0; k < 10; k++) trails.push(0, k * 2, 0, 0);
    expect(points(trails, 0, 2, 5).map(([n]) => n)).toEqual([4, 6, 8]);
    expect(points(trails, 0, 0, 10, 4).map(([n]) => n)).toEqual([0, 8, 16, 18]);
    expect(points(trails, 0, 9, 10, 4).map(([n]) => n)).toEqual([18]);
    expect(points(trails, 0, 10, 20)).toEqual([]);
  });
});
