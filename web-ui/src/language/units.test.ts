// Figures in both systems of units: there and back again, rounding, signs, and round numbers on rulers.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import {
  digitsOf, errorText, fieldRange, figureText, fromField, inUnits, lengthText, placeText, riseText, roundStep, ruleStep, ruleStepUp, ruleText,
  setText, shown, shownAll, toField, unitName, units, wayText,
} from './units.svelte';
import type { Measure } from './units.svelte';

const MEASURES: Measure[] = ['length', 'height', 'speed', 'climb'];
const MILE_M = 1852;
const FOOT_M = 0.3048;

beforeEach(() => {
  const kept = new Map<string, string>();
  vi.stubGlobal('localStorage', { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => kept.set(key, value) });
});
afterEach(() => {
  units.choose('metric');
  vi.unstubAllGlobals();
});

describe('the choice', () => {
  it('is metric at first, and is remembered', () => {
    units.start();
    expect(units.name).toBe('metric');
    units.choose('aviation');
    units.name = 'metric';
    units.start();
    expect(units.name).toBe('aviation');
  });

  it('holds where nothing can be kept', () => {
    vi.stubGlobal('localStorage', undefined);
    units.choose('aviation');
    expect(units.name).toBe('aviation');
    units.start();
    expect(units.name).toBe('metric');
  });
});

describe('metric', () => {
  it('shows what it is told', () => {
    for (const measure of MEASURES) expect([shown(measure, 12.345), toField(measure, 12.345), fromField(measure, 12.3456)]).toEqual([12.345, 12.345, 12.3456]);
    expect(MEASURES.map(unitName)).toEqual(['m', 'm', 'm/s', 'm/s']);
    const line = [1, null];
    expect(shownAll('height', line)).toBe(line);
  });

  it('does not say minus zero', () => {
    expect([figureText('height', -0.04), figureText('height', -0.06), errorText(-0.001)]).toEqual(['0.0 m', '-0.1 m', '0.00 m']);
  });

  it.each([[0.456, '0.46 m'], [42.04, '42.0 m'], [512.4, '512 m'], [9999, '9999 m'], [12_345, '12.35 km']])('a measured %d reads %s', (metres, text) => {
    expect(lengthText(metres)).toBe(text);
  });

  it.each([
    ['the length of a way', () => wayText(1234.4), '1234 m'],
    ['the pointer', () => placeText(-1234.44), '1234.4 m'],
    ['a rise', () => riseText(1.5), '+1.5 m'],
    ['a fall', () => riseText(-1.5), '−1.5 m'],
    ['hardly a fall', () => riseText(-0.01), '+0.0 m'],
    ['little error', () => errorText(9.5), '9.50 m'],
    ['much error', () => errorText(10.4), '10 m'],
    ['what was set', () => setText('length', 2.5), '2.5 m'],
  ])('%s', (_, text, expected) => {
    expect(text()).toBe(expected);
  });

  it.each([[0.2, '20 cm'], [5, '5 m'], [2000, '2 km'], [2500, '2.5 km']])('a ruler of %d m reads %s', (metres, text) => {
    expect(ruleText(metres, metres)).toBe(text);
  });

  it('keeps the range of a field', () => {
    expect(fieldRange('height', 1, 120)).toEqual({ min: 1, max: 120 });
  });
});

