import { describe, expect, it } from 'vitest';
import { MAX_SCALE, View, include, noBounds } from './view';

function view(): View {
  const v = new View();
  v.width = 800;
  v.height = 600;
  return v;
}

describe('View', () => {
  it('north is up and east is right', () => {
    const v = view();
    v.scale = 10;
    expect([v.x(0), v.y(0)]).toEqual([400, 300]);
    expect([v.x(5), v.y(5)]).toEqual([450, 250]);
  });

  it('goes from the ground to the screen and back', () => {
    const v = view();
    v.panBy(37, -12);
    v.zoomAt(120, 410, 1.7);
    expect(v.north(v.y(12.5))).toBeCloseTo(12.5, 9);
    expect(v.east(v.x(-3.25))).toBeCloseTo(-3.25, 9);
  });

  it('zooms about the pointer', () => {
    const v = view();
    const [north, east] = [v.north(100), v.east(700)];
    v.zoomAt(700, 100, 3);
    expect(v.north(100)).toBeCloseTo(north, 9);
    expect(v.east(700)).toBeCloseTo(east, 9);
    v.zoomAt(700, 100, 1e9);
    expect(v.scale).toBe(MAX_SCALE);
    expect(v.east(700)).toBeCloseTo(east, 9);
  });

  it('a drag moves the ground with the finger', () => {
    const v = view();
    const [north, east] = [v.north(300), v.east(200)];
    v.panBy(50, 20);
    expect(v.north(320)).toBeCloseTo(north, 9);
    expect(v.east(250)).toBeCloseTo(east, 9);
  });

  it('a fit shows everything inside the padding', () => {
    const v = view();
    const bounds = noBounds();
    include(bounds, 100, -40);
    include(bounds, -20, 300);
    v.fit(bounds, 50);
    expect(v.contains(bounds, 49.999)).toBe(true);
    expect(v.contains(bounds, 51)).toBe(false);
  });

  it('a fit leaves out what is covered at the right', () => {
    const v = view();
    const bounds = noBounds();
    include(bounds, 0, -400);
    include(bounds, 10, 300);
    v.fit(bounds, 40, 100);
    expect(v.x(-400)).toBeCloseTo(40, 6);
    expect(v.x(300)).toBeCloseTo(660, 6);
  });

  it('one vehicle does not fill the map', () => {
    const v = view();
    const bounds = noBounds();
    include(bounds, 7, 8);
    v.fit(bounds, 50);
    expect(v.north(300)).toBeCloseTo(7, 9);
    expect(v.scale).toBeLessThanOrEqual(600 / 30);
  });
});
