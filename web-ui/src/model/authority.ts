// Who has control authority over vehicles, as one console sees it: its own, another's, nobody's; and who asks it for what. Pure.
// Must never decide who may command: the node does, and what is known here is a moment old.

import type { Console, ControlReceipt, VehicleControl } from '../protocol/types';
import { refusalText } from '../protocol/words';
import { t } from '../language/language.svelte';

export type Authority = {
  whose: 'mine' | 'others' | 'nobody';
  /** What people call who has it; empty if nobody has. */
  name: string;
  /** Who has it is heard. If not, anybody may take it. */
  heard: boolean;
  /** This console asks for it. */
  asked: boolean;
};

export const NOBODY: Authority = { whose: 'nobody', name: '', heard: true, asked: false };

/** What another console is called by this one: an operator with two windows open has one name and two consoles. */
export function nameOf(console: Console, me: Console): string {
  return console.id !== me.id && console.name === me.name ? `${console.name} (${console.id.slice(0, 4)})` : console.name;
}

/** `control` is what the node says of the vehicle, `me` this console. */
export function authorityOf(control: VehicleControl | undefined, me: Console): Authority {
  if (!control) return NOBODY;
  const { console, is_heard: heard, requests } = control;
  const name = nameOf(console, me);
  if (console.id === me.id) return { whose: 'mine', name, heard: true, asked: false };
  return { whose: 'others', name, heard, asked: requests.some((request) => request.console.id === me.id) };
}

/** Vehicles by whose they are, and by what this console can do about it. */
export type Division = {
  mine: number[];
  others: number[];
  nobodys: number[];
  /** Nobody's, and those of others that are not heard any more. */
  takeable: number[];
  /** Others' that are not asked for yet. */
  askable: number[];
  asked: number[];
  /** The names of the others, each once. */
  names: string[];
};

export function divide(ids: readonly number[], of: (id: number) => Authority): Division {
  const division: Division = { mine: [], others: [], nobodys: [], takeable: [], askable: [], asked: [], names: [] };
  for (const id of ids) {
    const authority = of(id);
    division[authority.whose === 'nobody' ? 'nobodys' : authority.whose].push(id);
    if (authority.whose === 'nobody' || !authority.heard) division.takeable.push(id);
    else if (authority.whose === 'others') division[authority.asked ? 'asked' : 'askable'].push(id);
    if (authority.whose === 'others' && !division.names.includes(authority.name)) division.names.push(authority.name);
  }
  return division;
}

/** A console that asks this one for vehicles. */
export type Asking = {
  console: Console;
  /** What it is called here. */
  name: string;
  vehicles: number[];
  /** One for each request: the same vehicle asked for again is another request. */
  keys: string[];
};

/** Who asks this console for what it has, the first first, without the requests in `declined`. */
export function askingFor(control: Iterable<VehicleControl>, me: Console, declined: ReadonlySet<string>): Asking[] {
  const found = new Map<string, Asking & { since: number }>();
  for (const { vehicle, console, requests } of control) {
    if (console.id !== me.id) continue;
    for (const request of requests) {
      const key = `${request.console.id} ${vehicle} ${request.since}`;
      if (declined.has(key)) continue;
      const asking = found.get(request.console.id) ?? { console: request.console, name: nameOf(request.console, me), vehicles: [], keys: [], since: request.since };
      asking.vehicles.push(vehicle);
      asking.keys.push(key);
      asking.since = Math.min(asking.since, request.since);
      found.set(request.console.id, asking);
    }
  }
  return [...found.values()].sort((a, b) => a.since - b.since).map(({ since: _, ...asking }) => asking);
}

/** Why some vehicles refused, each reason once; empty if none did. */
export function refusalsText(receipts: readonly ControlReceipt[]): string {
  const reasons = new Set(receipts.flatMap(({ refusal }) => (refusal ? [refusalText(refusal)] : [])));
  const [first, ...others] = reasons;
  if (first === undefined) return '';
  return others.length === 0 ? first : `${first}; ${t('and {count} more', { count: others.length })}`;
}
