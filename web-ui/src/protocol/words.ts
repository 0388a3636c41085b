// The words an operator reads for what the protocol says in codes, snake_case words and typed refusals.
// Must never guess: what is not known here is shown as it came.

import type { Refusal } from './types';
import { said, t } from '../language/language.svelte';
import { figureText } from '../language/units.svelte';

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
      return t('there is no vehicle {vehicle}', { vehicle: refusal.vehicle });
    case 'link_lost':
      return t('the link to vehicle {vehicle} is lost', { vehicle: refusal.vehicle });
    case 'wrong_state':
      return t('cannot {command} while {state}', { command: spoken(refusal.command), state: spoken(refusal.state) });
    case 'pilot_in_control':
      return t("the pilot or the autopilot's failsafe is in control");
    case 'not_ready_to_arm':
      return `${t('not ready to arm')}: ${refusal.detail}`;
    case 'autopilot':
      return `${t('autopilot')}: ${spoken(refusal.result)}${refusal.text ? ` (${refusal.text})` : ''}`;
    case 'timed_out':
      return t('no answer to {what} within {seconds} s', { what: refusal.what, seconds: refusal.after_s.toFixed(1) });
    case 'superseded':
      return t('replaced by a newer command');
    case 'outside_fence':
      return `${t('outside the fence')}: ${refusal.detail}`;
    case 'too_fast':
      return t('{speed} is over the limit of {limit}', { speed: figureText('speed', refusal.speed_m_s), limit: figureText('speed', refusal.limit_m_s) });
    case 'too_close':
      return t('{distance} from vehicle {other}, under the limit of {limit}', {
        distance: figureText('length', refusal.distance_m), other: refusal.other, limit: figureText('length', refusal.limit_m),
      });
    case 'invalid_value':
      return `${t('invalid value')}: ${refusal.detail}`;
    case 'no_swarm_frame':
      return t('the swarm frame is not known yet');
    case 'no_position':
      return t('no position estimate');
    case 'not_enough_vehicles':
      return t('{have} vehicles are available, {need} are needed', { have: refusal.have, need: refusal.need });
    case 'stale_incarnation':
      return t('incarnation {got} is stale, {current} is running', { got: refusal.got, current: refusal.current });
    case 'duplicate_system_id':
      return t('two vehicles use system id {id}', { id: refusal.system_id });
    case 'not_running':
      return t('{what} is not running', { what: refusal.what });
    case 'not_permitted':
      return `${t('not permitted')}: ${refusal.detail}`;
    case 'not_sent':
      return `${t('not sent')}: ${refusal.detail}`;
    case 'not_supported':
      return `${t('not supported')}: ${refusal.detail}`;
    case 'unknown_payload':
      return t('vehicle {vehicle} has no payload "{payload}"', { vehicle: refusal.vehicle, payload: refusal.payload });
    case 'unknown_track':
      return t('there is no track {track}', { track: refusal.track });
    case 'preflight':
      return t('preflight not met: {items}', { items: refusal.items.map(spoken).join(', ') });
    case 'no_control_authority':
      return t('vehicle {vehicle} is under the control of {holder}', { vehicle: refusal.vehicle, holder: refusal.holder });
    case 'clock':
      return `${t('clock')}: ${refusal.detail}`;
    case 'unknown_reference':
      return t('there is no reference "{name}"', { name: refusal.name });
    default:
      // A newer server may know reasons this page does not: show its word rather than nothing.
      return spoken((refusal as { reason: string }).reason);
  }
}
