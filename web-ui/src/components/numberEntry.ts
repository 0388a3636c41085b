// What a number typed into a field means, before it is finished too. Pure.

import { fromField } from '../language/units.svelte';
import type { Measure } from '../language/units.svelte';

/** `value` is allowed, metric where it is a measure. What was typed `stands` until the field is left, or gives way to the value at once. */
export type Entry = { value: number; stands: boolean };

export function entryOf(typed: number, range: { min: number; max: number }, measure?: Measure): Entry {
  const entered = measure ? fromField(measure, typed) : typed;
  // Less than is allowed may be the beginning of more: the 2 of 20.
  return { value: Math.min(range.max, Math.max(range.min, entered)), stands: entered >= 0 && entered < range.min };
}
