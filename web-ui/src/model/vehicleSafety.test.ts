import { describe, expect, it } from 'vitest';
import type { Alarm, EnergyState, Order } from '../protocol/types';
import { LEVEL, worst } from './severity';
import { alarmText, avoidanceText, durationText, orderText, quantity, returnText, safetyProblems } from './vehicleSafety';
import type { VehicleSafety } from '../protocol/types';

const WELL: VehicleSafety = { id: 1, failsafe: null, energy: null, avoiding: null, stopped: false };
const ALARM: Alarm = { trigger: 'link_loss', value: 4.25, limit: 3, unit: 's', since: 10_000_000, reaction: 'return', report_only: null };
const ORDER: Order = { reaction: 'return', trigger: 'link_loss', ordered_at: 12_000_000, effective_at: 13_000_000, recovered: false };
const ENERGY: EnergyState = {
  remaining: 0.4, needed_home: 0.2, reserve: 0.15, margin: 0.05, endurance_s: 600, return_in_s: 75, level: 'ok', learned: true,
  ground_speed_home_m_s: 4,
};
const texts = (part: Partial<VehicleSafety>, airborne = true) => safetyProblems({ ...WELL, ...part }, airborne).map((p) => p.text);

describe('words', () => {
  it('an alarm says trigger, value, limit, reaction and how long', () => {
    expect(alarmText(ALARM, 18_000)).toBe('Link loss 4.3 s, limit 3 s: return, for 8 s');
    expect(alarmText({ ...ALARM, report_only: 'pilot_in_control' }, 18_000)).toContain('return (pilot in control)');
  });

  it('an order says what, why, how long and whether it is taken up', () => {
    expect(orderText(ORDER, 18_000)).toBe('Ordered: return because of link loss, for 6 s');
    expect(orderText({ ...ORDER, effective_at: null }, 18_000)).toContain('not taken up yet');
    expect(orderText({ ...ORDER, recovered: true }, 18_000)).toContain('cause is over');
  });

  it('numbers are short and what is no number is not known', () => {
    expect([0, 0.034, 2, 12.34, 123.4].map((v) => quantity(v, 'm'))).toEqual(['0 m', '0.03 m', '2 m', '12.3 m', '123 m']);
    expect([quantity(NaN, 'm'), quantity(null, 'm'), quantity(10, '')]).toEqual(['not known', 'not known', '10']);
  });

  it('durations', () => {
    expect([8.4, 89, 600, 9000, null].map(durationText)).toEqual(['8 s', '89 s', '10 min', '2.5 h', 'not known']);
  });

  it('whom it gives way to, or the fence', () => {
    const avoiding = { by_m_s: 1, because: 'uav-3', distance_m: 4, predicted_m: 2, feasible: true };
    expect(avoidanceText(avoiding)).toBe('Gives way to uav-3, 4 m away');
    expect(avoidanceText({ ...avoiding, because: null, distance_m: null, feasible: false })).toBe(
      'Kept inside of the fence; the distance cannot be kept',
    );
  });

  it('a return that is due says so', () => {
    expect(returnText(ENERGY)).toBe('75 s');
    expect(returnText({ ...ENERGY, level: 'return_now' })).toBe('now');
    expect(returnText({ ...ENERGY, level: 'land_now' })).toBe('land now');
  });
});

describe('safetyProblems', () => {
  it('a vehicle that is well, or of which nothing is known, has none', () => {
    expect(texts({ energy: ENERGY })).toEqual([]);
    expect(safetyProblems(null, true)).toEqual([]);
  });

  it('stopped motors are critical', () => {
    expect(worst(safetyProblems({ ...WELL, stopped: true }, false))).toBe(LEVEL.critical);
  });

  it('the alarm behind the order is not said twice, another is', () => {
    const other: Alarm = { ...ALARM, trigger: 'gnss_loss' };
    expect(texts({ failsafe: { alarms: [ALARM, other], order: ORDER } })).toEqual(['link loss: return ordered', 'GNSS loss']);
  });

  it('landing and release are critical, holding and returning are warnings', () => {
    const level = (reaction: Order['reaction']) => worst(safetyProblems({ ...WELL, failsafe: { alarms: [], order: { ...ORDER, reaction } } }, true));
    expect((['hold', 'return', 'land', 'release'] as const).map(level)).toEqual([2, 2, 3, 3]);
  });

  it('energy counts in the air only', () => {
    const energy: EnergyState = { ...ENERGY, level: 'return_now' };
    expect(texts({ energy })).toEqual(['return now for energy']);
    expect(texts({ energy }, false)).toEqual([]);
  });
});
