// Where vehicles are drawn between the frames of the socket: where they said they are, carried forward by the velocity they said. Must never
// change what a vehicle said: figures are made of that, but for lengths measured on the map, which end where the vehicle is drawn.

import { FLAG } from '../protocol/frame';
import { LANDED_STATES } from '../protocol/words';
import type { Fleet } from './fleet';
import { classify } from './staleness';

/** A place is carried for at most so long: through a lost frame or two, not through silence. */
export const CARRY_LIMIT_MS = 300;
/** One that is slower than this and on the ground stands. */
const STANDS_BELOW_M_S = 0.1;

/** Carries the shown places to `now`, those of vehicles that are live; says whether anything is under way. `pace`: so many seconds of their flight pass in
 *  one, other than one in a recording only; none while it stands. */
export function carry(fleet: Fleet, now: number, pace = 1): boolean {
  let underWay = false;
  for (let i = 0; i < fleet.size; i++) {
    if (fleet.present[i] !== 1 || !fleet.has(i, FLAG.position)) continue;
    const live = classify(fleet.ageMs(i, now), fleet.has(i, FLAG.connected)) === 'live';
    const [north, east, down] = [fleet.velocityNorth[i] ?? 0, fleet.velocityEast[i] ?? 0, fleet.velocityDown[i] ?? 0];
    const seconds = live ? Math.min(CARRY_LIMIT_MS * Math.max(1, pace), Math.max(0, now - (fleet.placedAt[i] ?? now)) * pace) / 1000 : 0;
    fleet.shownNorthM[i] = (fleet.northM[i] ?? 0) + north * seconds;
    fleet.shownEastM[i] = (fleet.eastM[i] ?? 0) + east * seconds;
    fleet.shownAltitudeM[i] = (fleet.altitudeM[i] ?? 0) - down * seconds;
    underWay ||= live && pace > 0 && (isAirborne(fleet, i) || Math.hypot(north, east, down) >= STANDS_BELOW_M_S);
  }
  return underWay;
}

export function isAirborne(fleet: Fleet, index: number): boolean {
  const landed = LANDED_STATES[fleet.landed[index] ?? 0];
  return landed === 'unknown' ? fleet.has(index, FLAG.armed) : landed !== 'on_ground';
}
