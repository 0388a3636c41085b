// Offsets of a free shape as an operator pastes them: a table of three columns or a JSON list, read as the server reads its files.
// Must never guess: a line that is wrong is named. Pure.

import type { OffsetFrd } from '../protocol/types';

export type Offsets = { offsets: OffsetFrd[] } | { fault: string };

type Column = 'forward_m' | 'right_m' | 'down_m' | 'up_m';
const COLUMNS: readonly string[] = ['forward_m', 'right_m', 'down_m', 'up_m'];
const PLAIN: readonly Column[] = ['forward_m', 'right_m', 'down_m'];

export function parseOffsets(text: string): Offsets {
  const trimmed = text.trim();
  if (trimmed === '') return { fault: 'no offsets yet' };
  return trimmed.startsWith('[') ? fromJson(trimmed) : fromTable(text);
}

function fromJson(text: string): Offsets {
  let list: unknown;
  try {
    list = JSON.parse(text);
  } catch {
    return { fault: 'this is no JSON list' };
  }
  if (!Array.isArray(list)) return { fault: 'this is no JSON list' };
  const offsets: OffsetFrd[] = [];
  for (const [k, entry] of list.entries()) {
    const numbers = Array.isArray(entry) ? triple(entry) : ofObject(entry);
    if (!numbers) return { fault: `entry ${k + 1}: three numbers, or forward_m, right_m and down_m or up_m` };
    offsets.push(numbers);
  }
  return some(offsets);
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
      if (!isHeading(fields)) return { fault: `line ${k + 1}: the headings must be forward_m, right_m and one of down_m and up_m` };
      columns = fields;
      continue;
    }
    if (fields.length !== 3) return { fault: `line ${k + 1}: ${fields.length} fields instead of three` };
    const bad = fields.find((field) => field === '' || !Number.isFinite(Number(field)));
    if (bad !== undefined) return { fault: `line ${k + 1}: "${bad}" is no number` };
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
  return offsets.length === 0 ? { fault: 'no offsets yet' } : { offsets };
}
