import { describe, expect, it } from 'vitest';
import type { ItemStatus, PreflightAnswer, PreflightItem } from '../protocol/types';
import { limitText, mayBeOverridden, overrideOf, viewOf } from './preflight';

const item = (id: string, status: ItemStatus): PreflightItem => ({
  id, title: id, status, value: '5', number: 5, unit: 'm', limit: 6, why: 'because', may_be_overridden: status === 'red' && id !== 'position',
});
const report = (vehicle: number | null, ...items: PreflightItem[]) => ({ vehicle, items, made_at: 0 });
const ANSWER: PreflightAnswer = {
  swarm: report(null, item('coordinator', 'green')),
  vehicles: [
    report(1, item('on_ground', 'not_applicable'), item('link', 'green'), item('battery', 'amber')),
    report(2, item('on_ground', 'red'), item('link', 'green')),
    report(3, item('link', 'green'), item('home', 'red')),
  ],
  overrides: [],
};

describe('viewOf', () => {
  it('the swarm first, then the worst vehicles, and of each the red items first', () => {
    const view = viewOf(ANSWER, () => false);
    expect(view.reports.map((r) => r.report.vehicle)).toEqual([null, 2, 3, 1]);
    expect(view.reports[2]!.items.map((i) => i.status)).toEqual(['red', 'green']);
    expect(view.counts).toEqual({ red: 2, amber: 1, green: 4, not_applicable: 1 });
  });

  it('what flies is not counted and stands last', () => {
    const view = viewOf(ANSWER, (id) => id === 2);
    expect(view.counts).toEqual({ red: 1, amber: 1, green: 3, not_applicable: 1 });
    expect(view.reports.map((r) => r.report.vehicle)).toEqual([null, 3, 1, 2]);
    expect(view.reports.at(-1)!.flying).toBe(true);
  });
});

describe('overrides', () => {
  const given = { operator: 'anna', reason: 'test', items: ['home'], vehicle: 3, given_at: 1_000_000, valid_s: 60 };

  it('hold for their vehicle, their items and their time', () => {
    expect(overrideOf(item('home', 'red'), 3, [given], 30_000_000)).toBe(given);
    expect(overrideOf(item('home', 'red'), 2, [given], 30_000_000)).toBeUndefined();
    expect(overrideOf(item('home', 'red'), null, [given], 30_000_000)).toBeUndefined();
    expect(overrideOf(item('link', 'red'), 3, [given], 30_000_000)).toBeUndefined();
    expect(overrideOf(item('home', 'red'), 3, [given], 61_500_000)).toBeUndefined();
  });

  it('are offered for red items, but not for those that nobody can override', () => {
    expect(mayBeOverridden(item('home', 'red'))).toBe(true);
    expect(mayBeOverridden(item('home', 'amber'))).toBe(false);
    expect(mayBeOverridden(item('position', 'red'))).toBe(false);
  });
});

it('a limit has its unit, and none is said where there is none', () => {
  expect(limitText(item('x', 'red'))).toBe('limit 6 m');
  expect(limitText({ ...item('x', 'red'), limit: null })).toBe('');
});
