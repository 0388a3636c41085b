// How bad a vehicle's condition is, and why, in words. One order for cards, counters, map and sorting. Pure.

import type { ActorStatus, FlightState } from '../protocol/types';
import type { Staleness } from '../telemetry/staleness';
import { t } from '../language/language.svelte';

/** Worse is greater. */
export const LEVEL = { normal: 0, advisory: 1, warning: 2, critical: 3 } as const;
export type Level = (typeof LEVEL)[keyof typeof LEVEL];
export const LEVEL_WORDS = ['normal', 'advisory', 'warning', 'critical'] as const;

export const BATTERY_WARNING_PERCENT = 25;
export const BATTERY_CRITICAL_PERCENT = 12;
export const LOSS_WARNING_PERCENT = 20;
export const TRACKING_WARNING_M = 3;

/** Two-dimensional fix or less (codes 0..2) is not enough to fly on. */
const FIX_3D = 3;

export type Condition = {
  staleness: Staleness;
  flightState: FlightState;
  airborne: boolean;
  armed: boolean;
  batteryPercent: number;
  lossPercent: number;
  fix: number;
  hasPosition: boolean;
  trackingErrorM: number;
  pilotControl: boolean;
  faulted: boolean;
  actor: ActorStatus;
  model: ActorStatus;
  degraded: boolean;
};

export type Problem = { level: Level; text: string };

/** Everything that is not as it should be, worst first. */
export function problemsOf(c: Condition): Problem[] {
  const problems: Problem[] = [];
  const say = (level: Level, text: string) => problems.push({ level, text });
  if (c.faulted || c.flightState === t('faulted')) say(LEVEL.critical, t('faulted'));
  // A vehicle that is not heard and was armed when last heard counts as flying.
  if (c.staleness === 'lost') say(c.airborne || c.armed ? LEVEL.critical : LEVEL.warning, t('link lost'));
  else if (c.staleness === 'stale') say(LEVEL.warning, t('data stale'));
  if (c.batteryPercent <= BATTERY_CRITICAL_PERCENT) say(LEVEL.critical, t('battery critical'));
  else if (c.batteryPercent <= BATTERY_WARNING_PERCENT) say(LEVEL.warning, t('battery low'));
  if (c.actor === 'given_up' || c.model === 'given_up') say(LEVEL.critical, t('control given up'));
  else if (c.actor === 'restarting' || c.model === 'restarting') say(LEVEL.warning, t('control restarting'));
  if (c.degraded) say(LEVEL.warning, t('degraded'));
  if (c.pilotControl || c.flightState === 'pilot_control') say(LEVEL.warning, t('pilot in control'));
  if (c.staleness === 'live') {
    if (!c.hasPosition) say(LEVEL.warning, t('no position'));
    else if (c.fix < FIX_3D) say(LEVEL.warning, t('no 3D fix'));
    if (c.lossPercent >= LOSS_WARNING_PERCENT) say(LEVEL.warning, t('link loss {percent} %', { percent: c.lossPercent }));
    if (c.trackingErrorM >= TRACKING_WARNING_M && (c.flightState === 'following' || c.flightState === 'leading')) {
      say(LEVEL.advisory, t('out of its slot'));
    }
  }
  if (c.staleness === 'delayed') say(LEVEL.advisory, t('data delayed'));
  if (c.flightState === t('returning')) say(LEVEL.advisory, t('returning'));
  if (c.flightState === t('landing')) say(LEVEL.advisory, t('landing'));
  return problems.sort((a, b) => b.level - a.level);
}

/** The worst level of a list of problems. */
export function worst(problems: readonly Problem[]): Level {
  return problems.reduce<Level>((level, p) => (p.level > level ? p.level : level), LEVEL.normal);
}
