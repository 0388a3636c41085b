import { describe, expect, it } from 'vitest';
import { columnsFor, compareBy, linesOf, windowOf } from './fleetColumns';
import type { Sortable } from './fleetColumns';

const vehicle = (id: number, over: Partial<Sortable> = {}): Sortable => ({
  id, name: `uav-${id}`, level: 0, flightState: 'idle', mode: 'hold', armed: false, battery: 90, satellites: 12, fix: 'three_d', loss: 0,
  heightM: 0, speedMS: 0, errorM: NaN, ageMs: 50, returnS: 300, pluginsLevel: 0, pluginsText: '1 running', plugin: 'generic-uav', node: null,
  airborne: false, leader: false, holder: '', ...over,
});
const ids = (rows: Sortable[]): number[] => rows.map((row) => row.id);

describe('the columns', () => {
  it('are fewer where there is less room, and never without who and what', () => {
    expect(columnsFor(280).map((c) => c.key)).toEqual(['id', 'state']);
    expect(columnsFor(380).map((c) => c.key)).toEqual(['id', 'state', 'link']);
    const wide = columnsFor(2000).map((c) => c.key);
    expect(wide).toHaveLength(13);
    // Who has a vehicle is a column only where somebody has one.
    expect(wide).not.toContain('authority');
    expect(columnsFor(2000, true).map((c) => c.key)).toContain('authority');
    for (let width = 280; width < 2000; width += 37) {
      const shown = columnsFor(width);
      expect(shown.reduce((sum, c) => sum + c.leastPx, 68)).toBeLessThanOrEqual(Math.max(width, 272));
    }
  });
});

describe('the order', () => {
  it('is by the column either way, and the unknown comes last both times', () => {
    const rows = [vehicle(1, { battery: 50 }), vehicle(2, { battery: null }), vehicle(3, { battery: 20 }), vehicle(4, { battery: 50 })];
    expect(ids([...rows].sort(compareBy('battery', false)))).toEqual([3, 1, 4, 2]);
    expect(ids([...rows].sort(compareBy('battery', true)))).toEqual([1, 4, 3, 2]);
  });

  it('puts the most urgent and the staler first', () => {
    const rows = [vehicle(1), vehicle(2, { level: 3, ageMs: 9000 }), vehicle(3, { level: 2 })];
    expect(ids([...rows].sort(compareBy('attention', false)))).toEqual([2, 3, 1]);
    expect(ids([...rows].sort(compareBy('link', false)))[0]).toBe(2);
  });
});

describe('groups', () => {
  it('stand under heads that count them, worst first', () => {
    const rows = [vehicle(1), vehicle(2, { level: 3 }), vehicle(3)];
    const lines = linesOf(rows, 'attention');
    expect(lines.map((line) => (line.kind === 'group' ? `${line.words} ${line.rows.length}` : line.row.id))).toEqual(['Critical 1', 2, 'Normal 2', 1, 3]);
    expect(linesOf(rows, 'none')).toHaveLength(3);
    const held = [vehicle(1), vehicle(2, { holder: 'Ben' }), vehicle(3, { holder: 'Anna' })];
    expect(linesOf(held, 'authority').flatMap((line) => (line.kind === 'group' ? [line.words] : []))).toEqual(['Anna', 'Ben', "Under nobody's control"]);
    expect(linesOf([vehicle(1, { airborne: true }), vehicle(2)], 'place')[0]).toMatchObject({ words: 'In the air' });
  });
});

describe('the window', () => {
  it('covers what is seen and a little more, and stays within the list', () => {
    expect(windowOf(0, 400, 40, 200)).toEqual({ from: 0, to: 16 });
    expect(windowOf(4000, 400, 40, 200)).toEqual({ from: 94, to: 116 });
    expect(windowOf(99999, 400, 40, 200)).toEqual({ from: 200, to: 200 });
    expect(windowOf(0, 400, 40, 0)).toEqual({ from: 0, to: 0 });
  });
});
