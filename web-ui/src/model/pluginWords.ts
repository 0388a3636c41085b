// How the plugins of one vehicle are, in a few words: the worst first, names only where something is wrong. Pure.

import type { ActorStatus, VehicleInfo } from '../protocol/types';
import { LEVEL } from './severity';
import type { Level } from './severity';
import { said, t } from '../language/language.svelte';

export type PluginSummary = { text: string; level: Level };

const LEVELS: Record<ActorStatus, Level> = { running: LEVEL.normal, restarting: LEVEL.warning, given_up: LEVEL.critical };
const WORDS: Record<ActorStatus, string> = { running: 'running', restarting: 'restarting', given_up: 'given up' };

/** The model, what the vehicle carries, and the actor that flies it. */
export function pluginSummary(info: Pick<VehicleInfo, 'actor' | 'model' | 'payloads'> | undefined): PluginSummary {
  if (!info) return { text: '–', level: LEVEL.normal };
  const payloads = info.payloads ?? [];
  const all = [
    { name: 'control', status: info.actor.status },
    { name: said('model'), status: info.model.status },
    ...payloads.map((payload) => ({ name: payload.name, status: payload.health.status })),
  ];
  const wrong = all.filter((one) => one.status !== 'running').sort((a, b) => LEVELS[b.status] - LEVELS[a.status]);
  const worst = wrong[0];
  if (!worst) return { text: t('{count} running', { count: payloads.length + 1 }), level: LEVEL.normal };
  const others = wrong.length > 1 ? ` +${wrong.length - 1}` : '';
  return { text: `${worst.name === 'control' ? said(`control ${WORDS[worst.status]}`) : `${worst.name} ${said(WORDS[worst.status])}`}${others}`, level: LEVELS[worst.status] };
}
