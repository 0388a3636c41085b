import { describe, expect, it } from 'vitest';
import { LEVEL, problemsOf, worst } from './severity';
import type { Condition } from './severity';

const WELL: Condition = {
  staleness: 'live', flightState: 'holding', airborne: true, armed: true, batteryPercent: 80, lossPercent: 0, fix: 3,
  hasPosition: true, trackingErrorM: NaN, pilotControl: false, faulted: false, actor: 'running', model: 'running', degraded: false,
};
const texts = (c: Partial<Condition>) => problemsOf({ ...WELL, ...c }).map((p) => p.text);
const level = (c: Partial<Condition>) => worst(problemsOf({ ...WELL, ...c }));

describe('problemsOf', () => {
  it('a vehicle that is well has none', () => {
    expect(texts({})).toEqual([]);
    expect(level({})).toBe(LEVEL.normal);
  });

  it('a battery that is not known is not a low one', () => {
    expect(texts({ batteryPercent: NaN })).toEqual([]);
  });

  it('a lost link is critical in the air and for whatever may be in the air, a warning on the ground', () => {
    expect(level({ staleness: 'lost' })).toBe(LEVEL.critical);
    expect(level({ staleness: 'lost', airborne: false })).toBe(LEVEL.critical);
    expect(level({ staleness: 'lost', airborne: false, armed: false })).toBe(LEVEL.warning);
  });

  it('values that are old raise no alarm of their own', () => {
    expect(texts({ staleness: 'lost', fix: 0, lossPercent: 90 })).toEqual(['link lost']);
  });

  it('the worst comes first', () => {
    expect(texts({ flightState: 'returning', batteryPercent: 20, faulted: true })).toEqual(['faulted', 'battery low', 'returning']);
  });

  it.each([
    [{ batteryPercent: 25 }, LEVEL.warning],
    [{ batteryPercent: 12 }, LEVEL.critical],
    [{ pilotControl: true }, LEVEL.warning],
    [{ flightState: 'landing' }, LEVEL.advisory],
    [{ flightState: 'following', trackingErrorM: 3 }, LEVEL.advisory],
    [{ fix: 2 }, LEVEL.warning],
    [{ hasPosition: false }, LEVEL.warning],
    [{ model: 'restarting' }, LEVEL.warning],
    [{ actor: 'given_up' }, LEVEL.critical],
    [{ staleness: 'delayed' }, LEVEL.advisory],
    [{ staleness: 'stale' }, LEVEL.warning],
  ] as const)('%o', (condition, expected) => {
    expect(level(condition)).toBe(expected);
  });
});
