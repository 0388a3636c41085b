// Whose orders a vehicle flies: the coordinator that the node of the vehicle obeys. Pure.

import type { SwarmSnapshot } from '../../protocol/types';
import { t } from '../../language/language.svelte';

export type Coordinator = { text: string; warn: boolean };

/** `node` is the node that flies the vehicle; null where a node flies its vehicles alone. */
export function coordinatorOf(swarm: SwarmSnapshot | null, node: number | null): Coordinator {
  if (!swarm) return { text: t('this node'), warn: false };
  const home = node ?? swarm.node;
  const host = swarm.nodes.find((other) => other.node === home);
  const term = home === swarm.node ? swarm.term : host?.obeys;
  if (!term) return { text: t('nobody'), warn: true };
  // What a node tells of times is not to be trusted while its clock is not.
  if (host?.clock_fault) return { text: t('clock of {node} jumped', { node: host.name || t('node {node}', { node: home }) }), warn: true };
  const who = term.coordinator;
  const name = who === swarm.node ? swarm.name : swarm.nodes.find((other) => other.node === who)?.name;
  // Nodes that obey different ones do not fly one plan.
  const other = swarm.term !== null && (swarm.term.coordinator !== who || swarm.term.number !== term.number);
  return { text: `${name || t('node {node}', { node: who })}${other ? t(', not ours') : ''}`, warn: other };
}
