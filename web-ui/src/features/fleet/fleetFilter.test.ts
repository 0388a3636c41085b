import { describe, expect, it } from 'vitest';
import { compare, inCategory, matchesSearch, parseIds } from './fleetFilter';
import type { Listed } from './fleetFilter';

const row = (id: number, more: Partial<Listed> = {}): Listed => ({
  id, name: `uav-${id}`, level: 0, airborne: false, battery: 50, flightState: 'idle', mode: 'ready', staleness: 'live', problems: '', holder: '', mine: false, ...more,
});

describe('parseIds', () => {
  it.each([
    ['3', [3]],
    ['1-3', [1, 2, 3]],
    ['1–2, 7', [1, 2, 7]],
    ['4 6', [4, 6]],
  ])('%s', (text, expected) => {
    expect([...(parseIds(text) ?? [])]).toEqual(expected);
  });

  it.each(['', 'uav-3', '1-', 'hold', '3,'])('%s is no list of numbers', (text) => {
    expect(parseIds(text)).toBeNull();
  });

  it('a huge range does not take the page down', () => {
    expect(parseIds('1-99999999')?.size).toBe(10_000);
  });
});

describe('matchesSearch', () => {
  it('a number means that vehicle and no other', () => {
    expect([3, 13, 30].filter((id) => matchesSearch(row(id), '3'))).toEqual([3]);
  });

  it('words are looked for in name, state and problems as they are read', () => {
    const landing = row(1, { flightState: 'taking_off', problems: 'battery low' });
    expect(matchesSearch(landing, 'taking off')).toBe(true);
    expect(matchesSearch(landing, 'LOW')).toBe(true);
    expect(matchesSearch(landing, 'uav-1')).toBe(true);
    expect(matchesSearch(landing, 'holding')).toBe(false);
    expect([matchesSearch(row(1, { holder: 'Anna' }), 'anna'), matchesSearch(landing, 'anna')]).toEqual([true, false]);
  });
});

describe('inCategory', () => {
  it('without a selection every vehicle is a target', () => {
    expect(inCategory(row(1), 'targets', new Set())).toBe(false);
    expect(inCategory(row(1), 'targets', new Set([2]))).toBe(false);
    expect([inCategory(row(1, { mine: true }), 'mine', new Set()), inCategory(row(1), 'mine', new Set())]).toEqual([true, false]);
  });
});

describe('compare', () => {
  it('urgent first, then by number', () => {
    const rows = [row(1), row(2, { level: 3 }), row(3), row(4, { level: 3 })];
    expect(rows.sort(compare('urgency')).map((r) => r.id)).toEqual([2, 4, 1, 3]);
  });

  it('a battery that is not known comes after all that are', () => {
    const rows = [row(1, { battery: null }), row(2, { battery: 100 }), row(3, { battery: 5 })];
    expect(rows.sort(compare('battery')).map((r) => r.id)).toEqual([3, 2, 1]);
  });
});
