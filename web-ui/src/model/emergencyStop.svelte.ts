// The emergency stop, in its two steps: unlocking gives a key that is good for seconds, and only with it can motors be stopped.
// Must never take both steps at once, and never keep a key that was used or has run out.

import { ApiError, emergencyStop, unlockEmergencyStop } from '../protocol/rest';
import type { Targets } from '../protocol/types';
import { idRanges } from './idRanges';
import type { Journal } from './journal.svelte';
import { t } from '../language/language.svelte';

/** After unlocking nothing is stopped for so long: the second click of a double click is no second step. */
export const SETTLE_MS = 500;
const BEAT_MS = 100;

export type EmergencyOutcome = { bad: boolean; text: string } | null;

export class EmergencyStop {
  /** Whole seconds for which the key is still good; null while there is none. */
  leftS = $state<number | null>(null);
  /** The second step may be taken. */
  ready = $state(false);
  busy = $state(false);
  outcome = $state.raw<EmergencyOutcome>(null);

  readonly #journal: Journal;
  #key = '';
  /** Wall-clock ms by which what the server said of the unlocking has happened. */
  #unlockedBy = 0;
  #timer: ReturnType<typeof setInterval> | undefined;

  constructor(journal: Journal) {
    this.#journal = journal;
  }

  get unlocked(): boolean {
    return this.leftS !== null;
  }

  /** The first step. Stops nothing. */
  async unlock(): Promise<void> {
    if (this.busy || this.unlocked) return;
    this.busy = true;
    this.outcome = null;
    // The key's time counts from before the question: here it ends sooner than at the server, never later.
    const from = performance.now();
    try {
      const { key, valid_s } = await unlockEmergencyStop();
      this.#key = key;
      this.#unlockedBy = Date.now() + SETTLE_MS;
      const until = from + valid_s * 1000;
      const readyAt = performance.now() + SETTLE_MS;
      const beat = (): void => {
        const now = performance.now();
        if (now >= until) {
          this.lock();
          this.outcome = { bad: false, text: t('Time is over: emergency stop locked again') };
        } else {
          this.leftS = Math.ceil((until - now) / 1000);
          this.ready = now >= readyAt;
        }
      };
      beat();
      if (this.unlocked) this.#timer = setInterval(beat, BEAT_MS);
    } catch (error) {
      this.#fail(t('Emergency stop not unlocked'), error);
    } finally {
      this.busy = false;
    }
  }

  /** The second step: the motors of `targets` stop. */
  async stop(targets: Targets, vehicles: readonly number[]): Promise<void> {
    if (!this.ready || this.#key === '') return;
    const key = this.#key;
    this.lock();
    const who = targets === 'all' ? t('all {count}', { count: vehicles.length }) : idRanges([...vehicles]);
    try {
      const receipts = await emergencyStop(key, targets);
      const refused = receipts.filter((receipt) => receipt.refusal !== null);
      const failed = refused.length === 0 ? '' : t(', refused by {who}', { who: idRanges(refused.map((r) => r.vehicle)) });
      this.outcome = { bad: refused.length > 0, text: `${t('Emergency stop sent to {who}', { who })}${failed}` };
    } catch (error) {
      this.#fail(t('Emergency stop of {who} failed', { who }), error);
    }
  }

  /** Forgets the key. */
  lock(): void {
    clearInterval(this.#timer);
    if (this.#key !== '') this.#journal.emergencyLocked(this.#unlockedBy);
    this.#key = '';
    this.leftS = null;
    this.ready = false;
  }

  /** The server began anew: it knows neither the key nor whom anything was sent to. */
  restart(): void {
    this.lock();
    this.outcome = null;
  }

  #fail(what: string, error: unknown): void {
    const text = `${what}: ${error instanceof ApiError ? error.message : String(error)}`;
    this.outcome = { bad: true, text };
    this.#journal.notice('critical', 'emergency_stop', text);
  }
}
