import { describe, expect, it } from 'vitest';
import { errorEllipse, errorRings, heightErrorM } from './errorShape';
import type { Covariance } from './errorShape';

const RIGHT_ANGLE = Math.PI / 2;

describe('the ellipse of two standard deviations', () => {
  it('lies along north or east where these are independent', () => {
    expect(errorEllipse([25, 0, 0, 4, 0, 1])).toEqual({ longM: 10, shortM: 4, headingRad: 0 });
    const east = errorEllipse([4, 0, 0, 25, 0, 1])!;
    expect([east.longM, east.shortM, east.headingRad]).toEqual([10, 4, RIGHT_ANGLE]);
  });

  it('is turned to where north and east go together', () => {
    // 5 m along 30° from north, 1 m across.
    const [cos, sin] = [Math.cos(Math.PI / 6), Math.sin(Math.PI / 6)];
    const turned = errorEllipse([25 * cos * cos + sin * sin, 24 * cos * sin, 0, 25 * sin * sin + cos * cos, 0, 1])!;
    expect(turned.longM).toBeCloseTo(10, 9);
    expect(turned.shortM).toBeCloseTo(2, 9);
    expect(turned.headingRad).toBeCloseTo(Math.PI / 6, 9);
  });

  it('is a circle where both are alike, and a line where one is certain', () => {
    expect(errorEllipse([9, 0, 0, 9, 0, 9])).toEqual({ longM: 6, shortM: 6, headingRad: 0 });
    const line = errorEllipse([1, 1, 0, 1, 0, 1])!;
    expect(line.longM).toBeCloseTo(2 * Math.SQRT2, 9);
    expect(line.shortM).toBeCloseTo(0, 6);
    expect(line.headingRad).toBeCloseTo(Math.PI / 4, 9);
  });

  it.each<[string, Covariance | null]>([['nobody says it', null], ['it is no number', [NaN, 0, 0, 1, 0, 1]], ['it cannot be', [-1, 0, 0, 1, 0, 1]]])('is not drawn where %s', (_, covariance) => {
    expect(errorEllipse(covariance)).toBeNull();
  });
});

describe('in space', () => {
  it('three lines lie on the ellipsoid', () => {
    const rings = errorRings([9, 0, 0, 4, 0, 1]);
    expect(rings).toHaveLength(3);
    for (const { north, east, up } of rings.flat()) expect((north / 6) ** 2 + (east / 4) ** 2 + (up / 2) ** 2).toBeCloseTo(1, 9);
  });

  it('... also where its axes are aslant', () => {
    // The inverse of this covariance, by hand: [[2, -1, 0], [-1, 2, 0], [0, 0, 3]] / 3.
    for (const { north, east, up } of errorRings([2, 1, 0, 2, 0, 1]).flat()) {
      expect((2 * north * north - 2 * north * east + 2 * east * east + 3 * up * up) / 3).toBeCloseTo(4, 9);
    }
  });

  it('height is known to two standard deviations, or not at all', () => {
    expect([heightErrorM([1, 0, 0, 1, 0, 9]), heightErrorM(null), errorRings(null)]).toEqual([6, null, []]);
  });
});
