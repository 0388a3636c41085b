// The life cycle of commands, in the order and out of the order in which news of it can come.

import { describe, expect, it } from 'vitest';
import type { CommandProgress } from '../protocol/types';
import { EMPTY, KEPT_BATCHES, latestOf, reduce, stillSaid, tally } from './commandLedger';
import type { Action, Entry, Ledger, Phase } from './commandLedger';

const EXECUTING: CommandProgress = { progress: 'executing' };
const DONE: CommandProgress = { progress: 'done' };
const begin = (key: number, vehicles: number[]): Action => ({ type: 'begin', key, label: 'Land', detail: '', vehicles });
const taken = (key: number, id: number, vehicles: number[]): Action => ({
  type: 'receipts',
  key,
  receipts: vehicles.map((vehicle) => ({ vehicle, id, refusal: null })),
});
const progress = (id: number, vehicle: number, p: CommandProgress): Action => ({ type: 'progress', id, vehicle, progress: p });

function after(...actions: Action[]): Ledger {
  return actions.reduce((ledger, action, k) => reduce(ledger, action, k), EMPTY);
}

function phases(ledger: Ledger): string[] {
  return (ledger.batches[0]?.entries ?? []).map((e) => `${e.vehicle} ${e.phase}${e.detail ? `: ${e.detail}` : ''}`);
}

describe('a command', () => {
  it('goes from sending over sent and executing to done, each vehicle for itself', () => {
    expect(phases(after(begin(1, [1, 2])))).toEqual(['1 sending', '2 sending']);
    expect(phases(after(begin(1, [1, 2]), taken(1, 9, [1, 2])))).toEqual(['1 sent', '2 sent']);
    const ledger = after(begin(1, [1, 2]), taken(1, 9, [1, 2]), progress(9, 1, EXECUTING), progress(9, 2, EXECUTING), progress(9, 1, DONE));
    expect(phases(ledger)).toEqual(['1 done', '2 executing']);
    expect(tally(ledger.batches[0]!)).toEqual(new Map([['done', 1], ['executing', 1]]));
  });

  it('says since when it is in its phase', () => {
    const ledger = after(begin(1, [1]), taken(1, 9, [1]), progress(9, 1, EXECUTING), progress(9, 1, EXECUTING), progress(9, 1, DONE));
    expect(ledger.batches[0]?.entries[0]?.since).toBe(4);
  });

  it('is refused by the receipt with the reason in words', () => {
    const ledger = after(begin(1, [1, 2]), {
      type: 'receipts',
      key: 1,
      receipts: [
        { vehicle: 1, id: 9, refusal: { reason: 'wrong_state', state: 'taking_off', command: 'arm' } },
        { vehicle: 2, id: 9, refusal: null },
      ],
    });
    expect(phases(ledger)).toEqual(['1 refused: cannot arm while taking off', '2 sent']);
  });

  it('is refused later by an event', () => {
    const refusal: CommandProgress = { progress: 'refused', refusal: { reason: 'autopilot', result: 'temporarily_rejected', text: 'GPS noise' } };
    expect(phases(after(begin(1, [1]), taken(1, 9, [1]), progress(9, 1, EXECUTING), progress(9, 1, refusal)))).toEqual([
      '1 refused: autopilot: temporarily rejected (GPS noise)',
    ]);
  });

  it('that a newer one replaced is not a refusal', () => {
    const replaced: CommandProgress = { progress: 'refused', refusal: { reason: 'superseded' } };
    const ledger = after(begin(1, [1]), taken(1, 9, [1]), progress(9, 1, replaced));
    expect(ledger.batches[0]?.entries[0]?.phase).toBe('replaced');
  });

  it('takes events that came before its receipt', () => {
    const ledger = after(begin(1, [1, 2]), progress(9, 1, EXECUTING), progress(9, 1, DONE), taken(1, 9, [1, 2]));
    expect(phases(ledger)).toEqual(['1 done', '2 sent']);
    expect(ledger.early).toEqual([]);
  });

  it('that is done stays done', () => {
    expect(phases(after(begin(1, [1]), taken(1, 9, [1]), progress(9, 1, DONE), progress(9, 1, EXECUTING)))).toEqual(['1 done']);
  });

  it('is not moved by the events of another one', () => {
    expect(phases(after(begin(1, [1]), taken(1, 9, [1]), progress(8, 1, DONE), progress(9, 2, DONE)))).toEqual(['1 sent']);
  });

  it('shows a vehicle that the page did not know of', () => {
    expect(phases(after(begin(1, [1]), taken(1, 9, [1, 2])))).toEqual(['1 sent', '2 sent']);
  });

  it('is not known where the receipt says nothing of a vehicle', () => {
    expect(phases(after(begin(1, [1, 2]), taken(1, 9, [1])))).toEqual(['1 sent', '2 unknown: no receipt']);
  });
});

