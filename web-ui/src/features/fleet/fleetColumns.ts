// The columns of the fleet table: what each says, how it sorts, and which of them there is room for. Pure.

import { GNSS_FIXES, spoken } from '../../protocol/words';
import { t } from '../../language/language.svelte';
import type { Text } from '../../language/language.svelte';

/** What the table reads of a vehicle. */
export type Sortable = {
  id: number;
  name: string;
  level: number;
  flightState: string;
  mode: string;
  armed: boolean;
  battery: number | null;
  satellites: number;
  fix: string;
  loss: number;
  heightM: number;
  speedMS: number;
  errorM: number;
  ageMs: number;
  /** Seconds until it must return; NaN if not known. */
  returnS: number;
  pluginsLevel: number;
  pluginsText: string;
  plugin: string;
  node: number | null;
  airborne: boolean;
  leader: boolean;
  /** Who has control authority over it, empty if nobody has. */
  holder: string;
};

export type ColumnKey =
  | 'id' | 'state' | 'authority' | 'battery' | 'home' | 'link' | 'height' | 'speed' | 'error' | 'gnss' | 'rtt' | 'plugins' | 'coordinator' | 'attention';

export type Column = {
  key: ColumnKey;
  words: Text;
  /** Explains the head; nobody has to hover to understand the cell. */
  title: Text;
  /** A track of the grid. */
  width: string;
  /** Room it takes at least, in pixels. */
  leastPx: number;
  /** The smaller, the sooner it is left out: 0 never is. */
  order: number;
  numeric?: boolean;
  /** Smaller first; what is not known comes last whichever way. */
  value: (row: Sortable) => number | string;
};

const FIXES: readonly string[] = GNSS_FIXES;

export const COLUMNS: readonly Column[] = [
  { key: 'id', words: 'Vehicle', title: 'Number and name', width: 'minmax(92px, 1.1fr)', leastPx: 92, order: 0, value: (r) => r.id },
  { key: 'state', words: 'State', title: 'What it does; autopilot mode; motors', width: 'minmax(112px, 1.3fr)', leastPx: 112, order: 0, value: (r) => r.flightState },
  { key: 'authority', words: 'Controlled by', title: 'Whose commands it takes', width: 'minmax(104px, 0.8fr)', leastPx: 104, order: 8.7, value: (r) => r.holder },
  { key: 'battery', words: 'Battery', title: 'Charge left and voltage', width: '146px', leastPx: 146, order: 9, value: (r) => r.battery ?? NaN },
  { key: 'home', words: 'Return in', title: 'Time until it must return if it goes on as now', width: '76px', leastPx: 76, order: 5, numeric: true, value: (r) => r.returnS },
  { key: 'link', words: 'Link', title: 'How fresh its data is', width: '100px', leastPx: 100, order: 10, value: (r) => -r.ageMs },
  { key: 'rtt', words: 'Latency, loss', title: 'Round trip between node and vehicle, share of frames lost', width: '104px', leastPx: 104, order: 6, numeric: true, value: (r) => r.loss },
  { key: 'height', words: 'Height', title: 'Above its launch place', width: '74px', leastPx: 74, order: 8, numeric: true, value: (r) => r.heightM },
  { key: 'speed', words: 'Speed', title: 'Over ground and climbing together', width: '78px', leastPx: 78, order: 4, numeric: true, value: (r) => r.speedMS },
  { key: 'error', words: 'Slot error', title: 'Distance to where its task wants it', width: '78px', leastPx: 78, order: 3, numeric: true, value: (r) => r.errorM },
  { key: 'gnss', words: 'GNSS', title: 'Fix and satellites', width: '96px', leastPx: 96, order: 7, value: (r) => FIXES.indexOf(r.fix) * 100 + r.satellites },
  { key: 'plugins', words: 'Plugins', title: 'Its model and payloads', width: 'minmax(104px, 0.8fr)', leastPx: 104, order: 2, value: (r) => -r.pluginsLevel },
  { key: 'coordinator', words: 'Coordinator', title: 'The node whose orders it flies', width: 'minmax(96px, 0.7fr)', leastPx: 96, order: 1, value: (r) => r.node ?? 0 },
  { key: 'attention', words: 'Needs attention', title: 'What is not as it should be, worst first', width: 'minmax(150px, 2fr)', leastPx: 150, order: 8.5, value: (r) => -r.level },
];

/** The column of the checkbox and the padding. */
const FIXED_PX = 44 + 24;

