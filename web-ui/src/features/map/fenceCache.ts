// The fences in force about the swarm's origin, worked out anew only when they, the origin or the words and units they are told in are others.

import type { Console } from '../../app/console.svelte';
import { placeFences } from '../../model/fences';
import type { PlacedFences } from '../../model/fences';
import type { FencePlan, Geodetic } from '../../protocol/types';
import { language } from '../../language/language.svelte';
import { units } from '../../language/units.svelte';

const NO_FENCES: PlacedFences = { zones: [], breachReturn: null };

export class FenceCache {
  #plan: FencePlan | null = null;
  #origin: Geodetic | null = null;
  #told = '';
  #placed: PlacedFences = NO_FENCES;

  constructor(readonly console: Console) {}

  get(): PlacedFences {
    const plan = this.console.watch.fences?.plan ?? null;
    const origin = this.console.session.fleet.projection?.origin ?? null;
    const told = `${language.name} ${units.name}`;
    if (plan !== this.#plan || origin !== this.#origin || told !== this.#told) {
      this.#told = told;
      this.#plan = plan;
      this.#origin = origin;
      this.#placed = plan ? placeFences(plan, origin) : NO_FENCES;
    }
    return this.#placed;
  }
}
