// When pictures were shown and how long they were under way: rate, period, whether the picture is frozen, from glass to glass. Bounded, pure: the
// times come in, on the `performance.now()` clock.

/** As many as the longest window holds at 60 pictures a second. */
const KEPT = 240;
const RATE_WINDOW_MS = 3000;
const PERIOD_OF = 9;

const LEAST_FROZEN_MS = 500;
const FROZEN_PERIODS = 3;

/** Whether a picture that has been shown for so long is frozen. */
export function isFrozen(shownForMs: number, periodMs: number | null): boolean {
  return shownForMs > Math.max(LEAST_FROZEN_MS, FROZEN_PERIODS * (periodMs ?? 0));
}

export class PictureLog {
  /** Pictures shown in all. */
  shown = 0;
  #at: number[] = [];

  note(atMs: number): void {
    this.shown++;
    this.#at.push(atMs);
    if (this.#at.length > KEPT) this.#at.shift();
  }

  get lastMs(): number | null {
    return this.#at.at(-1) ?? null;
  }

  /** Pictures a second in the last seconds. */
  rateHz(nowMs: number): number {
    const from = nowMs - RATE_WINDOW_MS;
    const counted = this.#at.filter((at) => at > from);
    const first = counted[0];
    if (first === undefined) return 0;
    // At the beginning the window is not full yet: then between the pictures that there are.
    const whole = this.shown > counted.length;
    if (whole) return (counted.length * 1000) / RATE_WINDOW_MS;
    return counted.length < 2 ? 0 : ((counted.length - 1) * 1000) / Math.max(1, nowMs - first);
  }

  /** From one picture to the next, as it mostly is: a pause is none. */
  get periodMs(): number | null {
    const last = this.#at.slice(-PERIOD_OF);
    const gaps = last.slice(1).map((at, k) => at - (last[k] ?? at));
    return gaps.length === 0 ? null : middle(gaps);
  }

  frozen(nowMs: number): boolean {
    return this.lastMs !== null && isFrozen(nowMs - this.lastMs, this.periodMs);
  }
}

function middle(values: readonly number[]): number {
  return quantile([...values].sort((a, b) => a - b), 0.5);
}

/** The value that this share of the sorted ones is not above. */
function quantile(sorted: readonly number[], share: number): number {
  return sorted[Math.min(sorted.length - 1, Math.max(0, Math.ceil(sorted.length * share) - 1))] ?? NaN;
}

const DELAY_WINDOW_MS = 10_000;
const DELAYS_KEPT = 1200;
/** A clock that is farther off is no clock of this picture. */
const PLAUSIBLE_MS = 60_000;

export type Delays = { p50Ms: number; p99Ms: number };

/** From glass to glass, of the last ten seconds. */
export class DelayLog {
  #kept: { at: number; ms: number }[] = [];

  note(atMs: number, ms: number): void {
    if (Math.abs(ms) > PLAUSIBLE_MS) return;
    this.#kept.push({ at: atMs, ms });
    if (this.#kept.length > DELAYS_KEPT) this.#kept.shift();
  }

  /** On another way they are others. */
  clear(): void {
    this.#kept = [];
  }

  /** Those of the last ten seconds, oldest first. */
  list(nowMs: number): number[] {
    const from = this.#kept.findIndex(({ at }) => at > nowMs - DELAY_WINDOW_MS);
    this.#kept = from < 0 ? [] : this.#kept.slice(from);
    return this.#kept.map(({ ms }) => ms);
  }

  of(nowMs: number): Delays | null {
    const sorted = this.list(nowMs).sort((a, b) => a - b);
    return sorted.length === 0 ? null : { p50Ms: quantile(sorted, 0.5), p99Ms: quantile(sorted, 0.99) };
  }
}

const LOSS_WINDOW_MS = 10_000;

/** Share of what was lost, from two counters that only grow: what came and what did not. */
export class LossLog {
  #kept: { at: number; came: number; lost: number }[] = [];

  note(atMs: number, came: number, lost: number): void {
    const before = this.#kept.at(-1);
    // Counters that went back belong to another connection.
    if (before && (came < before.came || lost < before.lost)) this.#kept = [];
    this.#kept.push({ at: atMs, came, lost });
    while (this.#kept.length > 2 && (this.#kept[1]?.at ?? 0) <= atMs - LOSS_WINDOW_MS) this.#kept.shift();
  }

  clear(): void {
    this.#kept = [];
  }

  get share(): number {
    const [first, last] = [this.#kept[0], this.#kept.at(-1)];
    if (!first || !last) return 0;
    const [came, lost] = [last.came - first.came, last.lost - first.lost];
    return came + lost > 0 ? lost / (came + lost) : 0;
  }
}

/** Lost on one part of the way or on the other. */
export function together(one: number, other: number): number {
  return 1 - (1 - one) * (1 - other);
}
