// What the detectors of vehicles have found last, asked for while video of such a vehicle is in sight. Must never ask for what nobody looks at.

import { getPayloads } from '../protocol/rest';
import type { PayloadSnapshot } from '../protocol/types';
import { Pulse } from './pulse';

const EVERY_MS = 200;
/** Above so many vehicles the pace goes down with their number. */
const FULL_PACE = 4;

type Listener = () => void;
type Looked = { pulse: Pulse; payloads: readonly PayloadSnapshot[]; listeners: Set<Listener> };

export class Findings {
  readonly #looked = new Map<number, Looked>();

  /** `wanted` says whether they are to be shown, and the node is heard. */
  constructor(readonly wanted: () => boolean) {}

  /** What the vehicle carried when it was asked last. */
  of(vehicle: number): readonly PayloadSnapshot[] {
    return this.#looked.get(vehicle)?.payloads ?? [];
  }

  /** Asks until the returned function is called; `listener` is called with each answer. All that look at one vehicle share the question. */
  watch(vehicle: number, listener: Listener): () => void {
    const looked = this.#looked.get(vehicle) ?? this.#begin(vehicle);
    looked.listeners.add(listener);
    return () => {
      looked.listeners.delete(listener);
      if (looked.listeners.size > 0) return;
      looked.pulse.stop();
      this.#looked.delete(vehicle);
    };
  }

  #begin(vehicle: number): Looked {
    const looked: Looked = {
      pulse: new Pulse(
        async () => {
          looked.payloads = await getPayloads(vehicle);
          for (const listener of looked.listeners) listener();
        },
        () => EVERY_MS * Math.max(1, this.#looked.size / FULL_PACE),
        this.wanted,
      ),
      payloads: [],
      listeners: new Set(),
    };
    this.#looked.set(vehicle, looked);
    looked.pulse.start();
    return looked;
  }
}
