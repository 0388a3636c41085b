// Where vehicles came from: one ring buffer of points per vehicle. Bounded; a point is added only after some metres of way.

/** Points kept per vehicle. */
export const TRAIL_POINTS = 256;
/** Way between two points in metres. */
export const TRAIL_STEP_M = 1;

export class Trails {
  /** north, east pairs; vehicle `i` owns TRAIL_POINTS pairs from `i * TRAIL_POINTS`. */
  #points: Float32Array;
  #head: Uint16Array;
  #length: Uint16Array;

  constructor(capacity: number) {
    this.#points = new Float32Array(capacity * TRAIL_POINTS * 2);
    this.#head = new Uint16Array(capacity);
    this.#length = new Uint16Array(capacity);
  }

  /** The same trails with room for more vehicles. */
  grow(capacity: number): void {
    const points = new Float32Array(capacity * TRAIL_POINTS * 2);
    points.set(this.#points);
    const head = new Uint16Array(capacity);
    head.set(this.#head);
    const length = new Uint16Array(capacity);
    length.set(this.#length);
    this.#points = points;
    this.#head = head;
    this.#length = length;
  }

  /** Adds a place if the vehicle went far enough since the last one. */
  push(index: number, north: number, east: number): void {
    const length = this.#length[index] ?? 0;
    const head = this.#head[index] ?? 0;
    const base = index * TRAIL_POINTS;
    if (length > 0) {
      const last = (base + ((head + TRAIL_POINTS - 1) % TRAIL_POINTS)) * 2;
      const dn = north - (this.#points[last] ?? 0);
      const de = east - (this.#points[last + 1] ?? 0);
      if (dn * dn + de * de < TRAIL_STEP_M * TRAIL_STEP_M) return;
    }
    const at = (base + head) * 2;
    this.#points[at] = north;
    this.#points[at + 1] = east;
    this.#head[index] = (head + 1) % TRAIL_POINTS;
    if (length < TRAIL_POINTS) this.#length[index] = length + 1;
  }

  length(index: number): number {
    return this.#length[index] ?? 0;
  }

  /** Calls `visit(north, east, k)` from the oldest (k = 0) to the newest point. */
  forEach(index: number, visit: (north: number, east: number, k: number) => void): void {
    const length = this.#length[index] ?? 0;
    const start = ((this.#head[index] ?? 0) + TRAIL_POINTS - length) % TRAIL_POINTS;
    for (let k = 0; k < length; k++) {
      const at = (index * TRAIL_POINTS + ((start + k) % TRAIL_POINTS)) * 2;
      visit(this.#points[at] ?? 0, this.#points[at + 1] ?? 0, k);
    }
  }

  clear(): void {
    this.#head.fill(0);
    this.#length.fill(0);
  }

  clearOne(index: number): void {
    this.#head[index] = 0;
    this.#length[index] = 0;
  }
}
