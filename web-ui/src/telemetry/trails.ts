// Where vehicles came from: one ring buffer of points per vehicle. Bounded; a point is added only after some metres of way.

/** Points kept per vehicle. */
export const TRAIL_POINTS = 256;
/** Way between two points in metres. */
export const TRAIL_STEP_M = 1;
/** Numbers of a point: north, east, altitude. */
const POINT = 3;

export class Trails {
  /** Vehicle `i` owns TRAIL_POINTS points from `i * TRAIL_POINTS`. */
  #points: Float32Array;
  #head: Uint16Array;
  #length: Uint16Array;

  constructor(capacity: number) {
    this.#points = new Float32Array(capacity * TRAIL_POINTS * POINT);
    this.#head = new Uint16Array(capacity);
    this.#length = new Uint16Array(capacity);
  }

  /** The same trails with room for more vehicles. */
  grow(capacity: number): void {
    const points = new Float32Array(capacity * TRAIL_POINTS * POINT);
    points.set(this.#points);
    const head = new Uint16Array(capacity);
    head.set(this.#head);
    const length = new Uint16Array(capacity);
    length.set(this.#length);
    this.#points = points;
    this.#head = head;
    this.#length = length;
  }

  /** Adds a place if the vehicle went far enough since the last one, up and down included. */
  push(index: number, north: number, east: number, altitude: number): void {
    const length = this.#length[index] ?? 0;
    const head = this.#head[index] ?? 0;
    const base = index * TRAIL_POINTS;
    if (length > 0) {
      const last = (base + ((head + TRAIL_POINTS - 1) % TRAIL_POINTS)) * POINT;
      const dn = north - (this.#points[last] ?? 0);
      const de = east - (this.#points[last + 1] ?? 0);
      const du = altitude - (this.#points[last + 2] ?? 0);
      if (dn * dn + de * de + du * du < TRAIL_STEP_M * TRAIL_STEP_M) return;
    }
    const at = (base + head) * POINT;
    this.#points[at] = north;
    this.#points[at + 1] = east;
    this.#points[at + 2] = altitude;
    this.#head[index] = (head + 1) % TRAIL_POINTS;
    if (length < TRAIL_POINTS) this.#length[index] = length + 1;
  }

  length(index: number): number {
    return this.#length[index] ?? 0;
  }

  /** Calls `visit` for every `stride`-th point from number `from` (0 is the oldest) to before number `to`; the newest of them is never left out. */
  visit(index: number, from: number, to: number, stride: number, visit: (north: number, east: number, altitude: number) => void): void {
    const length = this.#length[index] ?? 0;
    const end = Math.min(to, length);
    const start = (this.#head[index] ?? 0) + TRAIL_POINTS - length;
    const base = index * TRAIL_POINTS;
    for (let k = Math.max(0, from); k < end; k = k === end - 1 ? end : Math.min(k + stride, end - 1)) {
      const at = (base + ((start + k) % TRAIL_POINTS)) * POINT;
      visit(this.#points[at] ?? 0, this.#points[at + 1] ?? 0, this.#points[at + 2] ?? 0);
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
