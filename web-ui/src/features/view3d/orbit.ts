// The camera of the view in space: it goes about a place and looks at it. Pure arithmetic; metres about the swarm's origin, up positive.

export type Spot3 = { north: number; east: number; up: number };
export type Box3 = { minNorth: number; maxNorth: number; minEast: number; maxEast: number; maxUp: number };

/** From top to bottom of the picture. */
export const FIELD_RAD = (45 * Math.PI) / 180;
const LOWEST_RAD = (3 * Math.PI) / 180;
const HIGHEST_RAD = (88 * Math.PI) / 180;
export const NEAREST_M = 4;
export const FARTHEST_M = 60_000;
/** A fit shows at least this much, so that one vehicle does not fill the picture. */
const LEAST_RADIUS_M = 14;
const MARGIN = 1.15;
/** What is nearer to the camera than this is behind it. */
const NEAR_M = 0.5;

export class Orbit {
  width = 1;
  height = 1;
  /** Where the camera looks. */
  north = 0;
  east = 0;
  up = 0;
  distanceM = 80;
  /** The direction it looks in, clockwise from north, and how far down. */
  bearingRad = (-25 * Math.PI) / 180;
  downRad = (28 * Math.PI) / 180;

  eye(): Spot3 {
    const flat = this.distanceM * Math.cos(this.downRad);
    return {
      north: this.north - flat * Math.cos(this.bearingRad),
      east: this.east - flat * Math.sin(this.bearingRad),
      up: this.up + this.distanceM * Math.sin(this.downRad),
    };
  }

  /** Goes around the place it looks at. */
  turn(bearingRad: number, downRad: number): void {
    this.bearingRad = (this.bearingRad + bearingRad) % (2 * Math.PI);
    this.downRad = clamp(this.downRad + downRad, LOWEST_RAD, HIGHEST_RAD);
  }

  zoom(factor: number): void {
    this.distanceM = clamp(this.distanceM / factor, NEAREST_M, FARTHEST_M);
  }

  /** Moves what it looks at over the ground, as a drag by so many pixels does. */
  panBy(dx: number, dy: number): void {
    const scale = this.metresPerPixel(this.distanceM);
    const right = -dx * scale;
    // Seen at a slant, a pixel upwards is more ground; not without end.
    const ahead = (dy * scale) / Math.max(0.3, Math.sin(this.downRad));
    const [cos, sin] = [Math.cos(this.bearingRad), Math.sin(this.bearingRad)];
    this.north += ahead * cos - right * sin;
    this.east += ahead * sin + right * cos;
  }

  /** Looks at the middle of a box from where all of it is in the picture. */
  fit(box: Box3): void {
    this.lookAt((box.minNorth + box.maxNorth) / 2, (box.minEast + box.maxEast) / 2, box.maxUp / 2);
    this.distanceM = clamp(this.#distanceFor(box), NEAREST_M, FARTHEST_M);
  }

  /** Whether the picture has to be fitted anew: the box is out of its middle, too large, or much too small for it. */
  isOff(box: Box3): boolean {
    const aside = Math.hypot((box.minNorth + box.maxNorth) / 2 - this.north, (box.minEast + box.maxEast) / 2 - this.east);
    const wanted = this.#distanceFor(box);
    return aside > this.distanceM * 0.12 || wanted > this.distanceM * 1.08 || wanted < this.distanceM * 0.55;
  }

  lookAt(north: number, east: number, up: number): void {
    this.north = north;
    this.east = east;
    this.up = up;
  }

  metresPerPixel(distanceM: number): number {
    return (2 * distanceM * Math.tan(FIELD_RAD / 2)) / this.height;
  }

  /** Where a place is in the picture, and how far ahead of the camera; `x` is NaN for what is behind it. */
  project(north: number, east: number, up: number, out: { x: number; y: number; depth: number }): void {
    const eye = this.eye();
    this.projectFrom(eye, north, east, up, out);
  }

  /** As `project`, for many places with the eye worked out once. */
  projectFrom(eye: Spot3, north: number, east: number, up: number, out: { x: number; y: number; depth: number }): void {
    const [cosB, sinB] = [Math.cos(this.bearingRad), Math.sin(this.bearingRad)];
    const [cosD, sinD] = [Math.cos(this.downRad), Math.sin(this.downRad)];
    const [n, e, u] = [north - eye.north, east - eye.east, up - eye.up];
    const ahead = n * cosB + e * sinB;
    out.depth = ahead * cosD - u * sinD;
    if (out.depth < NEAR_M) {
      out.x = out.y = NaN;
      return;
    }
    const scale = this.height / (2 * Math.tan(FIELD_RAD / 2)) / out.depth;
    out.x = this.width / 2 + (e * cosB - n * sinB) * scale;
    out.y = this.height / 2 - (u * cosD + ahead * sinD) * scale;
  }

  #distanceFor(box: Box3): number {
    const flat = Math.hypot(box.maxNorth - box.minNorth, box.maxEast - box.minEast) / 2;
    const radius = Math.max(LEAST_RADIUS_M, Math.hypot(flat, box.maxUp / 2));
    const narrow = Math.min(1, this.width / this.height);
    return (radius * MARGIN) / Math.tan(FIELD_RAD / 2) / narrow;
  }
}

function clamp(value: number, least: number, most: number): number {
  return Math.min(most, Math.max(least, value));
}
