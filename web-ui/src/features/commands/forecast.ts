// What a command will do and to whom, before it is given: who takes part, and who will refuse it as things look from here. Pure.
// Must never keep a command from being sent: what the page knows is a moment old, and the vehicle decides.

import { idRanges } from '../../model/idRanges';
import type { Offer, Verb } from './commandSet';
import { t } from '../../language/language.svelte';
import { setText } from '../../language/units.svelte';

/** What is looked at of a vehicle. */
export type Subject = {
  id: number;
  airborne: boolean;
  armed: boolean;
  readyToArm: boolean;
  staleness: string;
  flightState: string;
  stopped: boolean;
};

export type Forecast = {
  /** "Climb to 10 m and hold there: 1-3, 5". */
  text: string;
  /** "2 on the ground: 4, 6"; empty if nobody is expected to refuse. */
  doubts: string[];
  able: number;
};

const NEEDS_AIR: readonly Verb[] = ['hold', 'land', 'return'];
/** These may be given by anybody, whoever has control authority over the vehicle. */
const FOR_EVERYBODY: readonly Verb[] = ['hold', 'land', 'return'];

type Doubt = 'not heard' | 'flown by a pilot' | 'on the ground' | 'in the air' | 'disarmed already' | 'armed already' | 'not ready to arm';

/** Why this vehicle itself will refuse, or an empty text. */
function doubt(s: Subject, verb: Verb): Doubt | '' {
  if (s.staleness === 'lost') return 'not heard';
  if (s.flightState === 'pilot_control') return 'flown by a pilot';
  if (NEEDS_AIR.includes(verb)) return s.airborne ? '' : 'on the ground';
  if (s.airborne) return 'in the air';
  if (verb === 'disarm') return s.armed ? '' : 'disarmed already';
  if (verb === 'arm' && s.armed) return 'armed already';
  return s.armed || s.readyToArm ? '' : 'not ready to arm';
}

/** `heldBy` gives the name of another operator who has control authority over the vehicle, or an empty text. */
export function forecast(subjects: readonly Subject[], offer: Offer, heightM: number, heldBy: (id: number) => string = () => ''): Forecast {
  const able: number[] = [];
  const unable = new Map<string, number[]>();
  for (const subject of subjects) {
    const holder = FOR_EVERYBODY.includes(offer.verb) ? '' : heldBy(subject.id);
    const itself = doubt(subject, offer.verb);
    const why = holder !== '' ? t('under the control of {name}', { name: holder }) : itself === '' ? '' : t(itself);
    if (why === '') able.push(subject.id);
    else unable.set(why, [...(unable.get(why) ?? []), subject.id]);
  }
  const what = offer.verb === 'take_off' ? t('Arm if need be, climb to {height} and hold there', { height: setText('height', heightM) }) : t(offer.describe);
  return {
    text: `${what}: ${able.length === 0 ? t('nobody') : idRanges(able)}`,
    doubts: [...unable].map(([why, ids]) => `${ids.length} ${why}: ${idRanges(ids)}`),
    able: able.length,
  };
}
