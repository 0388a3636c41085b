// Which vehicles the list shows and in which order. Pure; works on anything that has the fields of a row.

import { spoken } from '../../protocol/words';

export type FilterKey = 'all' | 'attention' | 'air' | 'ground' | 'targets' | 'mine';
export type SortKey = 'id' | 'urgency' | 'battery' | 'state';

/** The fields of a row that filtering and sorting look at. */
export type Listed = {
  id: number;
  name: string;
  level: number;
  airborne: boolean;
  battery: number | null;
  flightState: string;
  mode: string;
  staleness: string;
  problems: string;
  /** Who has control authority over it, empty if nobody has. */
  holder: string;
  mine: boolean;
};

/** Ids meant by text like `3`, `1-4, 7`; null if the text is no such list. */
export function parseIds(text: string): Set<number> | null {
  const trimmed = text.trim();
  if (!/^\d+(\s*[-–]\s*\d+)?(\s*[,\s]\s*\d+(\s*[-–]\s*\d+)?)*$/.test(trimmed)) return null;
  const ids = new Set<number>();
  for (const [, from, to] of trimmed.matchAll(/(\d+)(?:\s*[-–]\s*(\d+))?/g)) {
    const low = Number(from);
    const high = to === undefined ? low : Number(to);
    for (let id = low; id <= Math.min(high, low + 9999); id++) ids.add(id);
  }
  return ids;
}

export function inCategory(row: Listed, filter: FilterKey, targets: ReadonlySet<number>): boolean {
  switch (filter) {
    case 'all':
      return true;
    case 'attention':
      return row.level >= 2;
    case 'air':
      return row.airborne;
    case 'ground':
      return !row.airborne;
    case 'mine':
      return row.mine;
    case 'targets':
      return targets.has(row.id);
  }
}

export function matchesSearch(row: Listed, search: string): boolean {
  const wanted = search.trim().toLowerCase();
  if (wanted === '') return true;
  const ids = parseIds(wanted);
  if (ids) return ids.has(row.id);
  const text = `${row.id} ${row.name} ${spoken(row.flightState)} ${spoken(row.mode)} ${row.staleness} ${row.problems} ${row.holder}`;
  return text.toLowerCase().includes(wanted);
}

/** A comparison that is total: equal keys fall back to the id, so that cards do not change places for nothing. */
export function compare(sort: SortKey): (a: Listed, b: Listed) => number {
  const byId = (a: Listed, b: Listed) => a.id - b.id;
  switch (sort) {
    case 'id':
      return byId;
    case 'urgency':
      return (a, b) => b.level - a.level || byId(a, b);
    case 'battery':
      return (a, b) => (a.battery ?? 101) - (b.battery ?? 101) || byId(a, b);
    case 'state':
      return (a, b) => a.flightState.localeCompare(b.flightState) || byId(a, b);
  }
}
