// What the node's clock says, from a stream's own pings: the answer holds the node's time, and it was so about in the middle between asking and
// hearing. Of the last ten the quickest is right to half of the time that it took. Pure: the times come in.

const TRIPS_KEPT = 10;

type Trip = { tookMs: number; offsetMs: number };

export class NodeClock {
  #trips: Trip[] = [];
  #best: Trip | null = null;

  /** A ping was sent and answered, on the `performance.now()` clock; the node's time is in microseconds. */
  take(sentMs: number, heardMs: number, nodeUs: number): void {
    if (heardMs < sentMs || !Number.isFinite(nodeUs)) return;
    this.#trips.push({ tookMs: heardMs - sentMs, offsetMs: nodeUs / 1000 - (sentMs + heardMs) / 2 });
    if (this.#trips.length > TRIPS_KEPT) this.#trips.shift();
    this.#best = this.#trips.reduce((a, b) => (b.tookMs < a.tookMs ? b : a));
  }

  /** What the node's clock says at a moment of the page's, in ms; null as long as no ping was answered. */
  nodeMs(pageMs: number): number | null {
    return this.#best === null ? null : pageMs + this.#best.offsetMs;
  }

  /** How long the quickest way there and back took. */
  get tripMs(): number | null {
    return this.#best?.tookMs ?? null;
  }
}
