import { describe, expect, it } from 'vitest';
import { FARTHEST_M, NEAREST_M, Orbit } from './orbit';

function orbit(): Orbit {
  const o = new Orbit();
  o.width = 800;
  o.height = 600;
  o.bearingRad = 0;
  o.lookAt(100, 50, 10);
  return o;
}

function at(o: Orbit, north: number, east: number, up: number): { x: number; y: number; depth: number } {
  const out = { x: 0, y: 0, depth: 0 };
  o.project(north, east, up, out);
  return out;
}

describe('Orbit', () => {
  it('what it looks at is in the middle, as far away as the camera is', () => {
    const o = orbit();
    for (const [bearing, down] of [[0, 0.2], [2, 0.7], [-1, 1.4]] as const) {
      o.bearingRad = bearing;
      o.downRad = down;
      const middle = at(o, 100, 50, 10);
      expect([middle.x, middle.y, middle.depth].map((v) => Math.round(v * 1e6) / 1e6)).toEqual([400, 300, 80]);
    }
  });

  it('looking north, east is right, high is up and far is further up', () => {
    const o = orbit();
    expect(at(o, 100, 60, 10).x).toBeGreaterThan(400);
    expect(at(o, 100, 50, 20).y).toBeLessThan(300);
    expect(at(o, 120, 50, 10).y).toBeLessThan(300);
    expect(at(o, 120, 50, 10).depth).toBeGreaterThan(80);
  });

  it('looking east, north is left', () => {
    const o = orbit();
    o.turn(Math.PI / 2, 0);
    expect(at(o, 110, 50, 10).x).toBeLessThan(400);
  });

  it('what is behind the camera is nowhere in the picture', () => {
    expect(at(orbit(), -500, 50, 10).x).toBeNaN();
  });

  it('a pixel is as wide as it says', () => {
    const o = orbit();
    expect(at(o, 100, 50 + o.metresPerPixel(80) * 37, 10).x).toBeCloseTo(437, 6);
  });

  it('a drag moves the ground with the finger', () => {
    const o = orbit();
    o.bearingRad = 0.8;
    const before = at(o, 100, 50, 10);
    o.panBy(40, 0);
    expect(at(o, 100, 50, 10).x).toBeCloseTo(before.x + 40, 6);
    o.panBy(0, 25);
    expect(at(o, 100, 50, 10).y).toBeGreaterThan(before.y + 10);
  });

  it('stays above the ground, short of straight down, and within reach', () => {
    const o = orbit();
    o.turn(0, -9);
    expect(o.downRad).toBeGreaterThan(0);
    o.turn(0, 9);
    expect(o.downRad).toBeLessThan(Math.PI / 2);
    o.zoom(1e9);
    expect(o.distanceM).toBe(NEAREST_M);
    o.zoom(1e-9);
    expect(o.distanceM).toBe(FARTHEST_M);
  });

  it.each([[800, 600], [300, 900]])('a fit shows all of a box in a picture of %d by %d', (width, height) => {
    const o = orbit();
    [o.width, o.height] = [width, height];
    const box = { minNorth: -40, maxNorth: 90, minEast: 10, maxEast: 60, maxUp: 30 };
    o.fit(box);
    for (const north of [-40, 90]) {
      for (const east of [10, 60]) {
        for (const up of [0, 30]) {
          const { x, y } = at(o, north, east, up);
          expect(x).toBeGreaterThan(0);
          expect(x).toBeLessThan(width);
          expect(y).toBeGreaterThan(0);
          expect(y).toBeLessThan(height);
        }
      }
    }
    expect(o.isOff(box)).toBe(false);
    expect(o.isOff({ ...box, maxNorth: 400 })).toBe(true);
    expect(o.isOff({ ...box, minNorth: 20, maxNorth: 30, maxUp: 3, minEast: 30, maxEast: 40 })).toBe(true);
  });
});
