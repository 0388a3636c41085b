import { describe, expect, it } from 'vitest';
import type { EventRecord, Severity } from '../protocol/types';
import { EMPTY_LOG, KEPT_ENTRIES, REPEAT_WITHIN_MS, acknowledge, acknowledgeAll, add, happening, locked, outstanding, pass, restarted } from './eventLog';
import type { EventLog, Happening } from './eventLog';

let next = 0;
function event(text: string, severity: Severity, at: number, vehicle: number | null = 1): Happening {
  return { key: `k${next++}`, vehicle, severity, kind: 'status_text', text, at, endsAt: null };
}

function log(...events: Happening[]): EventLog {
  return events.reduce((l, e) => add(l, e), EMPTY_LOG);
}

describe('repeats', () => {
  it('are counted, and move to the top', () => {
    const l = log(event('low battery', 'warning', 0), event('other', 'info', 10), event('low battery', 'warning', 20));
    expect(l.entries.map((e) => [e.text, e.count])).toEqual([['low battery', 2], ['other', 1]]);
    expect(l.entries[0]).toMatchObject({ firstAt: 0, lastAt: 20 });
  });

  it('of another vehicle, another severity, or long after are no repeats', () => {
    const l = log(
      event('x', 'warning', 0),
      event('x', 'warning', 1, 2),
      event('x', 'critical', 2),
      event('x', 'warning', 2 + REPEAT_WITHIN_MS),
    );
    expect(l.entries).toHaveLength(4);
  });

  it('of something acknowledged want a new look', () => {
    const first = log(event('x', 'warning', 0));
    const l = add(acknowledgeAll(first), event('x', 'warning', 5));
    expect(outstanding(l)).toHaveLength(1);
  });

  it('are told by what is said, not by how much was measured, and show the newest', () => {
    const l = log(event('a call took 56 ms, limit 50 ms', 'warning', 0), event('a call took 71.5 ms, limit 50 ms', 'warning', 5));
    expect(l.entries.map((e) => [e.text, e.count])).toEqual([['a call took 71.5 ms, limit 50 ms', 2]]);
    // Another number is another thing.
    expect(log(event('node 2 lost', 'warning', 0, null), event('node 3 lost', 'warning', 1, null)).entries).toHaveLength(2);
  });

  it('of what needs no acknowledgement need none either', () => {
    expect(outstanding(log(event('x', 'info', 0), event('x', 'info', 1)))).toEqual([]);
  });
});

describe('acknowledging', () => {
  it('only warnings and worse wait for it, worst first', () => {
    const l = log(event('a', 'info', 0), event('b', 'warning', 1), event('c', 'advisory', 2), event('d', 'critical', 3), event('e', 'warning', 4));
    expect(outstanding(l).map((e) => e.text)).toEqual(['d', 'e', 'b']);
    const one = acknowledge(l, outstanding(l)[0]!.key);
    expect(outstanding(one).map((e) => e.text)).toEqual(['e', 'b']);
    expect(outstanding(acknowledgeAll(l))).toEqual([]);
  });
});

describe('the log', () => {
  it('is bounded, and what waits to be acknowledged goes last', () => {
    let l = log(event('keep me', 'critical', 0));
    for (let k = 0; k < KEPT_ENTRIES * 2; k++) l = add(l, event(`n${k}`, 'info', k + 1));
    expect(l.entries).toHaveLength(KEPT_ENTRIES);
    expect(outstanding(l).map((e) => e.text)).toEqual(['keep me']);
  });

  it('knows the greatest sequence number it took', () => {
    const l = add(add(EMPTY_LOG, event('a', 'info', 0), 7), event('b', 'info', 0), 5);
    expect(l.lastSeq).toBe(7);
  });
});

describe('when the server began anew', () => {
  it('what its former run said stays to be read and wants nobody to look, and the new run counts for itself', () => {
    const before = restarted(add(EMPTY_LOG, event('motors stopped', 'critical', 0), 41), 1);
    expect(before.lastSeq).toBe(0);
    expect(before.entries.map((e) => [e.text, e.former])).toEqual([['motors stopped', true]]);
    expect(outstanding(before)).toEqual([]);
    const after = add(before, event('motors stopped', 'critical', 10), 1);
    expect(after.entries.map((e) => [e.count, e.former])).toEqual([[1, false], [1, true]]);
    expect(outstanding(after)).toHaveLength(1);
  });

  it('twice, no two entries have the same key', () => {
    const entry = (): Happening => ({ ...event('x', 'warning', 0), key: 's1' });
    const twice = restarted(add(restarted(add(EMPTY_LOG, entry(), 1), 1), entry(), 1), 2);
    expect(new Set(twice.entries.map((e) => e.key)).size).toBe(2);
  });
});

describe('what is over by itself', () => {
  const record = (seq: number, text: string, vehicle: number | null = null): EventRecord => ({
    seq, time: 0, node: null, vehicle, severity: 'warning', kind: { kind: 'emergency_stop' }, text,
  });
  const unlocking = (seq: number, at: number): Happening => happening(record(seq, 'emergency stop unlocked for 10 s'), at);

  it('an unlocked emergency stop wants no look once its time is over, anything else does', () => {
    const l = log(unlocking(1, 1000), event('x', 'warning', 1000), happening(record(2, 'uav-1: EMERGENCY STOP, motors off', 1), 1000));
    expect(outstanding(pass(l, 10_999))).toHaveLength(3);
    expect(pass(l, 10_999)).toBe(l);
    expect(outstanding(pass(l, 11_000)).map((e) => e.vehicle)).toEqual([1, 1]);
    expect(pass(l, 11_000).entries).toHaveLength(3);
  });

  it('unlocked again it is open again, for as long as the new key is good', () => {
    const again = add(pass(log(unlocking(1, 1000)), 11_000), unlocking(2, 20_000));
    expect(outstanding(pass(again, 29_000)).map((e) => e.count)).toEqual([2]);
    expect(outstanding(pass(again, 30_000))).toEqual([]);
  });

  it('locked by hand it is over at once, but not if somebody else has unlocked it since', () => {
    expect(outstanding(locked(log(unlocking(1, 1000), event('x', 'warning', 0)), 1500)).map((e) => e.text)).toEqual(['x']);
    expect(outstanding(locked(log(unlocking(1, 1000), unlocking(2, 4000)), 1500))).toHaveLength(1);
  });
});
