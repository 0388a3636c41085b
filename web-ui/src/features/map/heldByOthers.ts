// Which vehicles are under another operator's control, as the map and the view in space mark them: worked out anew only when the node has said
// anew who has what, not for every picture.

import type { VehicleControl } from '../../protocol/types';

/** By the vehicle's id: whether who has it is heard. What is ours or nobody's is not among them. */
export type Held = ReadonlyMap<number, 'heard' | 'silent'>;

type Known = ReadonlyMap<number, VehicleControl>;

const NONE: Held = new Map();

/** `me` is the id of this console: two windows of one operator are two consoles. */
export function heldByOthers(control: Known, me: string): Held {
  const held = new Map<number, 'heard' | 'silent'>();
  for (const { vehicle, console, is_heard: heard } of control.values()) if (console.id !== me) held.set(vehicle, heard ? 'heard' : 'silent');
  return held.size === 0 ? NONE : held;
}

export class HeldCache {
  #control: Known | null = null;
  #held: Held = NONE;

  constructor(
    readonly control: () => Known,
    readonly me: string,
  ) {}

  get(): Held {
    const control = this.control();
    if (control !== this.#control) {
      this.#control = control;
      this.#held = heldByOthers(control, this.me);
    }
    return this.#held;
  }
}
