// The sound of alerts: off until somebody turns it on by hand, which is also what a browser asks for before it lets a page be heard. It
// says that something is new, not what; what it is stands on the screen. Must never be the only sign of anything.

import type { LogEntry } from './eventLog';
import { SEVERITY_RANK } from './eventLog';

/** How often a critical alert that nobody acknowledges is heard again. */
export const AGAIN_MS = 10_000;

export type Tone = 'warning' | 'critical';

/** Decides what is to be heard; keeps what it has seen. Pure but for that. */
export class SoundPlan {
  #heard = new Map<string, number>();
  #criticalAt = -Infinity;

  /** What is outstanding now is no news; a critical alert among it is still heard again until it is acknowledged. */
  settle(outstanding: readonly LogEntry[], nowMs: number): void {
    this.#heard = new Map(outstanding.map((entry) => [entry.key, entry.count]));
    this.#criticalAt = outstanding.some((entry) => entry.severity === 'critical') ? nowMs : -Infinity;
  }

  next(outstanding: readonly LogEntry[], nowMs: number): Tone | null {
    let worst = 0;
    for (const entry of outstanding) {
      const before = this.#heard.get(entry.key) ?? 0;
      if (entry.count > before) worst = Math.max(worst, SEVERITY_RANK[entry.severity]);
    }
    this.#heard = new Map(outstanding.map((entry) => [entry.key, entry.count]));
    const critical = outstanding.some((entry) => entry.severity === 'critical');
    if (!critical) this.#criticalAt = -Infinity;
    const again = critical && this.#criticalAt > -Infinity && nowMs - this.#criticalAt >= AGAIN_MS;
    if (worst >= SEVERITY_RANK.critical || again) {
      this.#criticalAt = nowMs;
      return 'critical';
    }
    return worst >= SEVERITY_RANK.warning ? 'warning' : null;
  }
}

/** Beeps: when from the beginning in seconds, how long, how high in hertz. */
const BEEPS: Record<Tone, readonly (readonly [number, number, number])[]> = {
  warning: [[0, 0.16, 660]],
  critical: [[0, 0.14, 990], [0.2, 0.14, 740], [0.4, 0.14, 990], [0.6, 0.14, 740]],
};

export class AlarmSound {
  on = $state(false);
  /** How many sounds were made since it was turned on. */
  played = $state(0);
  readonly #outstanding: () => readonly LogEntry[];
  readonly #plan = new SoundPlan();
  readonly #silent: () => boolean;
  #audio: AudioContext | null = null;

  /** `silent` says that nothing is to be heard, whatever happens: what is shown is over. */
  constructor(outstanding: () => readonly LogEntry[], silent: () => boolean = () => false) {
    this.#outstanding = outstanding;
    this.#silent = silent;
  }

  /** By a click or a key: the browser lets nothing else turn it on. */
  toggle(): void {
    this.on = !this.on;
    if (!this.on) return;
    this.#audio ??= new AudioContext();
    void this.#audio.resume();
    this.#plan.settle(this.#outstanding(), performance.now());
    // So that one knows how loud it is.
    this.#play('warning');
  }

  /** Called with every tick. */
  beat(nowMs: number): void {
    if (!this.on || this.#silent()) return;
    const tone = this.#plan.next(this.#outstanding(), nowMs);
    if (tone) this.#play(tone);
  }

  #play(tone: Tone): void {
    const audio = this.#audio;
    if (!audio) return;
    this.played++;
    for (const [from, length, hertz] of BEEPS[tone]) {
      const start = audio.currentTime + from;
      const gain = audio.createGain();
      gain.gain.setValueAtTime(0, start);
      gain.gain.linearRampToValueAtTime(0.25, start + 0.01);
      gain.gain.setValueAtTime(0.25, start + length - 0.03);
      gain.gain.linearRampToValueAtTime(0, start + length);
      const oscillator = audio.createOscillator();
      oscillator.type = 'triangle';
      oscillator.frequency.value = hertz;
      oscillator.connect(gain).connect(audio.destination);
      oscillator.start(start);
      oscillator.stop(start + length);
    }
  }
}
