import { describe, expect, it } from 'vitest';
import type { ActorHealth, PluginHealth, SupervisionTree } from '../../protocol/types';
import { durationWords, treeOf, worstOf } from './tree';

const actor = (name: string, status: ActorHealth['status'] = 'running'): ActorHealth => ({ name, status, incarnation: 2, last_error: '', since: 1e6 });
const plugin = (name: string, over: Partial<PluginHealth> = {}): PluginHealth => ({
  name, plugin: 'camera', version: '0.1.0', isolation: 'child', process_id: 77, status: 'running', incarnation: 3, restarts: 2,
  last_error: 'crashed', since: 4e6, calls: 10, call_p50_us: 12, call_p99_us: 2300, ...over,
});

const answer: SupervisionTree = {
  time: 10e6,
  actors: [actor('coordinator')],
  vehicles: [
    {
      id: 1, node: null, name: 'uav-1', actor: actor('vehicle-1'), model: plugin('model-1', { isolation: 'in_process', process_id: null, calls: 0 }),
      payloads: [{ name: 'camera', kind: 'camera', actor: actor('payload-1-camera', 'restarting'), plugin: plugin('payload-1-camera', { status: 'given_up' }), transport_fault: '' }],
      degraded: ['camera has given up'],
    },
  ],
};

describe('the supervision tree', () => {
  it('has the worst of what stands below a vehicle on the vehicle', () => {
    const tree = treeOf(answer);
    expect(tree.branches[0]).toMatchObject({ vehicle: 1, worst: 'given_up' });
    expect(tree.branches[0]?.leaves.map((leaf) => leaf.title)).toEqual(['Control', 'Model', 'camera, actor', 'camera']);
    expect([tree.count, tree.wrong]).toEqual([5, 2]);
    expect(worstOf([])).toBe('running');
  });

  it('says where a plugin runs, what its calls cost and what can be started anew', () => {
    const [control, model, , camera] = treeOf(answer).branches[0]!.leaves;
    expect(control).toMatchObject({ restart: null, restarts: null, sinceS: 9, calls: '' });
    expect(model).toMatchObject({ what: "camera 0.1.0, node's process", calls: '', restart: { vehicle: 1, payload: null } });
    expect(camera).toMatchObject({
      what: 'camera 0.1.0, own process 77', calls: '12 µs, 2.3 ms', restarts: 2, incarnation: 3, sinceS: 6, restart: { vehicle: 1, payload: 'camera' },
    });
  });

  it('tells times in words', () => {
    expect([12, 300, 7200].map(durationWords)).toEqual(['12 s', '5 min', '2.0 h']);
  });
});
