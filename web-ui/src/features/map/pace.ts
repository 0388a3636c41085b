// When the next picture is due: at once for a hand, in steady steps while vehicles are under way. Draws nothing itself.

/** Between two pictures while something is under way. */
const STEP_MS = 50;
/** ... but giving the orders for pictures takes no more than this share of the time (to follow them takes a browser without a graphics card some
 *  three times as long again), ... */
const BUSY_SHARE = 1 / 32;
/** ... as long as they do not come more seldom than this. */
const LONGEST_STEP_MS = 62;
/** How much a new picture counts in what pictures take. */
const SMOOTHING = 0.2;

export class Pace {
  #request = 0;
  #timer = 0;
  #drawMs = 0;
  /** When the next of the steady pictures is due. */
  #dueMs = 0;
  #stopped = false;

  /** `draw` says whether something is under way, so that there will be another picture of it. */
  constructor(readonly draw: () => boolean) {}

  /** A picture with the next animation frame: for what a hand does. */
  soon = (): void => {
    if (this.#request === 0 && !this.#stopped) this.#request = requestAnimationFrame(this.now);
  };

  /** A picture for news that come by themselves: the next of the steady ones, if there are such, shows them too. */
  news = (): void => {
    if (this.#timer === 0) this.soon();
  };

  /** A picture before this returns. */
  now = (): void => {
    if (this.#stopped) return;
    this.#forget();
    const begun = performance.now();
    const underWay = this.draw();
    const ended = performance.now();
    this.#drawMs += (ended - begun - this.#drawMs) * SMOOTHING;
    if (!underWay) return;
    const step = stepMs(this.#drawMs);
    // Counted from when this one was due: screens draw in steps of their own, and counted from when it was drawn pictures would come too seldom.
    this.#dueMs = begun - this.#dueMs < step && begun >= this.#dueMs ? this.#dueMs + step : begun + step;
    this.#timer = window.setTimeout(this.#due, this.#dueMs - ended);
  };

  stop(): void {
    this.#forget();
    this.#stopped = true;
  }

  #due = (): void => {
    this.#timer = 0;
    this.soon();
  };

  #forget(): void {
    cancelAnimationFrame(this.#request);
    clearTimeout(this.#timer);
    this.#request = 0;
    this.#timer = 0;
  }
}

/** From the beginning of a picture to that of the next, if each takes `drawMs`. */
export function stepMs(drawMs: number): number {
  return Math.min(LONGEST_STEP_MS, Math.max(STEP_MS, drawMs / BUSY_SHARE));
}