describe('when the call fails', () => {
  it('an answer means refused, no answer means unknown', () => {
    expect(phases(after(begin(1, [1]), { type: 'failed', key: 1, vehicles: [1], certain: true, message: 'no such path' }))).toEqual(['1 refused: no such path']);
    expect(phases(after(begin(1, [1]), { type: 'failed', key: 1, vehicles: [1], certain: false, message: 'no answer' }))).toEqual(['1 unknown: no answer']);
  });

  it('a call that failed for one vehicle says nothing of the others', () => {
    const failed = after(begin(1, [1, 2]), { type: 'failed', key: 1, vehicles: [1], certain: true, message: 'no such path' });
    expect(phases(failed).map((phase) => phase.trim())).toEqual(['1 refused: no such path', expect.stringMatching(/^2 sending/)]);
  });
});

describe('when the connection is lost', () => {
  it('what was open is unknown, and an event that comes later still settles it', () => {
    const lost = after(begin(1, [1, 2]), taken(1, 9, [1, 2]), progress(9, 1, DONE), { type: 'connection_lost' });
    expect(phases(lost)).toEqual(['1 done', '2 unknown: connection lost']);
    expect(phases(reduce(lost, progress(9, 2, DONE), 9))).toEqual(['1 done', '2 done']);
  });

  it("after a restart of the server the new run's ids mean other commands", () => {
    const ledger = after(begin(1, [1]), taken(1, 9, [1]), { type: 'connection_lost' }, { type: 'server_restarted' }, progress(9, 1, DONE));
    expect(phases(ledger)).toEqual(['1 unknown: the server restarted']);
    // And its vehicles are others: nothing of this is told beside them.
    expect(ledger.batches.map(({ former }) => former)).toEqual([true]);
    expect(reduce(ledger, begin(2, [1]), 9).batches.map(({ former }) => former)).toEqual([false, true]);
  });
});

describe('what is still said', () => {
  const entry = (phase: Phase): Entry => ({ vehicle: 1, phase, id: 1, detail: '', since: 1000 });

  it('is what is under way, and what is over for as long as it takes to be read: longer what went wrong', () => {
    const said = (now: number) => (['sent', 'executing', 'done', 'replaced', 'refused', 'unknown'] as const).filter((phase) => stillSaid(entry(phase), now));
    expect(said(1000)).toHaveLength(6);
    expect(said(20_000)).toEqual(['sent', 'executing', 'refused', 'unknown']);
    expect(said(120_000)).toEqual(['sent', 'executing']);
  });
});

describe('the ledger', () => {
  it('is bounded', () => {
    let ledger = EMPTY;
    for (let key = 1; key <= KEPT_BATCHES + 5; key++) ledger = reduce(ledger, begin(key, [1]), key);
    expect(ledger.batches).toHaveLength(KEPT_BATCHES);
    expect(ledger.batches[0]?.key).toBe(KEPT_BATCHES + 5);
    for (let id = 0; id < 3000; id++) ledger = reduce(ledger, progress(id, 1, DONE), 0);
    expect(ledger.early.length).toBeLessThanOrEqual(1024);
  });

  it('finds the newest command of a vehicle', () => {
    const ledger = after(begin(1, [1, 2]), begin(2, [2]));
    expect(latestOf(ledger, 1)?.batch.key).toBe(1);
    expect(latestOf(ledger, 2)?.batch.key).toBe(2);
    expect(latestOf(ledger, 3)).toBeNull();
  });
});
