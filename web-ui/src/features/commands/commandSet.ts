// The commands the bar offers and how each is guarded. The guard follows from the consequence: what starts motors or moves the
// whole fleet wants to be held; holding position never does. Pure.

import { HOLD_MS } from '../../components/hold';
import type { VehicleCommand } from '../../protocol/types';
import type { Text } from '../../language/language.svelte';

export type Verb = 'arm' | 'disarm' | 'take_off' | 'hold' | 'land' | 'return';

export type Offer = {
  verb: Verb;
  label: Text;
  describe: Text;
  /** Held whatever the targets are; otherwise only when the whole fleet is meant. */
  guard: 'never' | 'fleet' | 'always';
};

export const OFFERS: readonly Offer[] = [
  { verb: 'arm', label: 'Arm', describe: 'Start the motors and stay on the ground', guard: 'always' },
  { verb: 'disarm', label: 'Disarm', describe: 'Stop the motors; refused in the air', guard: 'always' },
  { verb: 'take_off', label: 'Take off', describe: 'Arm if need be, climb to the height and hold there', guard: 'always' },
  { verb: 'hold', label: 'Hold', describe: 'Stop and hold the position', guard: 'never' },
  { verb: 'land', label: 'Land', describe: 'Land where it is', guard: 'fleet' },
  { verb: 'return', label: 'Return', describe: 'Fly back to the launch place and land', guard: 'fleet' },
];

export function holdMs(offer: Offer, wholeFleet: boolean): number {
  return offer.guard === 'always' || (offer.guard === 'fleet' && wholeFleet) ? HOLD_MS : 0;
}

export function commandOf(verb: Verb, heightM: number): VehicleCommand {
  return verb === 'take_off' ? { command: 'take_off', height_m: heightM } : { command: verb };
}
