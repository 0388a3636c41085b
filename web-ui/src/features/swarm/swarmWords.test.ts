import { describe, expect, it } from 'vitest';
import type { SwarmSnapshot } from '../../protocol/types';
import { allegianceText, isLed, millisecondsText, rateText, rolesText } from './swarmWords';

const swarm: SwarmSnapshot = {
  swarm: 'field-7', node: 9, name: 'ground', roles: ['coordinator', 'gateway'], allegiance: 'led', term: { number: 3, coordinator: 2 },
  silent_s: null, acting: false, cut_off: false, nodes: [], sent_bytes_per_s: 0, limit_bytes_per_s: 0, strangers: 0, replayed: 0,
  transport_fault: null, ways: [],
};

describe('whom a node obeys', () => {
  it('is said by name and term', () => {
    expect(allegianceText(swarm)).toBe('obeys node 2, term 3');
    expect(allegianceText({ ...swarm, acting: true })).toBe('coordinates, term 3');
    expect(allegianceText({ ...swarm, term: null, allegiance: 'nobody' })).toBe('no coordinator yet');
  });

  it('is not said of a coordinator that is silent', () => {
    const silent: SwarmSnapshot = { ...swarm, allegiance: 'awaiting', silent_s: 0.72 };
    expect(isLed(silent)).toBe(false);
    expect(allegianceText(silent)).toBe('node 2 is silent for 0.7 s');
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
