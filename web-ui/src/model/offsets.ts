// Offsets of a free shape as an operator pastes them: a table of three columns or a JSON list, read as the server reads its files.
// Must never guess: a line that is wrong is named. Pure.

import { t } from '../language/language.svelte';
import type { OffsetFrd } from '../protocol/types';

export type Offsets = { offsets: OffsetFrd[] } | { fault: string };

type Column = 'forward_m' | 'right_m' | 'down_m' | 'up_m';
const COLUMNS: readonly string[] = ['forward_m', 'right_m', 'down_m', 'up_m'];
/** What is quoted back of a field. */
const QUOTED = 40;
const PLAIN: readonly Column[] = ['forward_m', 'right_m', 'down_m'];

export function parseOffsets(text: string): Offsets {
  const trimmed = text.trim();
  if (trimmed === '') return { fault: t('no offsets yet') };
  return trimmed.startsWith('[') ? fromJson(text) : fromTable(text);
}

function fromJson(text: string): Offsets {
  let list: unknown;
  try {
    // Some programs put a mark at the beginning of a file, which is no part of the list.
    list = JSON.parse(text.trim());
  } catch {
    return { fault: t('line {line}: this is no JSON list', { line: lineOfFault(text) }) };
  }
  if (!Array.isArray(list)) return { fault: t('line {line}: this is no JSON list', { line: 1 }) };
  const offsets: OffsetFrd[] = [];
  for (const [k, entry] of list.entries()) {
    const numbers = Array.isArray(entry) ? triple(entry) : ofObject(entry);
    if (!numbers) return { fault: t('entry {entry}: three numbers, or forward_m, right_m and down_m or up_m', { entry: k + 1 }) };
    offsets.push(numbers);
  }
  return some(offsets);
}

const TOKEN = /\s+|[[\]{},:]|"(?:[^"\\\n]|\\.)*"|-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?|true|false|null/y;

/** The line in which a JSON text goes wrong: browsers do not agree on saying it. One that only lacks its end goes wrong in its last. */
function lineOfFault(text: string): number {
  const open: string[] = [];
  let before = '';
  let at = 0;
  while (at < text.length) {
    TOKEN.lastIndex = at;
    const token = TOKEN.exec(text)?.[0];
    if (token === undefined) break;
    if (token.trim() !== '') {
      if (!follows(token, before, open)) break;
      if (token === '[' || token === '{') open.push(token);
      if (token === ']' || token === '}') open.pop();
      before = token;
    }
    at += token.length;
  }
  const whole = text.slice(0, at);
  return (at < text.length ? whole : whole.trimEnd()).split('\n').length;
}

function follows(token: string, before: string, open: readonly string[]): boolean {
  const begun = ['[', '{', ',', ':'].includes(before);
  if (token === ',') return !begun && before !== '' && open.length > 0;
  if (token === ':') return before.startsWith('"');
  if (token === ']' || token === '}') return before !== ',' && before !== ':' && open.at(-1) === (token === ']' ? '[' : '{');
  return begun || before === '';
}

function triple(entry: unknown[]): OffsetFrd | null {
  const [forward_m, right_m, down_m] = entry;
  return entry.length === 3 ? offset(forward_m, right_m, down_m) : null;
}

function ofObject(entry: unknown): OffsetFrd | null {
  if (typeof entry !== 'object' || entry === null) return null;
  const fields = entry as Record<string, unknown>;
  if (Object.keys(fields).length !== 3 || !Object.keys(fields).every((key) => COLUMNS.includes(key))) return null;
  const up = fields.up_m;
  return offset(fields.forward_m, fields.right_m, typeof up === 'number' ? 0 - up : fields.down_m);
}

function offset(forward_m: unknown, right_m: unknown, down_m: unknown): OffsetFrd | null {
  const good = (value: unknown): value is number => typeof value === 'number' && Number.isFinite(value);
  return good(forward_m) && good(right_m) && good(down_m) ? { forward_m, right_m, down_m } : null;
}

function fromTable(text: string): Offsets {
  let columns: readonly string[] = PLAIN;
  const offsets: OffsetFrd[] = [];
  let first = true;
  for (const [k, raw] of text.split(/\r?\n/).entries()) {
    const line = raw.trim();
    if (line === '' || line.startsWith('#')) continue;
    const fields = line.split(/[,;\t]/).map((field) => field.trim().replace(/^"(.*)"$/, '$1'));
    const heading = first && fields.every((field) => Number.isNaN(Number(field)));
    first = false;
    if (heading) {
      if (!isHeading(fields)) return { fault: t('line {line}: the headings must be forward_m, right_m and one of down_m and up_m', { line: k + 1 }) };
      columns = fields;
      continue;
    }
    if (fields.length !== 3) return { fault: t('line {line}: {count} fields instead of three', { line: k + 1, count: fields.length }) };
    const bad = fields.find((field) => field === '' || !Number.isFinite(Number(field)));
    if (bad !== undefined) return { fault: t('line {line}: "{text}" is no number', { line: k + 1, text: bad.slice(0, QUOTED) }) };
    const of = (column: Column) => Number(fields[columns.indexOf(column)]);
    offsets.push({ forward_m: of('forward_m'), right_m: of('right_m'), down_m: columns.includes('up_m') ? 0 - of('up_m') : of('down_m') });
  }
  return some(offsets);
}

function isHeading(fields: readonly string[]): boolean {
  const vertical = fields.filter((field) => field === 'down_m' || field === 'up_m');
  return fields.length === 3 && fields.includes('forward_m') && fields.includes('right_m') && vertical.length === 1;
}

function some(offsets: OffsetFrd[]): Offsets {
  return offsets.length === 0 ? { fault: t('no offsets yet') } : { offsets };
}
