import { describe, expect, it } from 'vitest';
import type { SwarmSnapshot } from '../../protocol/types';
import { leaderStateText, isLed, millisecondsText, rateText, rolesText } from './swarmWords';

const swarm: SwarmSnapshot = {
  swarm: 'field-7', node: 9, name: 'ground', roles: ['coordinator', 'gateway'], leader_state: 'led', term: { number: 3, coordinator: 2 },
  silent_s: null, acting: false, cut_off: false, nodes: [], sent_bytes_per_s: 0, limit_bytes_per_s: 0, strangers: 0, replayed: 0,
  transport_fault: null, ways: [],
};

describe('whom a node obeys', () => {
  it('is said by name and term', () => {
    expect(leaderStateText(swarm)).toBe('obeys node 2, term 3');
    expect(leaderStateText({ ...swarm, acting: true })).toBe('coordinates, term 3');
    expect(leaderStateText({ ...swarm, term: null, leader_state: 'nobody' })).toBe('no coordinator yet');
  });

  it('is not said of a coordinator that is silent', () => {
    const silent: SwarmSnapshot = { ...swarm, leader_state: 'awaiting', silent_s: 0.72 };
    expect(isLed(silent)).toBe(false);
    expect(leaderStateText(silent)).toBe('node 2 is silent for 0.7 s');
  });
});

describe('figures', () => {
  it('have units, or a dash', () => {
    expect(rateText(20)).toBe('20 B/s');
    expect(rateText(2345)).toBe('2.3 kB/s');
    expect(millisecondsText(0.0123)).toBe('12.3 ms');
    expect(millisecondsText(null)).toBe('–');
    expect(rolesText(['vehicle_host', 'gateway'])).toBe('flies vehicles, gateway');
  });
});
