import { afterEach, describe, expect, it } from 'vitest';
import { units } from '../../language/units.svelte';
import type { OffsetFrd } from '../../protocol/types';
import { fitted, freeSpot, gridOf, groundOf, nearOnes, placeAdded, placeAt, placeRemoved, placeSet, snapped, toBoard, toGround } from './shapeBoard';
import { someShapes } from './someShapes';

const SIZE = { widthPx: 360, heightPx: 300 };
const at = (forward_m: number, right_m: number, down_m = 0): OffsetFrd => ({ forward_m, right_m, down_m });

afterEach(() => {
  units.name = 'metric';
});

describe('the view', () => {
  it('has forward up and right to the right', () => {
    const view = { forwardM: 0, rightM: 0, mPerPx: 0.1 };
    expect(toBoard(view, SIZE, { forwardM: 5, rightM: -3 })).toEqual({ xPx: 150, yPx: 100 });
  });

  it('leads from the ground to the board and back, for every shape', () => {
    for (const places of someShapes()) {
      const view = fitted(places, SIZE);
      for (const place of places) {
        const back = toGround(view, SIZE, toBoard(view, SIZE, groundOf(place)));
        expect(back.forwardM).toBeCloseTo(place.forward_m, 6);
        expect(back.rightM).toBeCloseTo(place.right_m, 6);
      }
    }
  });

  it('shows every place and the origin with room around them, and stays when it is asked for again', () => {
    for (const places of someShapes()) {
      const view = fitted(places, SIZE);
      for (const place of [at(0, 0), ...places]) {
        const { xPx, yPx } = toBoard(view, SIZE, groundOf(place));
        expect(Math.min(xPx, yPx, SIZE.widthPx - xPx, SIZE.heightPx - yPx)).toBeGreaterThan(26);
      }
      expect(fitted(places, SIZE, view)).toBe(view);
    }
  });

  it('shows twenty metres at least, grows for a place outside and shrinks when most of it is empty', () => {
    const small = fitted([at(0, 0)], SIZE);
    expect(small.mPerPx * (300 - 52)).toBeCloseTo(20, 6);
    const large = fitted([at(0, 0), at(-80, 0)], SIZE, small);
    expect(large.mPerPx).toBeGreaterThan(small.mPerPx);
    expect(fitted([at(0, 0), at(-40, 0)], SIZE, large)).toBe(large);
    expect(fitted([at(0, 0)], SIZE, large)).toEqual(small);
  });

  it('has a grid at round figures of the units, through the origin', () => {
    const view = fitted([at(0, 0), at(-15, 15)], SIZE);
    expect(gridOf(view, SIZE).stepM).toBe(5);
    const origin = toBoard(view, SIZE, { forwardM: 0, rightM: 0 });
    expect(gridOf(view, SIZE).xPx.some((x) => Math.abs(x - origin.xPx) < 1e-9)).toBe(true);
    units.name = 'aviation';
    expect(gridOf(view, SIZE).stepM).toBeCloseTo(10 * 0.3048, 9);
  });
});

describe('places', () => {
  it('snap to half a metre, and not farther out than is drawn', () => {
    expect([snapped(0.24), snapped(0.25), snapped(-3.3), snapped(-0.1), snapped(5e6), snapped(-5e6)]).toEqual([0, 0.5, -3.5, 0, 1000, -1000]);
    expect(snapped(0.30000000000000004, 0.1)).toBe(0.3);
  });

  it('are put, set and taken away, but the first one stays', () => {
    const two = placeAdded([at(0, 0)], { forwardM: -4.9, rightM: 3.1 });
    expect(two).toEqual([at(0, 0), at(-5, 3)]);
    expect(placeSet(two, 1, { down_m: -2 })).toEqual([at(0, 0), at(-5, 3, -2)]);
    expect(placeSet(two, 0, { down_m: -2 })).toEqual(two);
    expect(placeRemoved(two, 1)).toEqual([at(0, 0)]);
    expect(placeRemoved(two, 0)).toEqual(two);
  });

  it('keep every other place when one is changed, for every shape', () => {
    for (const places of someShapes()) {
      const which = places.length - 1;
      expect(placeSet(places, which, at(1, 2, 3)).slice(0, which)).toEqual(places.slice(0, which));
      expect(placeRemoved(placeAdded(places, { forwardM: 7, rightM: 7 }), places.length)).toEqual(places);
    }
  });

  it('are taken hold of by the nearest within reach', () => {
    const points = [{ xPx: 100, yPx: 100 }, { xPx: 120, yPx: 100 }];
    expect([placeAt(points, { xPx: 112, yPx: 100 }, 22), placeAt(points, { xPx: 108, yPx: 104 }, 22), placeAt(points, { xPx: 100, yPx: 130 }, 22)]).toEqual([1, 0, null]);
  });

  it('that are nearer than a metre are both marked, one above the other is not', () => {
    expect([...nearOnes([at(0, 0), at(-5, 0), at(-5.5, 0.5), at(-5, 0, -3)])].sort()).toEqual([1, 2]);
    expect(nearOnes([at(0, 0), at(1, 0)]).size).toBe(0);
  });

  it('find a free spot behind the last, which is near nobody, for every shape', () => {
    expect(freeSpot([at(0, 0), at(-5, 3)], 4)).toEqual({ forwardM: -9, rightM: 3 });
    expect(freeSpot([at(-4, 0), at(-8, 0), at(0, 0)], 4)).toEqual({ forwardM: -12, rightM: 0 });
    for (const places of someShapes()) {
      const spot = freeSpot(places, 3);
      expect(places.some((p) => Math.hypot(p.forward_m - spot.forwardM, p.right_m - spot.rightM, p.down_m) < 1)).toBe(false);
    }
  });
});
