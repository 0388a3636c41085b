// A recorded flight that is shown again: where it is, how fast it goes on, what happened in it, and going elsewhere in it. Without one all of it
// is as for a node that flies. Must never command anything else than what is shown.

import { t } from '../language/language.svelte';
import { changeReplay, getTimeline } from '../protocol/rest';
import type { ReplayChange, ReplayState, Timeline } from '../protocol/types';
import { markAfter, markBefore } from './timeline';

/** Recorded seconds in a second that are offered. */
export const RATES: readonly number[] = [0.25, 0.5, 1, 2, 5, 10, 20];
/** What a jump back or on is, in seconds. */
export const JUMP_S = 10;
/** The server's clock comes as 32 bits of milliseconds. */
const WRAP_MS = 2 ** 32;
/** Who goes to a mark goes just behind it: what it is about has happened then. */
const BEHIND_S = 0.05;
/** Where it is is told the page so often: the frames come more often than figures can be read. */
const TOLD_EVERY_MS = 90;
/** When nothing is heard of where it was sent, it is taken to be where it is heard to be. */
const GIVEN_UP_MS = 4000;
const ASK_AGAIN_MS = 1000;
const NOTHING: Timeline = { complete: false, marks: [], left_out: 0 };

/** How far into a recording a moment of the server's clock is, in seconds. */
export function positionOf(of: Pick<ReplayState, 'begin' | 'duration_s'>, serverTimeMs: number): number {
  // The server rounds down, and so does this: thirty seconds on are thirty seconds.
  const ms = (((serverTimeMs - Math.floor(of.begin / 1000)) % WRAP_MS) + WRAP_MS) % WRAP_MS;
  // What is before the beginning is the beginning.
  return ms > WRAP_MS / 2 ? 0 : Math.min(of.duration_s, ms / 1000);
}

/** The paces to choose from, with the one that it has. */
export function ratesWith(rate: number): number[] {
  return RATES.includes(rate) ? [...RATES] : [...RATES, rate].sort((a, b) => a - b);
}

/** What it asks of the server. */
export type Calls = { change: (change: ReplayChange) => Promise<unknown>; timeline: () => Promise<Timeline> };

export class Replay {
  /** Null where a node that flies is shown. */
  state = $state.raw<ReplayState | null>(null);
  timeline = $state.raw<Timeline>(NOTHING);
  /** Why it did not do what was asked. */
  problem = $state('');
  on = $derived(this.state !== null);
  /** Seconds of the flight that pass in a second. */
  pace = $derived(this.state === null ? 1 : this.state.playing ? this.state.rate : 0);
  #heardS = $state(0);
  #goingTo = $state<number | null>(null);
  /** How far into it what is shown is, in seconds, or what will be shown in a moment. */
  positionS = $derived(this.#goingTo ?? this.#heardS);

  #heardAt = -Infinity;
  #wanted: number | null = null;
  #sending = false;
  #arrived = false;
  #givenUp: ReturnType<typeof setTimeout> | undefined;
  #asking = false;

  constructor(readonly calls: Calls = { change: changeReplay, timeline: getTimeline }) {}

  /** Takes what the server says. Tells whether what was known is of another moment, or of another recording. */
  take(state: ReplayState): 'same' | 'moment' | 'recording' {
    const before = this.state;
    this.state = state;
    const other = before !== null && (before.file !== state.file || before.begin !== state.begin);
    if (other) this.timeline = NOTHING;
    if (before === null || other || before.jumps !== state.jumps) this.#heardS = state.position_s;
    if (state.indexed && !this.timeline.complete) void this.#askTimeline();
    if (other) return 'recording';
    return before === null || before.jumps === state.jumps ? 'same' : 'moment';
  }

  /** What is shown is no recording any more. */
  leave(): void {
    this.state = null;
    this.timeline = NOTHING;
    this.problem = '';
    this.#wanted = null;
    this.#settle();
  }

  /** A frame came; `arrived` says that it is the first one of the moment that was gone to. */
  heard(serverTimeMs: number, now: number, arrived: boolean): void {
    const { state } = this;
    if (state === null) return;
    if (arrived) {
      this.#arrived = true;
      if (!this.#sending) this.#settle();
    } else if (state.playing && now - this.#heardAt < TOLD_EVERY_MS) return;
    this.#heardAt = now;
    this.#heardS = positionOf(state, serverTimeMs);
  }

  /** Wall-clock ms of a moment on the clock of the node that was recorded, by that node's computer; null without a recording. */
  wallClockMs(nodeTimeUs: number): number | null {
    const { state } = this;
    return state && state.begun_unix_s * 1000 + (nodeTimeUs - state.begin) / 1000;
  }

  /** The same of the moment that is shown. */
  wallNowMs(): number | null {
    return this.state && (this.state.begun_unix_s + this.#heardS) * 1000;
  }

  /** The time of day of a moment of the recording. */
  timeOfDay(positionS: number): Date {
    return new Date(((this.state?.begun_unix_s ?? 0) + positionS) * 1000);
  }

  toggle(): void {
    if (this.state) void this.#change({ playing: !this.state.playing });
  }

  setRate(rate: number): void {
    void this.#change({ rate });
  }

  /** Goes on or back by so many seconds, from where it is or will be in a moment. */
  step(seconds: number): void {
    this.seek(this.positionS + seconds);
  }

  toMark(direction: 1 | -1): void {
    const { marks } = this.timeline;
    // A second of the screen is what it takes to press again.
    const mark = direction > 0 ? markAfter(marks, this.positionS) : markBefore(marks, this.positionS, this.pace);
    if (mark) this.seek(mark.position_s + BEHIND_S);
    else if (direction < 0) this.seek(0);
  }

  seekMark(positionS: number): void {
    this.seek(positionS + BEHIND_S);
  }

  /** Goes to a moment. Of several that are asked for quickly only the last is gone to. */
  seek(positionS: number): void {
    if (!this.state) return;
    this.#wanted = Math.min(this.state.duration_s, Math.max(0, positionS));
    this.#goingTo = this.#wanted;
    if (!this.#sending) void this.#go();
  }

  async #go(): Promise<void> {
    this.#sending = true;
    clearTimeout(this.#givenUp);
    let went = false;
    while (this.#wanted !== null) {
      const position_s = this.#wanted;
      this.#wanted = null;
      this.#arrived = false;
      went = await this.#change({ position_s });
    }
    this.#sending = false;
    // The stream may have been quicker than the answer.
    if (!went || this.#arrived) this.#settle();
    else this.#givenUp = setTimeout(() => this.#settle(), GIVEN_UP_MS);
  }

  #settle(): void {
    clearTimeout(this.#givenUp);
    this.#goingTo = null;
  }

  async #change(change: ReplayChange): Promise<boolean> {
    try {
      await this.calls.change(change);
      this.problem = '';
      return true;
    } catch (error) {
      this.problem = t('the replay did not obey: {why}', { why: error instanceof Error ? error.message : String(error) });
      return false;
    }
  }

  async #askTimeline(): Promise<void> {
    if (this.#asking) return;
    this.#asking = true;
    while (this.state !== null && !this.timeline.complete) {
      const { file } = this.state;
      try {
        const timeline = await this.calls.timeline();
        if (this.state?.file === file) this.timeline = timeline;
      } catch {
        // asked for again
      }
      if (!this.timeline.complete) await new Promise((resolve) => setTimeout(resolve, ASK_AGAIN_MS));
    }
    this.#asking = false;
  }
}
