import { describe, expect, it } from 'vitest';
import type { Parameter, ParameterList } from '../../protocol/types';
import { NOTHING, differs, fits, linesOf, merged, prefixOf, typed, valueText } from './parameterLines';
import type { Shown } from './parameterLines';

const whole = (name: string, value: number, from: number | null = null): Parameter => ({
  name,
  value: { type: 'integer', value },
  changed_from: from === null ? null : { type: 'integer', value: from },
});
const shown = (over: Partial<Shown> = {}): Shown => ({ search: '', changedOnly: false, descending: false, grouped: false, ...over });
const answer = (over: Partial<ParameterList>): ParameterList => ({ reading: { state: 'reading' }, read: 0, total: 3, revision: 1, whole: false, parameters: [], ...over });
const LIST = [whole('COM_RC_IN_MODE', 4), whole('MPC_LAND_SPEED', 1), whole('MPC_XY_CRUISE', 6, 5), whole('SYS', 1)];
const names = (lines: ReturnType<typeof linesOf>): string[] => lines.map((line) => (line.kind === 'group' ? `${line.prefix}:${line.count}` : line.one.name));

describe('what is known', () => {
  it('takes up news in their place, and everything anew after a restart', () => {
    const first = merged(NOTHING, answer({ whole: true, revision: 2, parameters: [whole('B', 1), whole('A', 2)] }));
    expect(first.parameters.map((one) => one.name)).toEqual(['A', 'B']);
    const second = merged(first, answer({ revision: 4, parameters: [whole('AB', 3), whole('B', 9, 1)] }));
    expect(second.parameters.map((one) => [one.name, one.value.value])).toEqual([['A', 2], ['AB', 3], ['B', 9]]);
    const same = merged(second, answer({ revision: 4, read: 3, reading: { state: 'complete' } }));
    expect(same.parameters).toBe(second.parameters);
    expect([same.reading.state, same.read, same.total]).toEqual(['complete', 3, 3]);
    expect(merged(same, answer({ whole: true, revision: 5 })).parameters).toEqual([]);
  });
});

describe('what is shown', () => {
  it('is found by all words of the search, in any case', () => {
    expect(LIST.filter((one) => fits(one, shown({ search: ' mpc  cruise ' }))).map((one) => one.name)).toEqual(['MPC_XY_CRUISE']);
    expect(LIST.filter((one) => fits(one, shown())).length).toBe(4);
  });

  it('is what was changed here alone, if wished', () => {
    expect(names(linesOf(LIST, shown({ changedOnly: true })))).toEqual(['MPC_XY_CRUISE']);
  });

  it('stands in either order, below its prefix', () => {
    expect(names(linesOf(LIST, shown({ grouped: true })))).toEqual(['COM:1', 'COM_RC_IN_MODE', 'MPC:2', 'MPC_LAND_SPEED', 'MPC_XY_CRUISE', 'SYS:1', 'SYS']);
    expect(names(linesOf(LIST, shown({ grouped: true, descending: true })))[1]).toBe('SYS');
    expect(LIST[0]?.name).toBe('COM_RC_IN_MODE');
    expect([prefixOf('MAV_1_CONFIG'), prefixOf('_HASH'), prefixOf('X')]).toEqual(['MAV', '_HASH', 'X']);
  });

  it('says values as they are', () => {
    expect(valueText({ type: 'real', value: 0.15 })).toBe('0.15');
    expect(valueText({ type: 'real', value: null })).toBe('NaN');
    expect(valueText({ type: 'integer', value: -3 })).toBe('-3');
  });
});

describe('what is typed', () => {
  it('is a number of the type, with point or comma', () => {
    expect(typed(' -5 ', 'integer')).toEqual({ value: -5 });
    expect(typed('5.0', 'integer')).toEqual({ value: 5 });
    expect(typed('0,15', 'real')).toEqual({ value: 0.15 });
    expect(typed('1e-3', 'real')).toEqual({ value: 0.001 });
  });

  it('is refused with what is wrong', () => {
    expect(typed('', 'real')).toEqual({ problem: 'empty' });
    for (const text of ['x', '1 2', '1,2,3', 'NaN', 'Infinity', '0x10', '1e']) expect(typed(text, 'real'), text).toEqual({ problem: 'no_number' });
    expect(typed('4.5', 'integer')).toEqual({ problem: 'not_whole' });
    expect(typed('2147483648', 'integer')).toEqual({ problem: 'too_large' });
    expect(typed('-2147483648', 'integer')).toEqual({ value: -2147483648 });
    expect(typed('1e39', 'real')).toEqual({ problem: 'too_large' });
  });

  it('is another value only if the autopilot can tell it from the present one', () => {
    expect(differs(5, { type: 'integer', value: 5 })).toBe(false);
    expect(differs(0.15, { type: 'real', value: 0.15 })).toBe(false);
    expect(differs(0.1500000001, { type: 'real', value: 0.15 })).toBe(false);
    expect(differs(0.16, { type: 'real', value: 0.15 })).toBe(true);
    expect(differs(1, { type: 'real', value: null })).toBe(true);
  });
});
