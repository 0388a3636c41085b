// The commands the bar offers and how each is guarded. The guard follows from the consequence: what starts motors or moves the
// whole fleet wants to be held; holding position never does. Pure.

import { HOLD_MS } from '../../components/hold';
import type { Unselected } from '../../model/targets.svelte';
import type { VehicleCommand } from '../../protocol/types';
import type { Text } from '../../language/language.svelte';

export type Verb = 'arm' | 'disarm' | 'take_off' | 'hold' | 'land' | 'return';

export type Offer = {
  verb: Verb;
  label: Text;
  describe: Text;
  /** Held whatever the targets are; otherwise only when the whole fleet is meant. */
  guard: 'never' | 'fleet' | 'always';
  /** Whom it reaches where nothing is selected: only what brings vehicles to safety reaches all. */
  unselected: Unselected;
  /** May stand in a menu where there is little room: whoever takes off needs neither. */
  seldom?: true;
};

export const OFFERS: readonly Offer[] = [
  { verb: 'arm', label: 'Arm', describe: 'Start the motors and stay on the ground', guard: 'always', unselected: 'nobody', seldom: true },
  { verb: 'disarm', label: 'Disarm', describe: 'Stop the motors; refused in the air', guard: 'always', unselected: 'nobody', seldom: true },
  { verb: 'take_off', label: 'Take off', describe: 'Arm if need be, climb to the height and hold there', guard: 'always', unselected: 'nobody' },
  { verb: 'hold', label: 'Hold', describe: 'Stop and hold the position', guard: 'never', unselected: 'all' },
  { verb: 'land', label: 'Land', describe: 'Land where it is', guard: 'fleet', unselected: 'all' },
  { verb: 'return', label: 'Return', describe: 'Fly back to the launch place and land', guard: 'fleet', unselected: 'all' },
];

export function holdMs(offer: Offer, wholeFleet: boolean): number {
  return offer.guard === 'always' || (offer.guard === 'fleet' && wholeFleet) ? HOLD_MS : 0;
}

export function commandOf(verb: Verb, heightM: number): VehicleCommand {
  return verb === 'take_off' ? { command: 'take_off', height_m: heightM } : { command: verb };
}
