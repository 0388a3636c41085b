// What any plugin says of its state, line by line: names in words, figures in their units, in the order of its schema. Pure.

import { label, spoken } from '../../protocol/words';
import type { Line } from './stateLines';
import { unitOf } from './units';
import { t } from '../../language/language.svelte';

const MOST_LINES = 24;

export function schemaLines(schemaJson: string | null, state: unknown): Line[] {
  if (typeof state !== 'object' || state === null) return [];
  const facts = state as Record<string, unknown>;
  const known = orderOf(schemaJson).filter((name) => name in facts);
  const rest = Object.keys(facts).filter((name) => !known.includes(name));
  return [...known, ...rest].slice(0, MOST_LINES).map((name) => line(name, facts[name]));
}

function orderOf(schemaJson: string | null): string[] {
  try {
    const schema = JSON.parse(schemaJson ?? 'null') as { properties?: object } | null;
    return Object.keys(schema?.properties ?? {});
  } catch {
    return [];
  }
}

function line(name: string, value: unknown): Line {
  const { words, unit, scale } = unitOf(name);
  const said: Line = { name: label(words), value: valueText(value, unit, scale) };
  const wrong = (name === 'connected' && value === false) || (/(^|_)fault$|(^|_)error$/.test(name) && Boolean(value)) || (name === 'warning' && value === true);
  return wrong ? { ...said, warn: true } : said;
}

function valueText(value: unknown, unit: string, scale: number): string {
  if (value === null || value === undefined || value === '') return '–';
  if (typeof value === 'boolean') return value ? t('yes') : t('no');
  if (typeof value === 'number') {
    const shown = value * scale;
    const digits = Number.isInteger(value) && scale === 1 ? 0 : Math.abs(shown) < 10 ? 2 : 1;
    return `${shown.toFixed(digits)}${unit ? ` ${unit}` : ''}`;
  }
  if (typeof value === 'string') return spoken(value);
  if (Array.isArray(value)) return `${value.length}`;
  const kind = (value as { kind?: unknown }).kind;
  return typeof kind === 'string' && Object.keys(value).length === 1 ? spoken(kind) : JSON.stringify(value);
}