/** As many columns as there is room for, in their order on the screen; who has a vehicle only where anybody has one (`shared`). */
export function columnsFor(widthPx: number, shared = false): Column[] {
  const chosen = new Set(COLUMNS.filter((column) => column.order === 0));
  let room = widthPx - FIXED_PX - [...chosen].reduce((sum, column) => sum + column.leastPx, 0);
  for (const column of [...COLUMNS].sort((a, b) => b.order - a.order)) {
    if (chosen.has(column) || (column.key === 'authority' && !shared)) continue;
    if (column.leastPx > room) break;
    room -= column.leastPx;
    chosen.add(column);
  }
  return COLUMNS.filter((column) => chosen.has(column));
}

/** A total order: what is equal or not known falls back to the number, so that rows do not change places for nothing. */
export function compareBy(key: ColumnKey, descending: boolean): (a: Sortable, b: Sortable) => number {
  const column = COLUMNS.find((one) => one.key === key);
  const sign = descending ? -1 : 1;
  return (a, b) => {
    const [x, y] = [column?.value(a) ?? a.id, column?.value(b) ?? b.id];
    const [xKnown, yKnown] = [!Number.isNaN(x), !Number.isNaN(y)];
    if (!xKnown || !yKnown) return Number(yKnown) - Number(xKnown) || a.id - b.id;
    const order = typeof x === 'string' || typeof y === 'string' ? String(x).localeCompare(String(y)) : x - y;
    return sign * order || a.id - b.id;
  };
}

export type GroupKey = 'none' | 'state' | 'attention' | 'place' | 'model' | 'node' | 'authority';

export const GROUPS: readonly { key: GroupKey; words: Text }[] = [
  { key: 'none', words: 'not grouped' },
  { key: 'attention', words: 'by urgency' },
  { key: 'state', words: 'by state' },
  { key: 'place', words: 'by air and ground' },
  { key: 'model', words: 'by model' },
  { key: 'node', words: 'by node' },
  { key: 'authority', words: 'by operator' },
];

const URGENCY: readonly Text[] = ['Normal', 'Advisory', 'Warning', 'Critical'];

/** The group a vehicle is in: its words, and where the group stands among the others. */
export function groupOf(row: Sortable, key: GroupKey): { words: string; rank: number } {
  switch (key) {
    case 'none':
      return { words: '', rank: 0 };
    case 'attention':
      return { words: t(URGENCY[row.level] ?? 'Normal'), rank: -row.level };
    case 'state': {
      const words = spoken(row.flightState);
      return { words: words.charAt(0).toUpperCase() + words.slice(1), rank: 0 };
    }
    case 'place':
      return row.airborne ? { words: t('In the air'), rank: 0 } : { words: t('On the ground'), rank: 1 };
    case 'model':
      return { words: row.plugin || t('Model not known'), rank: 0 };
    case 'node':
      return { words: row.node === null ? t('This node') : t('Node {node}', { node: row.node }), rank: row.node ?? 0 };
    case 'authority':
      return row.holder === '' ? { words: t("Under nobody's control"), rank: 1 } : { words: row.holder, rank: 0 };
  }
}

/** A line of the table: a group's head, or a vehicle. */
export type Line<R extends Sortable> =
  | { kind: 'group'; words: string; rows: readonly R[] }
  | { kind: 'vehicle'; row: R };

/** Rows in order under the heads of their groups. */
export function linesOf<R extends Sortable>(rows: readonly R[], group: GroupKey): Line<R>[] {
  if (group === 'none') return rows.map((row) => ({ kind: 'vehicle', row }));
  const groups = new Map<string, { rank: number; rows: R[] }>();
  for (const row of rows) {
    const { words, rank } = groupOf(row, group);
    const found = groups.get(words);
    if (found) found.rows.push(row);
    else groups.set(words, { rank, rows: [row] });
  }
  const ordered = [...groups].sort(([a, x], [b, y]) => x.rank - y.rank || a.localeCompare(b));
  return ordered.flatMap(([words, { rows: members }]): Line<R>[] => [
    { kind: 'group', words, rows: members },
    ...members.map((row): Line<R> => ({ kind: 'vehicle', row })),
  ]);
}

/** Which lines to draw of a scrolled list of equally high ones, with some beyond either edge. */
export function windowOf(scrollPx: number, heightPx: number, linePx: number, count: number, beyond = 6): { from: number; to: number } {
  const from = Math.max(0, Math.min(count, Math.floor(scrollPx / linePx) - beyond));
  const to = Math.min(count, Math.ceil((scrollPx + heightPx) / linePx) + beyond);
  return { from, to: Math.max(from, to) };
}
