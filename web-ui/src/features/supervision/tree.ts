// The supervision tree as it is shown: what stands under what, how each is, and what can be done about it. Pure.

import type { ActorHealth, ActorStatus, PluginHealth, SupervisedVehicle, SupervisionTree } from '../../protocol/types';
import { t } from '../../language/language.svelte';

export type Supervised = {
  /** Name in the tree, unique. */
  name: string;
  /** As an operator reads it. */
  title: string;
  /** Plugin and version; empty for an actor. */
  what: string;
  status: ActorStatus;
  incarnation: number;
  /** Starts that followed a failure; null where only starts are counted. */
  restarts: number | null;
  lastError: string;
  /** Seconds since it has its status. */
  sinceS: number;
  /** "p50, p99" of its calls; empty for an actor. */
  calls: string;
  /** What can be started anew; null where the node itself decides. */
  restart: { vehicle: number; payload: string | null } | null;
};

export type Branch = { vehicle: number; title: string; node: number | null; worst: ActorStatus; degraded: string[]; leaves: Supervised[] };

export type Tree = { actors: Supervised[]; branches: Branch[]; count: number; wrong: number };

const RANK: Record<ActorStatus, number> = { running: 0, restarting: 1, given_up: 2 };

export function worstOf(statuses: readonly ActorStatus[]): ActorStatus {
  return statuses.reduce<ActorStatus>((worst, one) => (RANK[one] > RANK[worst] ? one : worst), 'running');
}

function micros(us: number): string {
  return us >= 1000 ? `${(us / 1000).toFixed(1)} ms` : `${us.toFixed(0)} µs`;
}

function since(time: number, at: number): number {
  return Math.max(0, (time - at) / 1e6);
}

function ofActor(health: ActorHealth, title: string, time: number): Supervised {
  return {
    name: health.name, title, what: '', status: health.status, incarnation: health.incarnation, restarts: null,
    lastError: health.last_error, sinceS: since(time, health.since), calls: '', restart: null,
  };
}

function ofPlugin(health: PluginHealth, title: string, time: number, restart: Supervised['restart']): Supervised {
  const place = health.isolation === 'child' ? `${t('own process')}${health.process_id ? ` ${health.process_id}` : ''}` : t("node's process");
  return {
    name: health.name, title, what: `${health.plugin} ${health.version}, ${place}`, status: health.status, incarnation: health.incarnation,
    restarts: health.restarts, lastError: health.last_error, sinceS: since(time, health.since),
    calls: health.calls > 0 ? `${micros(health.call_p50_us)}, ${micros(health.call_p99_us)}` : '', restart,
  };
}

function branch(vehicle: SupervisedVehicle, time: number): Branch {
  const leaves = [
    ofActor(vehicle.actor, t('Control'), time),
    ofPlugin(vehicle.model, t('Model'), time, { vehicle: vehicle.id, payload: null }),
    ...vehicle.payloads.flatMap((payload) => {
      const plugin = ofPlugin(payload.plugin, payload.name, time, { vehicle: vehicle.id, payload: payload.name });
      // The actor of a payload is worth a line of its own only when it is not well.
      return payload.actor.status === 'running' ? [plugin] : [ofActor(payload.actor, `${payload.name}, actor`, time), plugin];
    }),
  ];
  return {
    vehicle: vehicle.id, title: vehicle.name, node: vehicle.node, degraded: vehicle.degraded,
    worst: worstOf(leaves.map((leaf) => leaf.status)), leaves,
  };
}

export function treeOf(answer: SupervisionTree): Tree {
  const actors = answer.actors.map((actor) => ofActor(actor, actor.name, answer.time));
  const branches = answer.vehicles.map((vehicle) => branch(vehicle, answer.time));
  const all = [...actors, ...branches.flatMap((one) => one.leaves)];
  return { actors, branches, count: all.length, wrong: all.filter((one) => one.status !== 'running').length };
}

/** "12 s", "5 min", "3 h". */
export function durationWords(seconds: number): string {
  if (seconds < 90) return `${seconds.toFixed(0)} s`;
  return seconds < 5400 ? `${(seconds / 60).toFixed(0)} min` : `${(seconds / 3600).toFixed(1)} h`;
}
