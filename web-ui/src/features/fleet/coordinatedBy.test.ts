import { describe, expect, it } from 'vitest';
import type { NodeSnapshot, SwarmSnapshot, TermSnapshot } from '../../protocol/types';
import { coordinatorOf } from './coordinatedBy';

const term = (number: number, coordinator: number): TermSnapshot => ({ number, coordinator }) as TermSnapshot;
const node = (id: number, name: string, obeys: TermSnapshot | null, clock_fault = false): NodeSnapshot => ({ node: id, name, obeys, clock_fault }) as NodeSnapshot;
const swarm = (own: TermSnapshot | null, nodes: NodeSnapshot[]): SwarmSnapshot => ({ node: 1, name: 'ground', term: own, nodes }) as SwarmSnapshot;

describe('who coordinates a vehicle', () => {
  it('is this node where there is no swarm', () => {
    expect(coordinatorOf(null, null)).toEqual({ text: 'this node', warn: false });
  });

  it('is whom the node of the vehicle obeys', () => {
    const one = swarm(term(3, 2), [node(2, 'alpha', term(3, 2)), node(3, 'beta', term(3, 2))]);
    expect(coordinatorOf(one, 1)).toEqual({ text: 'alpha', warn: false });
    expect(coordinatorOf(one, 3)).toEqual({ text: 'alpha', warn: false });
  });

  it('is said aloud if it is another than ours, or nobody', () => {
    const split = swarm(term(4, 1), [node(2, 'alpha', term(3, 2)), node(3, '', null)]);
    expect(coordinatorOf(split, 2)).toEqual({ text: 'alpha, not ours', warn: true });
    expect(coordinatorOf(split, 3)).toEqual({ text: 'nobody', warn: true });
  });

  it('is in doubt while the clock of its node is', () => {
    const jumped = swarm(term(3, 1), [node(2, 'alpha', term(3, 1), true)]);
    expect(coordinatorOf(jumped, 2)).toEqual({ text: 'clock of alpha jumped', warn: true });
  });
});
