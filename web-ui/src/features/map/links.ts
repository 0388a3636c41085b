// The radio links as the map draws them: from this node to the vehicles it flies itself, and to those that another node flies. Where this
// node stands nobody measures, so lines go from the place where the swarm's frame begins, which the map says. Pure.

import { LIVE_BELOW_MS, STALE_FROM_MS } from '../../telemetry/staleness';
import type { Staleness } from '../../telemetry/staleness';
import { t } from '../../language/language.svelte';

/** Worse is greater, as with levels of urgency. */
export type Quality = 0 | 1 | 2 | 3;
export const QUALITY_WORDS = ['good', 'fair', 'poor', 'lost'] as const;

export const FAIR_LOSS_PERCENT = 5;
export const POOR_LOSS_PERCENT = 20;
export const FAIR_ROUND_TRIP_MS = 150;
export const POOR_ROUND_TRIP_MS = 500;

export type LinkCondition = {
  staleness: Staleness;
  lossPercent: number;
  /** Of the vehicle's own link, and of the way to the node that flies it; NaN if not measured. */
  roundTripMs: number;
  nodeRoundTripMs: number;
};

export function qualityOf(c: LinkCondition): Quality {
  if (c.staleness === 'lost') return 3;
  const roundTrip = Math.max(orZero(c.roundTripMs), orZero(c.nodeRoundTripMs));
  if (c.staleness === 'stale' || c.lossPercent >= POOR_LOSS_PERCENT || roundTrip >= POOR_ROUND_TRIP_MS) return 2;
  if (c.staleness === 'delayed' || c.lossPercent >= FAIR_LOSS_PERCENT || roundTrip >= FAIR_ROUND_TRIP_MS) return 1;
  return 0;
}

/** What is wrong with a link, for its label; empty for one that is good. */
export function faultText(c: LinkCondition): string {
  switch (qualityOf(c)) {
    case 0:
      return '';
    case 3:
      return t('link lost');
    default:
      break;
  }
  const roundTrip = Math.max(orZero(c.roundTripMs), orZero(c.nodeRoundTripMs));
  if (c.staleness === 'stale') return t('nothing heard for {seconds} s', { seconds: STALE_FROM_MS / 1000 });
  if (c.lossPercent >= FAIR_LOSS_PERCENT) return t('loss {percent} %', { percent: c.lossPercent });
  if (roundTrip >= FAIR_ROUND_TRIP_MS) return t('round trip {ms} ms', { ms: Math.round(roundTrip) });
  return t('nothing heard for {seconds} s', { seconds: LIVE_BELOW_MS / 1000 });
}

function orZero(value: number): number {
  return Number.isFinite(value) ? value : 0;
}
