// The swarm of several nodes in words. Must never decide anything.

import type { NodeRole, NodeSnapshot, SwarmSnapshot } from '../../protocol/types';
import { t } from '../../language/language.svelte';
import type { Text } from '../../language/language.svelte';

/** A node not heard for so long is shown as gone, in seconds. */
const GONE_S = 3;

export function isLed(swarm: SwarmSnapshot): boolean {
  return swarm.leader_state === 'led';
}

/** Name of a node, as far as it is known. */
export function nodeName(swarm: SwarmSnapshot, node: number): string {
  if (node === swarm.node) return swarm.name;
  return swarm.nodes.find((n) => n.node === node)?.name || t('node {node}', { node });
}

/** Whom this node obeys. */
export function leaderStateText(swarm: SwarmSnapshot): string {
  const { term } = swarm;
  if (!term) return t('no coordinator yet');
  if (swarm.acting) return t('coordinates, term {term}', { term: term.number });
  const who = nodeName(swarm, term.coordinator);
  if (swarm.leader_state === 'led') return t('obeys {who}, term {term}', { who, term: term.number });
  return t('{who} is silent for {seconds} s', { who, seconds: (swarm.silent_s ?? 0).toFixed(1) });
}

const ROLES: Record<NodeRole, Text> = {
  vehicle_host: 'flies vehicles',
  coordinator: 'can coordinate',
  gateway: 'gateway',
  observer: 'observer',
};

export function rolesText(roles: readonly NodeRole[]): string {
  return roles.map((role) => t(ROLES[role])).join(', ') || t('no role');
}

export function isGone(node: NodeSnapshot): boolean {
  return node.heard_s > GONE_S;
}

export function rateText(bytesPerS: number): string {
  return bytesPerS >= 1000 ? `${(bytesPerS / 1000).toFixed(1)} kB/s` : `${Math.round(bytesPerS)} B/s`;
}

/** A share in percent, or a dash for what is not known. */
export function lossText(share: number | null): string {
  return share === null ? '–' : `${(share * 100).toFixed(share > 0 && share < 0.095 ? 1 : 0)} %`;
}

/** Milliseconds, or a dash for what was not measured. */
export function millisecondsText(seconds: number | null): string {
  return seconds === null ? '–' : `${(seconds * 1000).toFixed(1)} ms`;
}
