// Whom commands are for: the one visible set of targets, the same for every button of the page. Nothing selected means nobody, but for what
// brings vehicles to safety, which then reaches all and says so. Must never change by itself while the same server runs: a vehicle that is
// lost stays selected.

import { SvelteSet } from 'svelte/reactivity';
import type { Targets as WireTargets } from '../protocol/types';
import type { VehicleRow } from './vehicleRow.svelte';

/** Whom a command reaches where nothing is selected. */
export type Unselected = 'nobody' | 'all';

export type Reach = { ids: readonly number[]; wire: WireTargets; all: boolean };

export class Targets {
  readonly selected = new SvelteSet<number>();
  readonly #rows: () => readonly Pick<VehicleRow, 'id'>[];
  #pointed = $state.raw<ReadonlySet<number> | null>(null);

  constructor(rows: () => readonly Pick<VehicleRow, 'id'>[]) {
    this.#rows = rows;
  }

  none = $derived.by(() => this.selected.size === 0);

  /** Ids of the targets in ascending order. */
  ids = $derived.by(() => [...this.selected].sort((a, b) => a - b));

  everyone = $derived.by(() => this.#rows().map((row) => row.id));

  /** Whom the map and the list of heights mark: whom the button before the finger acts on, else the targets. */
  marked = $derived.by<ReadonlySet<number>>(() => this.#pointed ?? this.selected);

  /** Whom a command reaches. */
  reach(unselected: Unselected): Reach {
    if (this.none && unselected === 'all') return { ids: this.everyone, wire: 'all', all: true };
    return { ids: this.ids, wire: { vehicles: this.ids }, all: !this.none && this.everyone.every((id) => this.selected.has(id)) };
  }

  /** This vehicle alone is selected. */
  isOnly(id: number): boolean {
    return this.selected.size === 1 && this.selected.has(id);
  }

  toggle(id: number): void {
    if (!this.selected.delete(id)) this.selected.add(id);
  }

  /** Adds several, as a selection box does. */
  add(ids: Iterable<number>): void {
    for (const id of ids) this.selected.add(id);
  }

  only(ids: Iterable<number>): void {
    const wanted = new Set(ids);
    for (const id of [...this.selected]) if (!wanted.has(id)) this.selected.delete(id);
    this.add(wanted);
  }

  clear(): void {
    this.selected.clear();
  }

  /** A button that acts on these is before the finger; null: none is any more. */
  point(ids: readonly number[] | null): void {
    this.#pointed = ids && new Set(ids);
  }
}
