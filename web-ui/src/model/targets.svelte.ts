// Whom commands are for: the one visible set of targets. Nothing selected means every vehicle, and the page says so in words.
// Must never change by itself: a vehicle that is lost stays selected.

import { SvelteSet } from 'svelte/reactivity';
import type { Targets as WireTargets } from '../protocol/types';
import type { VehicleRow } from './vehicleRow.svelte';

export class Targets {
  readonly selected = new SvelteSet<number>();
  readonly #rows: () => readonly VehicleRow[];

  constructor(rows: () => readonly VehicleRow[]) {
    this.#rows = rows;
  }

  /** Nothing is selected: commands go to the whole fleet. */
  all = $derived.by(() => this.selected.size === 0);

  /** Ids of the targets in ascending order. */
  ids = $derived.by(() =>
    this.all ? this.#rows().map((row) => row.id) : [...this.selected].sort((a, b) => a - b),
  );

  /** Whether commands would reach every vehicle, by selection or for want of one: then they are guarded as fleet-wide. */
  wholeFleet = $derived.by(() => this.all || this.ids.length >= this.#rows().length);

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

  /** As the server is told. */
  wire(): WireTargets {
    return this.all ? 'all' : { vehicles: this.ids };
  }
}
