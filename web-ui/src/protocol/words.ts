// The words an operator reads for what the protocol says in codes, snake_case words and typed refusals.
// Must never guess: what is not known here is shown as it came.

import type { Refusal } from './types';
import { said } from '../language/language.svelte';

export { FLIGHT_MODES, FLIGHT_STATES, GNSS_FIXES, LANDED_STATES } from './generated/frame';

const SPECIAL: Record<string, string> = {
  two_d: '2D fix',
  three_d: '3D fix',
  dgps: 'DGPS',
  rtk_float: 'RTK float',
  rtk_fixed: 'RTK fixed',
  in_air: 'in the air',
  on_ground: 'on the ground',
  take_off: 'take off',
  gnss_loss: 'GNSS loss',
  gnss_disagreement: 'GNSS disagreement',
  operator_dead_man: 'operator not heard',
  energy: 'energy for the way home',
};

/** A word of the protocol as an operator reads it: `going_to` -> `going to`. */
export function spoken(word: string): string {
  return said(SPECIAL[word] ?? word.replaceAll('_', ' '));
}

/** The same with a capital first letter, for labels. */
export function label(word: string): string {
  const text = spoken(word);
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** The sentence an operator reads for a refusal. */
export function refusalText(refusal: Refusal): string {
  switch (refusal.reason) {
    case 'unknown_vehicle':
      return `there is no vehicle ${refusal.vehicle}`;
    case 'link_lost':
      return `the link to vehicle ${refusal.vehicle} is lost`;
    case 'wrong_state':
      return `cannot ${spoken(refusal.command)} while ${spoken(refusal.state)}`;
    case 'pilot_in_control':
      return "the pilot or the autopilot's failsafe is in control";
    case 'not_ready_to_arm':
      return `not ready to arm: ${refusal.detail}`;
    case 'autopilot':
      return `autopilot: ${spoken(refusal.result)}${refusal.text ? ` (${refusal.text})` : ''}`;
    case 'timed_out':
      return `no answer to ${refusal.what} within ${refusal.after_s.toFixed(1)} s`;
    case 'superseded':
      return 'replaced by a newer command';
    case 'outside_fence':
      return `outside the fence: ${refusal.detail}`;
    case 'too_fast':
      return `${refusal.speed_m_s.toFixed(1)} m/s is over the limit of ${refusal.limit_m_s.toFixed(1)} m/s`;
    case 'too_close':
      return `${refusal.distance_m.toFixed(1)} m from vehicle ${refusal.other}, under the limit of ${refusal.limit_m.toFixed(1)} m`;
    case 'invalid_value':
      return `invalid value: ${refusal.detail}`;
    case 'no_swarm_frame':
      return 'the swarm frame is not known yet';
    case 'no_position':
      return 'no position estimate';
    case 'not_enough_vehicles':
      return `${refusal.have} vehicles are available, ${refusal.need} are needed`;
    case 'stale_incarnation':
      return `incarnation ${refusal.got} is stale, ${refusal.current} is running`;
    case 'duplicate_system_id':
      return `two vehicles use system id ${refusal.system_id}`;
    case 'not_running':
      return `${refusal.what} is not running`;
    case 'not_permitted':
      return `not permitted: ${refusal.detail}`;
    case 'not_supported':
      return `not supported: ${refusal.detail}`;
    case 'unknown_payload':
      return `vehicle ${refusal.vehicle} has no payload "${refusal.payload}"`;
    case 'unknown_track':
      return `there is no track ${refusal.track}`;
    case 'preflight':
      return `preflight not met: ${refusal.items.map(spoken).join(', ')}`;
    case 'clock':
      return `clock: ${refusal.detail}`;
    case 'unknown_reference':
      return `there is no reference "${refusal.name}"`;
    default:
      // A newer server may know reasons this page does not: show its word rather than nothing.
      return spoken((refusal as { reason: string }).reason);
  }
}
