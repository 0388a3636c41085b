// The map's own projection: metres about the swarm's origin to pixels, north up. Pure arithmetic.

export type Bounds = { minNorth: number; maxNorth: number; minEast: number; maxEast: number };

/** Pixels per metre: from a country to a propeller. */
export const MIN_SCALE = 0.0005;
export const MAX_SCALE = 400;
/** A fit shows at least this much ground, so that one vehicle does not fill the map. */
const MIN_FIT_M = 30;

export class View {
  width = 1;
  height = 1;
  centerNorth = 0;
  centerEast = 0;
  scale = 8;

  x(east: number): number {
    return this.width / 2 + (east - this.centerEast) * this.scale;
  }

  y(north: number): number {
    return this.height / 2 - (north - this.centerNorth) * this.scale;
  }

  north(y: number): number {
    return this.centerNorth - (y - this.height / 2) / this.scale;
  }

  east(x: number): number {
    return this.centerEast + (x - this.width / 2) / this.scale;
  }

  /** Moves the ground by pixels, as a drag does. */
  panBy(dx: number, dy: number): void {
    this.centerEast -= dx / this.scale;
    this.centerNorth += dy / this.scale;
  }

  /** Zooms by a factor; the place under (x, y) stays there. */
  zoomAt(x: number, y: number, factor: number): void {
    const scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, this.scale * factor));
    const north = this.north(y);
    const east = this.east(x);
    this.scale = scale;
    this.centerEast = east - (x - this.width / 2) / scale;
    this.centerNorth = north + (y - this.height / 2) / scale;
  }

  /** Shows all of `bounds` with `padding` pixels around, left of `coveredRight` pixels that something lies over. */
  fit(bounds: Bounds, padding: number, coveredRight = 0): void {
    const high = Math.max(MIN_FIT_M, bounds.maxNorth - bounds.minNorth);
    const wide = Math.max(MIN_FIT_M, bounds.maxEast - bounds.minEast);
    const room = (size: number) => Math.max(size / 4, size - 2 * padding);
    const scale = Math.min(room(this.width - coveredRight) / wide, room(this.height) / high);
    this.scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, scale));
    this.centerNorth = (bounds.minNorth + bounds.maxNorth) / 2;
    this.centerEast = (bounds.minEast + bounds.maxEast) / 2 + coveredRight / 2 / this.scale;
  }

  /** Whether all of `bounds` lies at least `margin` pixels inside. */
  contains(bounds: Bounds, margin: number): boolean {
    return (
      this.x(bounds.minEast) >= margin &&
      this.x(bounds.maxEast) <= this.width - margin &&
      this.y(bounds.maxNorth) >= margin &&
      this.y(bounds.minNorth) <= this.height - margin
    );
  }
}

/** An empty box that any point enlarges. */
export function noBounds(): Bounds {
  return { minNorth: Infinity, maxNorth: -Infinity, minEast: Infinity, maxEast: -Infinity };
}

export function include(bounds: Bounds, north: number, east: number): void {
  if (north < bounds.minNorth) bounds.minNorth = north;
  if (north > bounds.maxNorth) bounds.maxNorth = north;
  if (east < bounds.minEast) bounds.minEast = east;
  if (east > bounds.maxEast) bounds.maxEast = east;
}

export function isEmpty(bounds: Bounds): boolean {
  return bounds.minNorth > bounds.maxNorth;
}
