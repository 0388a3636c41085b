// The fences in force about the swarm's origin, worked out anew only when they or the origin are others.

import type { Console } from '../../app/console.svelte';
import { placeFences } from '../../model/fences';
import type { PlacedFences } from '../../model/fences';
import type { FencePlan, Geodetic } from '../../protocol/types';

const NO_FENCES: PlacedFences = { zones: [], breachReturn: null };

export class FenceCache {
  #plan: FencePlan | null = null;
  #origin: Geodetic | null = null;
  #placed: PlacedFences = NO_FENCES;

  constructor(readonly console: Console) {}

  get(): PlacedFences {
    const plan = this.console.watch.fences?.plan ?? null;
    const origin = this.console.session.fleet.projection?.origin ?? null;
    if (plan !== this.#plan || origin !== this.#origin) {
      this.#plan = plan;
      this.#origin = origin;
      this.#placed = plan ? placeFences(plan, origin) : NO_FENCES;
    }
    return this.#placed;
  }
}
