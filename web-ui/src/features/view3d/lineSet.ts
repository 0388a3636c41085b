// Many short lines in space as one array that is written anew for every picture and never shrinks: what both drawers draw. Pure.

/** Numbers of a line: north, east, up at both ends. */
export const LINE = 6;

/** The theme's colours that lines take. */
export type Ink = 'major' | 'axis' | 'label' | 'trail' | 'slot' | 'route' | 'fence' | 'accent' | 'advisory' | 'warning' | 'critical' | 'ready';

export class LineSet {
  /** Ends of `count` lines. */
  data = new Float32Array(64 * LINE);
  count = 0;

  constructor(
    readonly ink: Ink,
    readonly opacity: number,
  ) {}

  clear(): void {
    this.count = 0;
  }

  add(north0: number, east0: number, up0: number, north1: number, east1: number, up1: number): void {
    if ((this.count + 1) * LINE > this.data.length) {
      const larger = new Float32Array(this.data.length * 2);
      larger.set(this.data);
      this.data = larger;
    }
    const at = this.count++ * LINE;
    const d = this.data;
    d[at] = north0;
    d[at + 1] = east0;
    d[at + 2] = up0;
    d[at + 3] = north1;
    d[at + 4] = east1;
    d[at + 5] = up1;
  }

  /** A line in `parts` pieces of which each is drawn by this share: broken and dotted lines. */
  broken(from: readonly [number, number, number], to: readonly [number, number, number], parts: number, share: number): void {
    const along = (t: number, axis: 0 | 1 | 2) => from[axis] + (to[axis] - from[axis]) * t;
    for (let k = 0; k < parts; k++) {
      const [t0, t1] = [k / parts, (k + share) / parts];
      this.add(along(t0, 0), along(t0, 1), along(t0, 2), along(t1, 0), along(t1, 1), along(t1, 2));
    }
  }

  /** A level ring of so many corners. */
  ring(north: number, east: number, up: number, radius: number, corners: number): void {
    for (let k = 0; k < corners; k++) {
      const [a, b] = [(2 * Math.PI * k) / corners, (2 * Math.PI * (k + 1)) / corners];
      this.add(north + radius * Math.cos(a), east + radius * Math.sin(a), up, north + radius * Math.cos(b), east + radius * Math.sin(b), up);
    }
  }
}
