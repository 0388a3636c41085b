// The life of every command at every vehicle: sending, sent, executing, done, refused, replaced, unknown. A pure reducer;
// the receipts of the REST call and the events of the stream may come in either order.

import type { CommandProgress, CommandReceipt, Refusal } from '../protocol/types';
import { t } from '../language/language.svelte';
import { refusalText } from '../protocol/words';

export type Phase = 'sending' | 'sent' | 'executing' | 'done' | 'refused' | 'replaced' | 'unknown';

export type Entry = {
  vehicle: number;
  phase: Phase;
  /** Id the server gave it; null until the receipt. */
  id: number | null;
  /** Why it was refused, or what is not known. */
  detail: string;
  /** By which rule it was refused, where the server has told. */
  refusedBy?: Refusal['reason'];
  /** When it came into this phase. */
  since: number;
};

/** One command as the operator gave it. */
export type Batch = {
  key: number;
  /** As on the button: "Take off". */
  label: string;
  /** Further words: "10 m". */
  detail: string;
  /** When it was given. */
  at: number;
  entries: readonly Entry[];
  /** Given to a former run of the server: to vehicles that are no more. */
  former: boolean;
};

type EarlyProgress = { id: number; vehicle: number; progress: CommandProgress };

export type Ledger = {
  /** Newest first, bounded. */
  batches: readonly Batch[];
  /** Progress of commands no receipt is here for yet, bounded. */
  early: readonly EarlyProgress[];
};

export type Action =
  | { type: 'begin'; key: number; label: string; detail: string; vehicles: readonly number[] }
  | { type: 'receipts'; key: number; receipts: readonly CommandReceipt[] }
  | { type: 'failed'; key: number; vehicles: readonly number[]; certain: boolean; message: string }
  | { type: 'progress'; id: number; vehicle: number; progress: CommandProgress }
  | { type: 'connection_lost' }
  | { type: 'server_restarted' };

export const EMPTY: Ledger = { batches: [], early: [] };
export const KEPT_BATCHES = 20;
const KEPT_EARLY = 1024;

export const OPEN_PHASES: readonly Phase[] = ['sending', 'sent', 'executing'];

/** The ledger after `action` at the moment `now`, on whatever clock the caller keeps to. */
export function reduce(ledger: Ledger, action: Action, now: number): Ledger {
  switch (action.type) {
    case 'begin': {
      const { key, label, detail } = action;
      const entries = action.vehicles.map((vehicle): Entry => ({ vehicle, phase: 'sending', id: null, detail: '', since: now }));
      return { ...ledger, batches: [{ key, label, detail, at: now, entries, former: false }, ...ledger.batches].slice(0, KEPT_BATCHES) };
    }
    case 'receipts':
      return takeReceipts(ledger, action.key, action.receipts, now);
    case 'failed':
      return mapBatch(ledger, action.key, (entry) =>
        entry.phase === 'sending' && action.vehicles.includes(entry.vehicle) ? enter(entry, action.certain ? 'refused' : 'unknown', action.message, now) : entry,
      );
    case 'progress':
      return takeProgress(ledger, action, now);
    case 'connection_lost':
      // Nothing is known of what is under way until events come again; a late "done" still settles it.
      return mapAll(ledger, (e) => (OPEN_PHASES.includes(e.phase) ? enter(e, 'unknown', t('connection lost'), now) : e));
    case 'server_restarted':
      // Ids begin anew: no later event may be taken for one of these.
      return {
        early: [],
        batches: mapAll(ledger, (e) => {
          const open = OPEN_PHASES.includes(e.phase) || e.phase === 'unknown';
          return { ...(open ? enter(e, 'unknown', t('the server restarted'), now) : e), id: null };
        }).batches.map((batch) => ({ ...batch, former: true })),
      };
  }
}

function enter(entry: Entry, phase: Phase, detail: string, now: number): Entry {
  return { ...entry, phase, detail, since: now };
}

