import { describe, expect, it } from 'vitest';
import type { LogEntry } from '../../model/eventLog';
import { EVERYTHING, kindsOf, shows } from './eventFilter';

const entry = (over: Partial<LogEntry>): LogEntry => ({
  key: 'k', signature: 's', vehicles: [3], severity: 'warning', kind: 'link_lost', text: 'not heard any more', cause: null, numbers: [], count: 1, firstAt: 0, lastAt: 0,
  endsAt: null, acknowledged: false, former: false, ...over,
});
const none = new Set<number>();

describe('the filter of events', () => {
  it('lets everything through at first', () => {
    expect(shows(entry({ severity: 'info', vehicles: [] }), EVERYTHING, none)).toBe(true);
  });

  it('goes by urgency, kind and whom it is about', () => {
    expect(shows(entry({}), { ...EVERYTHING, least: 'critical' }, none)).toBe(false);
    expect(shows(entry({ severity: 'critical' }), { ...EVERYTHING, least: 'critical' }, none)).toBe(true);
    expect(shows(entry({}), { ...EVERYTHING, kind: 'command' }, none)).toBe(false);
    expect(shows(entry({}), { ...EVERYTHING, about: 'swarm' }, none)).toBe(false);
    expect(shows(entry({ vehicles: [] }), { ...EVERYTHING, about: 'swarm' }, none)).toBe(true);
    expect(shows(entry({}), { ...EVERYTHING, about: 'targets' }, new Set([4]))).toBe(false);
    // Nothing selected means all of them, here as everywhere.
    expect(shows(entry({}), { ...EVERYTHING, about: 'targets' }, none)).toBe(true);
  });

  it('searches words, and numbers as vehicles', () => {
    expect(shows(entry({}), { ...EVERYTHING, search: 'heard 3' }, none)).toBe(true);
    expect(shows(entry({}), { ...EVERYTHING, search: 'heard 4' }, none)).toBe(false);
    expect(shows(entry({ vehicles: [12], text: 'at 34 m' }), { ...EVERYTHING, search: '34' }, none)).toBe(true);
    expect(shows(entry({}), { ...EVERYTHING, search: 'link lost' }, none)).toBe(true);
  });

  it('knows the kinds there are', () => {
    expect(kindsOf([entry({}), entry({ kind: 'command' }), entry({})])).toEqual(['command', 'link_lost']);
  });
});
