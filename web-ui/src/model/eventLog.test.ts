import { describe, expect, it } from 'vitest';
import type { EventRecord, Severity } from '../protocol/types';
import { CAUSED_WITHIN_MS, EMPTY_LOG, KEPT_ENTRIES, REPEAT_WITHIN_MS, acknowledge, add, happening, locked, outstanding, pass, restarted, take } from './eventLog';
import type { EventLog, Happening } from './eventLog';

let next = 0;
function event(text: string, severity: Severity, at: number, vehicle: number | null = 1): Happening {
  return { key: `k${next++}`, vehicle, severity, kind: 'status_text', text, at, endsAt: null, seq: null };
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

  it('of another severity, of nobody, or long after are no repeats, nor are those of another vehicle that want no look', () => {
    const l = log(
      event('x', 'warning', 0),
      event('x', 'critical', 2),
      event('x', 'warning', 3, null),
      event('x', 'warning', 4 + REPEAT_WITHIN_MS),
      event('y', 'info', 5),
      event('y', 'info', 6, 2),
    );
    expect(l.entries).toHaveLength(6);
  });

  it('of several vehicles are one alert that names them', () => {
    const l = log(event('x', 'warning', 0, 3), event('x', 'warning', 1, 1), event('x', 'warning', 2, 3));
    expect(l.entries).toHaveLength(1);
    expect(l.entries[0]).toMatchObject({ vehicles: [1, 3], count: 3, cause: null });
  });

  it('of something acknowledged want a new look', () => {
    const first = log(event('x', 'warning', 0));
    const l = add(acknowledge(first, first.entries[0]!.key), event('x', 'warning', 5));
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
  });
});

describe('what the server says', () => {
  let seq = 0;
  const said = (kind: EventRecord['kind'], text: string, severity: Severity, vehicle: number | null = null): EventRecord => ({
    seq: ++seq, time: 0, node: null, vehicle, severity, kind, text,
  });
  const lost = (vehicle: number, severity: Severity = 'warning'): EventRecord => said({ kind: 'link_lost' }, 'not heard', severity, vehicle);
  const log = (...records: [EventRecord, number][]): EventLog => records.reduce((l, [record, at]) => take(l, record, at), EMPTY_LOG);

  it('is acknowledged when it says so, whatever page it came from', () => {
    const [one, two] = [lost(1), said({ kind: 'notice' }, 'a notice', 'critical')];
    const both = log([one, 0], [two, 1]);
    expect(both.entries.map((e) => e.numbers)).toEqual([[two.seq], [one.seq]]);
    const seen = take(both, said({ kind: 'acknowledged', events: [two.seq] }, '1 alert acknowledged', 'info'), 2);
    expect(outstanding(seen).map((e) => e.text)).toEqual(['not heard']);
  });

  it('is one alert where it only names another vehicle', () => {
    const refused = (vehicle: number): EventRecord => said({ kind: 'refused' } as EventRecord['kind'], `uav-${vehicle}: hold refused`, 'warning', vehicle);
    const l = [1, 2].reduce((all, id) => take(all, refused(id), id, `uav-${id}`), EMPTY_LOG);
    expect(l.entries.map((e) => [e.text, e.vehicles])).toEqual([['hold refused', [1, 2]]]);
    expect(take(EMPTY_LOG, said({ kind: 'notice' }, 'uav-1: holding', 'info', 1), 0, 'uav-1').entries[0]?.text).toBe('uav-1: holding');
  });

  it('is not acknowledged when it came again in between', () => {
    const [one, two] = [lost(1), lost(2)];
    const l = log([one, 0], [two, 1], [said({ kind: 'acknowledged', events: [one.seq] }, '', 'info'), 2]);
    expect(outstanding(l)).toHaveLength(1);
  });

  it('has the late computer for a cause right after it was late, and ends with it, but for what is critical', () => {
    const late = (): EventRecord => said({ kind: 'overrun', by_s: 0.4 }, 'this computer was late by 0.4 s', 'warning');
    const l = log([late(), 0], [lost(1), 100], [lost(2), 200], [lost(3, 'critical'), 300], [late(), 500]);
    expect(outstanding(l).map((e) => [e.vehicles, e.cause, e.count])).toEqual([
      [[3], 'this computer was late by 0.4 s', 1],
      [[], null, 2],
      [[1, 2], 'this computer was late by 0.4 s', 2],
    ]);
    const over = take(l, said({ kind: 'overrun_ended' }, 'this computer is in time again', 'info'), 6000);
    expect(outstanding(over).map((e) => e.vehicles)).toEqual([[3]]);
    expect(take(over, lost(4), 6100).entries[0]?.cause).toBe(null);
  });

  it('is not explained by it if it happened before, or much later', () => {
    const late = said({ kind: 'overrun', by_s: 0.4 }, 'this computer was late by 0.4 s', 'warning');
    expect(log([lost(1), 0], [late, 50], [lost(2), 100]).entries[0]).toMatchObject({ vehicles: [1, 2], cause: null });
    expect(log([late, 0], [lost(1), 1 + CAUSED_WITHIN_MS]).entries[0]?.cause).toBe(null);
  });
});

describe('the log', () => {
  it('is bounded, and what waits to be acknowledged goes last', () => {
    let l = log(event('keep me', 'critical', 0));
    for (let k = 0; k < KEPT_ENTRIES * 2; k++) l = add(l, event(`n${k}`, 'info', k + 1));
    expect(l.entries).toHaveLength(KEPT_ENTRIES);
    expect(outstanding(l).map((e) => e.text)).toEqual(['keep me']);
  });

  it('knows the number of the last that the server said, and notices of the page have none', () => {
    const record: EventRecord = { seq: 7, time: 0, node: null, vehicle: null, severity: 'info', kind: { kind: 'notice' }, text: 'a' };
    const l = add(take(EMPTY_LOG, record, 0), event('b', 'info', 0));
    expect([l.lastSeq, l.entries.map((e) => e.numbers)]).toEqual([7, [[], [7]]]);
  });
});

describe('when the server began anew', () => {
  it('what its former run said stays to be read and wants nobody to look, and the new run counts for itself', () => {
    const before = restarted({ ...add(EMPTY_LOG, event('motors stopped', 'critical', 0)), lastSeq: 41 }, 1);
    expect(before.lastSeq).toBe(0);
    expect(before.entries.map((e) => [e.text, e.former])).toEqual([['motors stopped', true]]);
    expect(outstanding(before)).toEqual([]);
    const after = add(before, event('motors stopped', 'critical', 10));
    expect(after.entries.map((e) => [e.count, e.former])).toEqual([[1, false], [1, true]]);
    expect(outstanding(after)).toHaveLength(1);
  });

  it('twice, no two entries have the same key', () => {
    const entry = (): Happening => ({ ...event('x', 'warning', 0), key: 's1' });
    const twice = restarted(add(restarted(add(EMPTY_LOG, entry()), 1), entry()), 2);
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
    expect(outstanding(pass(l, 11_000)).map((e) => e.vehicles)).toEqual([[1], [1]]);
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