describe('aviation', () => {
  beforeEach(() => units.choose('aviation'));

  it('is feet, knots and feet a minute', () => {
    expect(MEASURES.map(unitName)).toEqual(['ft', 'ft', 'kn', 'ft/min']);
    expect(shown('height', 304.8)).toBeCloseTo(1000, 9);
    expect(shown('length', -30.48)).toBeCloseTo(-100, 9);
    expect(shown('speed', MILE_M / 3600)).toBeCloseTo(1, 12);
    expect(shown('climb', 5.08)).toBeCloseTo(1000, 9);
    expect(shownAll('speed', [0, null, 51.444444])[2]).toBeCloseTo(100, 5);
    expect(shownAll('speed', [0, null])).toEqual([0, null]);
  });

  it('what is typed is what stands there afterwards', () => {
    for (const measure of MEASURES) {
      for (const typed of [-164042, -65.6, -0.1, 0, 0.1, 3.3, 20, 32.8, 99.9, 1640.4]) {
        expect(toField(measure, fromField(measure, typed)), `${typed} ${unitName(measure)}`).toBe(typed);
      }
    }
  });

  it('what is sent is what stands in the field, not what was typed beyond its digits', () => {
    expect(fromField('height', 32.84)).toBe(fromField('height', 32.8));
    expect(fromField('height', 100)).toBeCloseTo(30.48, 12);
    expect(fromField('speed', 10)).toBeCloseTo(5.144444, 6);
  });

  it('every number in the range of a field is allowed', () => {
    for (const [measure, min, max] of [['height', 1, 120], ['length', -20, 20], ['length', -50000, 50000], ['speed', 0.5, 20]] as const) {
      const range = fieldRange(measure, min, max);
      expect(fromField(measure, range.min)).toBeGreaterThanOrEqual(min);
      expect(fromField(measure, range.max)).toBeLessThanOrEqual(max);
      expect(fromField(measure, range.min - 0.1)).toBeLessThan(min);
      expect(fromField(measure, range.max + 0.1)).toBeGreaterThan(max);
    }
    expect(Object.is(fieldRange('length', -0.001, 5).min, 0)).toBe(true);
  });

  it.each([
    ['a height', () => figureText('height', 10), '33 ft'],
    ['one below', () => figureText('height', -10), '-33 ft'],
    ['hardly one below', () => figureText('height', -0.1), '0 ft'],
    ['a speed', () => figureText('speed', 5), '9.7 kn'],
    ['a climb', () => figureText('climb', 3), '591 ft/min'],
    ['a distance', () => figureText('length', 6), '19.7 ft'],
    ['little error', () => errorText(0.5), '1.6 ft'],
    ['almost a hundred feet', () => errorText(30.47), '100 ft'],
    ['much error', () => errorText(100), '328 ft'],
    ['a rise', () => riseText(1.5), '+5 ft'],
    ['a fall', () => riseText(-1.5), '−5 ft'],
    ['hardly a fall', () => riseText(-0.1), '+0 ft'],
    ['a way', () => wayText(1000), '3281 ft'],
    ['a long way', () => wayText(5 * MILE_M), '5.00 NM'],
    ['the pointer', () => placeText(-10), '33 ft'],
    ['the pointer far away', () => placeText(-3000), '1.62 NM'],
    ['what was set', () => setText('height', 10), '32.8 ft'],
    ['what was set in feet', () => setText('height', 30 * FOOT_M), '30 ft'],
  ])('%s', (_, text, expected) => {
    expect(text()).toBe(expected);
  });

  it.each([[0.456, '1.5 ft'], [42.04, '138 ft'], [1851, '6073 ft'], [MILE_M, '1.00 NM'], [12_345, '6.67 NM']])('a measured %d m reads %s', (metres, text) => {
    expect(lengthText(metres)).toBe(text);
  });

  it('has fewer digits of what is a third of a metre', () => {
    expect([digitsOf('height'), digitsOf('length', true)]).toEqual([0, 1]);
  });
});

it("takes lengths and speeds of the node, and leaves what is neither", () => {
  units.choose('aviation');
  expect(inUnits(3.048, 'm')).toEqual({ value: expect.closeTo(10, 9), unit: 'ft' });
  expect(inUnits(5, 'm/s')).toEqual({ value: expect.closeTo(9.719, 3), unit: 'kn' });
  for (const unit of ['s', 'ms', '%', '', 'm²']) expect(inUnits(3, unit)).toEqual({ value: 3, unit });
  units.choose('metric');
  expect(inUnits(3, 'm')).toEqual({ value: 3, unit: 'm' });
});

describe('rulers', () => {
  it.each([[0.9, 0.5], [1, 1], [4.9, 2], [70, 50], [1999, 1000]])('not above %d is %d', (limit, expected) => {
    expect(roundStep(limit)).toBeCloseTo(expected, 12);
  });

  it('in metres', () => {
    expect([ruleStep(70), ruleStep(1999), ruleStepUp(70), ruleStepUp(1999), ruleStepUp(0.3)]).toEqual([50, 1000, 100, 2000, 0.5]);
  });

  it.each([
    [0.35, '1 ft'], [30, '50 ft'], [180, '500 ft'], [186, '0.1 NM'], [400, '0.2 NM'], [1800, '0.5 NM'], [4000, '2 NM'], [100_000, '50 NM'],
  ])('not above %d m it is %s', (limit, text) => {
    units.choose('aviation');
    const step = ruleStep(limit);
    expect(ruleText(step, step)).toBe(text);
    expect(step).toBeLessThanOrEqual(limit);
  });

  it.each([
    [0.05, '0.2 ft'], [0.3, '1 ft'], [140, '500 ft'], [152.4, '500 ft'], [152.5, '0.1 NM'], [186, '0.2 NM'], [1852, '1 NM'], [1853, '2 NM'],
  ])('not below %d m it is %s', (least, text) => {
    units.choose('aviation');
    const step = ruleStepUp(least);
    expect(ruleText(step, step)).toBe(text);
    expect(step).toBeGreaterThanOrEqual(least - 1e-9);
  });

  it('is read in one unit from end to end', () => {
    units.choose('aviation');
    const step = 500 * FOOT_M;
    expect([step * 5, step * 25].map((at) => ruleText(at, step))).toEqual(['2500 ft', '12500 ft']);
    expect([0.5, 1, 2.5].map((miles) => ruleText(miles * MILE_M, 0.1 * MILE_M))).toEqual(['0.5 NM', '1 NM', '2.5 NM']);
  });
});
