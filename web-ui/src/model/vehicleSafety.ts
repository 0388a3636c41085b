// What the safety functions of the node say of one vehicle, in the words an operator reads: the failsafe's alarms and its order, the
// charge against the way home, whom it gives way to. Must never decide anything: limits and reactions are the server's. Pure.

import type { Alarm, Avoidance, EnergyState, FailsafeState, Order, Reaction, VehicleSafety } from '../protocol/types';
import { label, spoken } from '../protocol/words';
import { LEVEL } from './severity';
import type { Level, Problem } from './severity';
import { t } from '../language/language.svelte';
import type { Text } from '../language/language.svelte';
import { inUnits } from '../language/units.svelte';

const REACTIONS: Record<Reaction, Text> = {
  warn: 'warning only',
  hold: 'hold',
  return: 'return',
  land: 'land',
  release: 'release to the autopilot',
};

/** A number with its unit as short as it can be read; what is not a number is not known. */
export function quantity(measured: number | null, measuredIn: string): string {
  if (measured === null || !Number.isFinite(measured)) return t('not known');
  const { value, unit } = inUnits(measured, measuredIn);
  const size = Math.abs(value);
  const digits = size >= 100 ? 0 : size >= 1 || size === 0 ? 1 : 2;
  const text = value.toFixed(digits).replace(/\.0+$/, '');
  return unit === '' ? text : `${text} ${unit}`;
}

/** A duration as it is spoken: `8 s`, `3 min`, `2.5 h`. */
export function durationText(seconds: number | null): string {
  if (seconds === null || !Number.isFinite(seconds)) return t('not known');
  if (seconds < 90) return `${Math.max(0, Math.round(seconds))} s`;
  if (seconds < 90 * 60) return `${Math.round(seconds / 60)} min`;
  return `${(seconds / 3600).toFixed(1)} h`;
}

export function percentText(share: number | null): string {
  return share === null || !Number.isFinite(share) ? '–' : `${Math.round(share * 100)} %`;
}

/** One alarm: trigger, value against limit, reaction, how long. `serverNowMs` is the node's clock. */
export function alarmText(alarm: Alarm, serverNowMs: number): string {
  const why = alarm.report_only === null ? '' : ` (${spoken(alarm.report_only)})`;
  return (
    `${label(alarm.trigger)} ${quantity(alarm.value, alarm.unit)}, ${t('limit')} ${quantity(alarm.limit, alarm.unit)}: ` +
    `${t(REACTIONS[alarm.reaction])}${why}, ${t('for {time}', { time: since(alarm.since, serverNowMs) })}`
  );
}

/** The order in force. */
export function orderText(order: Order, serverNowMs: number): string {
  const state = order.recovered ? t(', cause is over') : order.effective_at === null ? t(', not taken up yet') : '';
  return t('Ordered: {reaction} because of {trigger}, for {time}', { reaction: t(REACTIONS[order.reaction]), trigger: spoken(order.trigger), time: since(order.ordered_at, serverNowMs) }) + state;
}

export function avoidanceText(avoiding: Avoidance): string {
  const whom = avoiding.because === null ? t('Kept inside of the fence') : t('Gives way to {who}', { who: avoiding.because });
  const far = avoiding.distance_m === null ? '' : t(', {distance} away', { distance: quantity(avoiding.distance_m, 'm') });
  return `${whom}${far}${avoiding.feasible ? '' : t('; the distance cannot be kept')}`;
}

/** The return time of an energy state, in words; empty if nothing presses and none is known. */
export function returnText(energy: EnergyState): string {
  if (energy.level === 'land_now') return t('land now');
  if (energy.level === 'return_now' || energy.return_in_s <= 0) return t('now');
  return durationText(energy.return_in_s);
}

const ENERGY: Record<EnergyState['level'], { level: Level; text: Text } | null> = {
  ok: null,
  replan_soon: { level: LEVEL.advisory, text: 'return soon for energy' },
  return_now: { level: LEVEL.warning, text: 'return now for energy' },
  land_now: { level: LEVEL.critical, text: 'land now for energy' },
};

/** What of it is not as it should be. On the ground an energy that is low is the preflight report's to say. */
export function safetyProblems(safety: VehicleSafety | null, airborne: boolean): Problem[] {
  if (!safety) return [];
  const problems: Problem[] = [];
  if (safety.stopped) problems.push({ level: LEVEL.critical, text: t('motors stopped') });
  problems.push(...failsafeProblems(safety.failsafe));
  const energy = safety.energy && airborne ? ENERGY[safety.energy.level] : null;
  if (energy) problems.push({ level: energy.level, text: t(energy.text) });
  if (safety.avoiding) {
    problems.push(
      safety.avoiding.feasible
        ? { level: LEVEL.advisory, text: t('gives way') }
        : { level: LEVEL.warning, text: t('distance cannot be kept') },
    );
  }
  return problems;
}

function failsafeProblems(failsafe: FailsafeState | null): Problem[] {
  if (!failsafe) return [];
  const problems: Problem[] = [];
  const order = failsafe.order;
  if (order) {
    const grave = order.reaction === 'land' || order.reaction === 'release';
    problems.push({ level: grave ? LEVEL.critical : LEVEL.warning, text: t('{trigger}: {reaction} ordered', { trigger: spoken(order.trigger), reaction: t(REACTIONS[order.reaction]) }) });
  }
  for (const alarm of failsafe.alarms) {
    if (alarm.trigger === order?.trigger) continue;
    const level = alarm.report_only === 'on_ground' ? LEVEL.advisory : LEVEL.warning;
    problems.push({ level, text: spoken(alarm.trigger) });
  }
  return problems;
}

/** Time since a moment on the node's clock (microseconds). */
function since(at: number, serverNowMs: number): string {
  return durationText(Math.max(0, (serverNowMs - at / 1000) / 1000));
}
