import { describe, expect, it } from 'vitest';
import { bearingText, leg, legText, legs, totalM } from './measure';
import type { MeasurePoint, Spot } from './measure';

const spot = (north: number, east: number, up: number | null = null): Spot => ({ north, east, up, words: '' });

describe('leg', () => {
  it.each([
    [10, 0, 10, 0],
    [0, 10, 10, 90],
    [-10, 0, 10, 180],
    [0, -10, 10, 270],
    [30, -40, 50, 306.8699],
  ])('%d m north and %d m east are %d m at %d°', (north, east, distance, bearing) => {
    const l = leg(spot(5, 6), spot(5 + north, 6 + east));
    expect(l.distanceM).toBeCloseTo(distance, 9);
    expect(l.bearingDeg).toBeCloseTo(bearing, 3);
  });

  it('has no bearing on the spot and no rise where a height is not known', () => {
    expect(leg(spot(1, 1), spot(1, 1)).bearingDeg).toBeNull();
    expect(leg(spot(0, 0, 10), spot(1, 0)).riseM).toBeNull();
    expect(leg(spot(0, 0, 10), spot(1, 0, 4)).riseM).toBe(-6);
  });
});

describe('legs', () => {
  const points: MeasurePoint[] = [{ kind: 'place', north: 0, east: 0 }, { kind: 'vehicle', id: 7 }, { kind: 'place', north: 3, east: 8 }];

  it('go by where the vehicle is now', () => {
    expect(legs(points, () => spot(3, 4)).map((l) => l.distanceM)).toEqual([5, 4]);
    expect(totalM(legs(points, () => spot(0, 8)))).toBe(11);
  });

  it('a vehicle whose place is not known is left out, not put at the origin', () => {
    expect(legs(points, () => null)).toHaveLength(1);
    expect(legs(points.slice(0, 2), () => null)).toEqual([]);
  });
});

describe('words', () => {
  it.each([[0, '000°'], [7.4, '007°'], [359.7, '000°'], [null, '–']])('bearing %s reads %s', (degrees, text) => {
    expect(bearingText(degrees)).toBe(text);
  });

  it('says how much higher the second is', () => {
    expect(legText(leg(spot(0, 0, 3), spot(0, 20, 1.5)))).toBe('20.0 m, 090°, −1.5 m up');
    expect(legText(leg(spot(0, 0), spot(0, 20)))).toBe('20.0 m, 090°');
  });
});
