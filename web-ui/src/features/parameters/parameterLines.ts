// Which parameters are shown and in which order, what is typed for one, and how far the reading has come. Pure.
// Must never guess a type: an autopilot stores a value of the wrong one as nonsense.

import type { Parameter, ParameterList, ParameterValue } from '../../protocol/types';

export type Shown = { search: string; changedOnly: boolean; descending: boolean; grouped: boolean };
export type Line = { kind: 'group'; prefix: string; count: number } | { kind: 'parameter'; one: Parameter };

/** What is known of a vehicle's parameters. */
export type Known = { reading: ParameterList['reading']; read: number; total: number | null; revision: number; parameters: Parameter[] };

export const NOTHING: Known = { reading: { state: 'not_begun' }, read: 0, total: null, revision: 0, parameters: [] };

const byName = (a: Parameter, b: Parameter): number => (a.name < b.name ? -1 : a.name > b.name ? 1 : 0);

/** What is known after an answer: news put into what there was, or everything in place of it. */
export function merged(known: Known, { reading, read, total, revision, whole, parameters }: ParameterList): Known {
  if (!whole && parameters.length === 0) return { ...known, reading, read, total, revision };
  const all = new Map(whole ? [] : known.parameters.map((one) => [one.name, one]));
  for (const one of parameters) all.set(one.name, one);
  return { reading, read, total, revision, parameters: [...all.values()].sort(byName) };
}

/** `MPC` of `MPC_XY_CRUISE`. */
export function prefixOf(name: string): string {
  const end = name.indexOf('_', 1);
  return end < 0 ? name : name.slice(0, end);
}

/** Every word of the search is somewhere in the name. */
export function fits(one: Parameter, { search, changedOnly }: Shown): boolean {
  if (changedOnly && one.changed_from === null) return false;
  const name = one.name.toLowerCase();
  return search
    .toLowerCase()
    .split(/\s+/)
    .every((word) => name.includes(word));
}

/** The lines of the table: parameters by name, below the prefix they share if wished. */
export function linesOf(parameters: readonly Parameter[], shown: Shown): Line[] {
  const found = parameters.filter((one) => fits(one, shown));
  if (shown.descending) found.reverse();
  if (!shown.grouped) return found.map((one) => ({ kind: 'parameter', one }));
  const lines: Line[] = [];
  let group: Extract<Line, { kind: 'group' }> | undefined;
  for (const one of found) {
    const prefix = prefixOf(one.name);
    if (group?.prefix !== prefix) {
      group = { kind: 'group', prefix, count: 0 };
      lines.push(group);
    }
    group.count++;
    lines.push({ kind: 'parameter', one });
  }
  return lines;
}

/** A value as it is read: shortest, with a point. */
export function valueText({ value }: ParameterValue): string {
  return value === null ? 'NaN' : `${value}`;
}

export type Problem = 'empty' | 'no_number' | 'not_whole' | 'too_large';

const WHOLE_MOST = 2 ** 31;
const REAL_MOST = 3.4028235e38;

/** What was typed as a value of this type, or what is wrong with it. A comma may stand for the point. */
export function typed(text: string, type: ParameterValue['type']): { value: number } | { problem: Problem } {
  const entry = text.trim().replace(',', '.');
  if (entry === '') return { problem: 'empty' };
  if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(entry)) return { problem: 'no_number' };
  const value = Number(entry);
  if (type === 'integer') {
    if (!Number.isInteger(value)) return { problem: 'not_whole' };
    return value >= -WHOLE_MOST && value < WHOLE_MOST ? { value } : { problem: 'too_large' };
  }
  return Math.abs(value) <= REAL_MOST ? { value } : { problem: 'too_large' };
}

/** Whether a value that was typed is another one than there is, with the precision that the autopilot has. */
export function differs(value: number, { type, value: present }: ParameterValue): boolean {
  if (present === null) return true;
  return type === 'integer' ? value !== present : Math.fround(value) !== Math.fround(present);
}
