// What charts are drawn from: a bounded past of a few figures of every vehicle, twice a second. A figure that is not known, or is of a
// vehicle that is not heard, is NaN: a gap in the line, never its last value carried on. No framework.

import type { Fleet } from '../telemetry/fleet';
import { FLAG } from '../protocol/frame';

export const SERIES = ['height', 'speed', 'battery', 'error', 'loss', 'roundTrip'] as const;
export type Series = (typeof SERIES)[number];

export const SAMPLE_MS = 500;
/** Three minutes. */
export const KEPT = 360;
/** Older data than this is no sample. */
const HEARD_WITHIN_MS = 2000;

export class History {
  /** Seconds, as a ring. */
  readonly #times = new Float64Array(KEPT);
  readonly #values = new Map<number, Float32Array>();
  #next = 0;
  #count = 0;
  #lastMs = -Infinity;

  /** Takes a sample if it is time for one. `heightOf` gives the height above the launch place by index; `pageMs` is the time on the page's clock, where that
      is not the one that samples go by. */
  take(fleet: Fleet, heightOf: (index: number) => number, nowMs: number, pageMs = nowMs): void {
    if (nowMs - this.#lastMs < SAMPLE_MS) return;
    this.#lastMs = nowMs;
    const at = this.#next;
    this.#times[at] = nowMs / 1000;
    for (const values of this.#values.values()) values.fill(NaN, at * SERIES.length, (at + 1) * SERIES.length);
    for (let i = 0; i < fleet.size; i++) {
      if (fleet.present[i] !== 1 || fleet.ageMs(i, pageMs) > HEARD_WITHIN_MS) continue;
      const values = this.#of(fleet.ids[i] ?? 0);
      values.set(sample(fleet, i, heightOf(i)), at * SERIES.length);
    }
    this.#next = (at + 1) % KEPT;
    this.#count = Math.min(KEPT, this.#count + 1);
  }

  /** Times in seconds before `nowMs`, oldest first, and the wanted figures; null where there is none. */
  of(id: number, wanted: readonly Series[], nowMs: number): [number[], ...(number | null)[][]] {
    const values = this.#values.get(id);
    const times: number[] = [];
    const lines: (number | null)[][] = wanted.map(() => []);
    for (let k = 0; k < this.#count; k++) {
      const at = (this.#next - this.#count + k + KEPT) % KEPT;
      times.push((this.#times[at] ?? 0) - nowMs / 1000);
      wanted.forEach((series, line) => {
        const value = values?.[at * SERIES.length + SERIES.indexOf(series)] ?? NaN;
        lines[line]?.push(Number.isNaN(value) ? null : value);
      });
    }
    return [times, ...lines];
  }

  /** The server began anew. */
  clear(): void {
    this.#values.clear();
    this.#count = this.#next = 0;
    this.#lastMs = -Infinity;
  }

  #of(id: number): Float32Array {
    let values = this.#values.get(id);
    if (!values) {
      values = new Float32Array(KEPT * SERIES.length).fill(NaN);
      this.#values.set(id, values);
    }
    return values;
  }
}

function sample(fleet: Fleet, i: number, heightM: number): number[] {
  const positioned = fleet.has(i, FLAG.position);
  const speed = Math.hypot(fleet.velocityNorth[i] ?? 0, fleet.velocityEast[i] ?? 0, fleet.velocityDown[i] ?? 0);
  return [
    positioned ? heightM : NaN,
    positioned ? speed : NaN,
    fleet.batteryPercent[i] ?? NaN,
    fleet.trackingErrorM[i] ?? NaN,
    fleet.lossPercent[i] ?? NaN,
    fleet.roundTripMs[i] ?? NaN,
  ];
}