function takeReceipts(ledger: Ledger, key: number, receipts: readonly CommandReceipt[], now: number): Ledger {
  const claimed = new Set<EarlyProgress>();
  const batches = ledger.batches.map((batch) => {
    if (batch.key !== key) return batch;
    const byVehicle = new Map(batch.entries.map((entry) => [entry.vehicle, entry]));
    for (const receipt of receipts) {
      let entry: Entry = { vehicle: receipt.vehicle, phase: 'sent', id: receipt.id, detail: '', since: now };
      if (receipt.refusal) entry = refused(entry, receipt.refusal, now);
      for (const early of ledger.early) {
        if (early.id !== receipt.id || early.vehicle !== receipt.vehicle) continue;
        claimed.add(early);
        entry = advance(entry, early.progress, now);
      }
      byVehicle.set(receipt.vehicle, entry);
    }
    const entries = [...byVehicle.values()].map((entry) =>
      entry.phase === 'sending' ? enter(entry, 'unknown', t('no receipt'), now) : entry,
    );
    return { ...batch, entries };
  });
  return { batches, early: ledger.early.filter((early) => !claimed.has(early)) };
}

function takeProgress(ledger: Ledger, action: EarlyProgress, now: number): Ledger {
  let found = false;
  const batches = ledger.batches.map((batch) => {
    if (!batch.entries.some((e) => e.id === action.id && e.vehicle === action.vehicle)) return batch;
    found = true;
    const entries = batch.entries.map((e) =>
      e.id === action.id && e.vehicle === action.vehicle ? advance(e, action.progress, now) : e,
    );
    return { ...batch, entries };
  });
  if (found) return { ...ledger, batches };
  const early = { id: action.id, vehicle: action.vehicle, progress: action.progress };
  return { ...ledger, early: [...ledger.early, early].slice(-KEPT_EARLY) };
}

function advance(entry: Entry, progress: CommandProgress, now: number): Entry {
  // A settled command stays settled: "executing" that comes late changes nothing.
  if (entry.phase === 'done' || entry.phase === 'refused' || entry.phase === 'replaced') return entry;
  switch (progress.progress) {
    case 'executing':
      return enter(entry, 'executing', '', now);
    case 'done':
      return enter(entry, 'done', '', now);
    case 'refused':
      return refused(entry, progress.refusal, now);
  }
}

function refused(entry: Entry, refusal: Refusal, now: number): Entry {
  const phase = refusal.reason === 'superseded' ? 'replaced' : 'refused';
  return { ...enter(entry, phase, refusalText(refusal), now), refusedBy: refusal.reason };
}

function mapBatch(ledger: Ledger, key: number, change: (entry: Entry) => Entry): Ledger {
  return { ...ledger, batches: ledger.batches.map((b) => (b.key === key ? { ...b, entries: b.entries.map(change) } : b)) };
}

function mapAll(ledger: Ledger, change: (entry: Entry) => Entry): Ledger {
  return { ...ledger, batches: ledger.batches.map((b) => ({ ...b, entries: b.entries.map(change) })) };
}

/** What went well is said for so long after it, what went wrong so long that it is seen; the list of commands keeps both. */
const WELL_SAID_MS = 15_000;
const WRONG_SAID_MS = 60_000;

/** Whether this is still to be said beside the vehicle and the commands: not what is over and was there to be read. */
export function stillSaid(entry: Entry, now: number): boolean {
  if (OPEN_PHASES.includes(entry.phase)) return true;
  const well = entry.phase === 'done' || entry.phase === 'replaced';
  return now - entry.since <= (well ? WELL_SAID_MS : WRONG_SAID_MS);
}

/** How many vehicles of a batch are in each phase. */
export function tally(batch: Batch): Map<Phase, number> {
  const counts = new Map<Phase, number>();
  for (const entry of batch.entries) counts.set(entry.phase, (counts.get(entry.phase) ?? 0) + 1);
  return counts;
}

/** The newest command of one vehicle. */
export function latestOf(ledger: Ledger, vehicle: number): { batch: Batch; entry: Entry } | null {
  for (const batch of ledger.batches) {
    const entry = batch.entries.find((e) => e.vehicle === vehicle);
    if (entry) return { batch, entry };
  }
  return null;
}
