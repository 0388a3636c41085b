// The event log as the page holds it: what the server says, and what this page itself noticed.

import type { EventRecord, Severity } from '../protocol/types';
import { EMPTY_LOG, acknowledge, acknowledgeAll, add, happening, locked, outstanding, pass, restarted } from './eventLog';

/** Events older than this when the page opens are history: they want no acknowledgement. */
const HISTORY_MS = 60_000;

export class Journal {
  log = $state.raw(EMPTY_LOG);
  outstanding = $derived(outstanding(this.log));
  #nextNotice = 1;
  readonly #openedAt = Date.now();

  /** Takes an event unless it was taken already. Tells whether it was new. */
  take(record: EventRecord, at: number): boolean {
    if (record.seq <= this.log.lastSeq) return false;
    this.log = add(this.log, happening(record, at), record.seq);
    if (at < this.#openedAt - HISTORY_MS) this.log = acknowledge(this.log, `s${record.seq}`);
    return true;
  }

  /** Something this page noticed itself. Gives the key of the entry that says it, which may be an older one that it repeats. */
  notice(severity: Severity, kind: string, text: string, vehicle: number | null = null): string {
    const key = `p${this.#nextNotice++}`;
    this.log = add(this.log, { key, vehicle, severity, kind, text, at: Date.now(), endsAt: null });
    return this.log.entries[0]?.key ?? key;
  }

  /** The server began anew. */
  restart(): void {
    this.log = restarted(this.log, this.#nextNotice++);
  }

  /** What is over by itself wants nobody's look any more. */
  pass(now: number): void {
    this.log = pass(this.log, now);
  }

  /** The emergency stop, unlocked until `at` by this page, is locked again. */
  emergencyLocked(at: number): void {
    this.log = locked(this.log, at);
  }

  acknowledge(key: string): void {
    this.log = acknowledge(this.log, key);
  }

  acknowledgeAll(): void {
    this.log = acknowledgeAll(this.log);
  }
}
