// Whether somebody is before this page, for the dead-man's switch: a sign of life goes out while the page is seen and in use, where the
// node asks for one. Must never give one for a page that nobody touches.

import { operatorAlive } from '../protocol/rest';
import type { Session } from './session.svelte';

/** Somebody who has not touched the page for so long may not be there any more. */
export const IN_USE_MS = 60_000;
/** So long before that the page asks. */
export const ASK_MS = 20_000;
/** Signs of life come at least this often, and several times within the time after which vehicles react. */
const MOST_MS = 5_000;
const SHARE = 0.25;
const BEAT_MS = 1_000;
const TOUCHES = ['pointerdown', 'pointermove', 'keydown', 'wheel', 'touchstart'] as const;

/** How a sign of life stands with the time since the last touch. Pure. */
export function presence(sinceTouchMs: number, visible: boolean): 'here' | 'asked' | 'away' {
  if (!visible || sinceTouchMs > IN_USE_MS) return 'away';
  return sinceTouchMs > IN_USE_MS - ASK_MS ? 'asked' : 'here';
}

/** How long after a sign of life the next one is due. */
export function everyMs(warnsAfterS: number | null): number {
  return Math.min(MOST_MS, Math.max(BEAT_MS, (warnsAfterS ?? Infinity) * 1000 * SHARE));
}

export class Presence {
  /** What the page makes of who is before it. */
  is = $state<'here' | 'asked' | 'away'>('here');
  /** The last sign of life did not get through. */
  failed = $state(false);

  #touched = performance.now();
  #sent = -Infinity;
  #sending = false;

  constructor(readonly session: Session) {}

  start(): void {
    for (const touch of TOUCHES) addEventListener(touch, () => this.touch(), { passive: true, capture: true });
    document.addEventListener('visibilitychange', () => this.#beat());
    setInterval(() => this.#beat(), BEAT_MS);
  }

  /** Somebody is there. */
  touch(): void {
    this.#touched = performance.now();
    if (this.is !== 'here') this.#beat();
  }

  #beat(): void {
    const now = performance.now();
    this.is = presence(now - this.#touched, !document.hidden);
    const { state, warns_after_s } = this.session.info.dead_man;
    if (state === 'off' || this.is === 'away' || this.#sending || !this.session.canCommand) return;
    if (now - this.#sent >= everyMs(warns_after_s)) void this.#send(now);
  }

  async #send(now: number): Promise<void> {
    this.#sending = true;
    this.#sent = now;
    try {
      await operatorAlive();
      this.failed = false;
    } catch {
      this.failed = true;
    } finally {
      this.#sending = false;
    }
  }
}
