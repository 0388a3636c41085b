// What stands in a generated form, and the command that comes of it. Pure.

import type { Field, Form } from './schemaForm';
import { t } from '../../language/language.svelte';

/** What the operator typed or chose, by the field's path. Numbers are as shown, in the unit of the field; a text stays a text. */
export type Values = Readonly<Record<string, unknown>>;

export const keyOf = (field: Field): string => field.path.join('.');

/** What stands in a form that nobody has touched. */
export function initialOf(form: Form): Values {
  const values: Record<string, unknown> = {};
  for (const field of form.fields) {
    const { initial } = field;
    if (field.kind === 'json') values[keyOf(field)] = initial === null ? '' : JSON.stringify(initial);
    else if (field.kind === 'variant') values[keyOf(field)] = { key: field.variants[0]?.key ?? '', values: {} };
    else if (typeof initial === 'number') values[keyOf(field)] = round(initial * field.scale);
    else values[keyOf(field)] = initial ?? (field.kind === 'choice' && field.required ? field.choices[0]?.value : field.kind === 'text' ? '' : null);
  }
  return values;
}

export type Built = { command: unknown; problems: Readonly<Record<string, string>> };

/** The command, and for every field that keeps it from being sent, why. */
export function build(form: Form, values: Values): Built {
  if (typeof form.fixed !== 'object' || form.fixed === null) return { command: form.fixed, problems: {} };
  const command = structuredClone(form.fixed) as Record<string, unknown>;
  const problems: Record<string, string> = {};
  for (const field of form.fields) {
    const key = keyOf(field);
    const { value, problem } = valueOf(field, values[key]);
    if (problem) problems[key] = problem;
    else if (value !== undefined) put(command, field.path, value);
  }
  return { command, problems };
}

type Read = { value?: unknown; problem?: string };

function valueOf(field: Field, typed: unknown): Read {
  switch (field.kind) {
    case 'number':
    case 'integer':
      return numberOf(field, typed);
    case 'variant':
      return variantOf(field, typed);
    case 'json':
      return jsonOf(field, typed);
    default:
      if (typed === null || typed === undefined) return field.required ? { problem: t('is needed') } : {};
      return { value: typed };
  }
}

function numberOf(field: Field, typed: unknown): Read {
  if (typeof typed !== 'number' || Number.isNaN(typed)) return field.required ? { problem: t('is needed') } : {};
  if (field.kind === 'integer' && !Number.isInteger(typed)) return { problem: t('is a whole number') };
  if (field.min !== null && typed < field.min) return { problem: t('is {limit} at least', { limit: round(field.min) }) };
  if (field.max !== null && typed > field.max) return { problem: t('is {limit} at most', { limit: round(field.max) }) };
  return { value: field.scale === 1 ? typed : typed / field.scale };
}

function variantOf(field: Field, typed: unknown): Read {
  const { key, values } = (typed ?? {}) as { key?: string; values?: Values };
  const chosen = field.variants.find((variant) => variant.key === key);
  if (!chosen) return field.required ? { problem: t('is needed') } : {};
  const { command, problems } = build(chosen, { ...initialOf(chosen), ...values });
  const first = Object.entries(problems)[0];
  return first ? { problem: `${first[0]} ${first[1]}` } : { value: command };
}

function jsonOf(field: Field, typed: unknown): Read {
  const text = typeof typed === 'string' ? typed.trim() : '';
  if (text === '') return field.required ? { problem: t('is needed') } : {};
  try {
    return { value: JSON.parse(text) as unknown };
  } catch {
    return { problem: t('is no JSON') };
  }
}

function put(into: Record<string, unknown>, path: readonly string[], value: unknown): void {
  const [name, ...rest] = path;
  if (name === undefined) return;
  if (rest.length === 0) {
    into[name] = value;
    return;
  }
  const below = into[name];
  const next = typeof below === 'object' && below !== null ? (below as Record<string, unknown>) : {};
  into[name] = next;
  put(next, rest, value);
}

/** So that 2.999999 degrees are 3. */
export function round(value: number): number {
  return Number(value.toFixed(6));
}
