// What the map writes along its rulers, at every zoom and in both systems of units.

import { afterEach, describe, expect, it } from 'vitest';
import type { Console } from '../../app/console.svelte';
import { units } from '../../language/units.svelte';
import type { UnitSystem } from '../../language/units.svelte';
import { FenceCache } from './fenceCache';
import { paintFurniture, paintGrid } from './paintGround';
import { paintLadder } from './paintLadder';
import type { Palette } from './palette';
import { MAX_SCALE, MIN_SCALE, View } from './view';

afterEach(() => {
  units.name = 'metric';
});

const PALETTE = {} as Palette;

function written(paint: (ctx: CanvasRenderingContext2D) => void): string[] {
  const texts: string[] = [];
  const nothing = (): void => {};
  const ctx = new Proxy({} as Record<string, unknown>, {
    get: (_, name: string) => (name === 'fillText' ? (text: string) => void texts.push(text) : nothing),
    set: () => true,
  });
  paint(ctx as unknown as CanvasRenderingContext2D);
  return texts;
}

function viewAt(scale: number): View {
  const view = new View();
  [view.width, view.height, view.scale] = [1440, 900, scale];
  return view;
}

const SCALES = Array.from({ length: 40 }, (_, k) => MIN_SCALE * (MAX_SCALE / MIN_SCALE) ** (k / 39));
const LABEL: Record<UnitSystem, RegExp> = {
  metric: /^(0|\d+ cm [NSEW]|\d+(\.\d{1,3})? k?m [NSEW])$/,
  aviation: /^(0|\d+(\.\d{1,2})? (ft|NM) [NSEW])$/,
};

describe.each(['metric', 'aviation'] as const)('%s', (system) => {
  it('the grid is labelled with round numbers in one or two units, never the same twice', () => {
    units.name = system;
    for (const scale of SCALES) {
      const labels = written((ctx) => paintGrid(ctx, viewAt(scale), PALETTE));
      expect(labels.length, `${scale}`).toBeGreaterThan(4);
      for (const label of labels) expect(label).toMatch(LABEL[system]);
      const alongEast = labels.filter((label) => /[EW]$/.test(label));
      expect(new Set(alongEast).size).toBe(alongEast.length);
      if (system === 'aviation') expect(new Set(labels.filter((label) => label !== '0').map((label) => label.split(' ')[1])).size).toBe(1);
    }
  });

  it('the scale bar has a round length that it says rightly', () => {
    units.name = system;
    const metresOf: Record<string, number> = { cm: 0.01, m: 1, km: 1000, ft: 0.3048, NM: 1852 };
    for (const scale of SCALES) {
      let corner = 0;
      const ends: number[] = [];
      const texts = written((ctx) => {
        const spied = new Proxy(ctx, { get: (of, name) => (name === 'lineTo' ? (x: number) => void ends.push(x) : Reflect.get(of, name)) });
        paintFurniture(spied, viewAt(scale), PALETTE);
        corner = ends[0] ?? 0;
      });
      const [figure, unit] = texts[0]!.split(' ');
      expect(figure).toMatch(/^0?\.?0*[125]0*$/);
      const px = Math.max(...ends.slice(0, 3)) - corner;
      expect(Number(figure) * metresOf[unit!]! * scale).toBeCloseTo(px, 6);
      expect(px).toBeLessThanOrEqual(120 + 1e-9);
    }
  });
});

it('the ladder of heights ends at a round number of what is shown', () => {
  const rungs = [{ heightM: 60, level: 0, leader: false, selected: false }];
  const paint = () => written((ctx) => paintLadder(ctx, viewAt(1), PALETTE, rungs));
  expect(paint()).toEqual(['0', '20', '40', '60', '80', '100 m high']);
  units.name = 'aviation';
  expect(paint()).toEqual(['0', '100', '200', '300', '400', '500 ft high']);
});

it('names of fences are written anew in other units, and only then', () => {
  const zone = { name: 'field', kind: 'inclusion', outline: { shape: 'local_circle', centre_m: [0, 0], radius_m: 9 }, floor_m: null, ceiling_m: 60, altitude_reference: 'origin' };
  const app = { watch: { fences: { plan: { zones: [zone], breach_return: null } } }, session: { fleet: { projection: null } } };
  const cache = new FenceCache(app as unknown as Console);
  const first = cache.get();
  expect([first.zones[0]!.text, cache.get() === first]).toEqual(['field: stay inside, up to 60 m', true]);
  units.name = 'aviation';
  expect(cache.get().zones[0]!.text).toBe('field: stay inside, up to 197 ft');
});
