// The event log as the page holds it: what the server says, and what this page itself noticed. What the server says is acknowledged there,
// for all pages; what the page noticed, here.

import { postAcknowledged } from '../protocol/rest';
import type { EventRecord, Severity } from '../protocol/types';
import { EMPTY_LOG, acknowledge, add, locked, outstanding, pass, restarted, take } from './eventLog';

export class Journal {
  log = $state.raw(EMPTY_LOG);
  outstanding = $derived(outstanding(this.log));
  #nextNotice = 1;

  /** Takes an event unless it was taken already. Tells whether it was new. */
  take(record: EventRecord, at: number, name = ''): boolean {
    if (record.seq <= this.log.lastSeq) return false;
    this.log = take(this.log, record, at, name);
    return true;
  }

  /** Something this page noticed itself. Gives the key of the entry that says it, which may be an older one that it repeats. */
  notice(severity: Severity, kind: string, text: string, vehicle: number | null = null): string {
    const key = `p${this.#nextNotice++}`;
    this.log = add(this.log, { key, vehicle, severity, kind, text, at: Date.now(), endsAt: null, seq: null });
    return this.log.entries[0]?.key ?? key;
  }

  /** The server began anew. */
  restart(): void {
    this.log = restarted(this.log, this.#nextNotice++);
  }

  /** What is shown is another moment: nothing that was said before is known there. */
  clear(): void {
    this.log = EMPTY_LOG;
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
    this.#acknowledge(this.outstanding.filter((entry) => entry.key === key));
  }

  acknowledgeAll(): void {
    this.#acknowledge(this.outstanding);
  }

  /** The server's are seen when it says so. */
  #acknowledge(entries: typeof this.outstanding): void {
    for (const entry of entries) {
      if (entry.numbers.length === 0) this.log = acknowledge(this.log, entry.key);
    }
    const numbers = entries.flatMap((entry) => entry.numbers);
    if (numbers.length === 0) return;
    postAcknowledged(numbers).catch((error: unknown) => {
      this.notice('warning', 'stream', `not acknowledged: ${error instanceof Error ? error.message : String(error)}`);
    });
  }
}
