// A route being put together: points set on the map or typed, height, speed, corners. The same for the leader's route and for the
// path of a formation that has no leader. Must never send anything.

import type { Route } from '../protocol/types';

export type Waypoint = { north: number; east: number };

/** Height where none is known to begin with. */
const HEIGHT_M = 10;

export class RouteDraft {
  waypoints = $state.raw<readonly Waypoint[]>([]);
  heightM = $state<number | null>(null);
  speedM_s = $state(5);
  cornerRadiusM = $state(8);
  /** Along the points, in metres. */
  lengthM = $derived(
    this.waypoints.reduce((sum, w, k) => {
      const before = this.waypoints[k - 1];
      return before ? sum + Math.hypot(w.north - before.north, w.east - before.east) : sum;
    }, 0),
  );
  readonly #startHeightM: () => number | null;

  /** `startHeightM` gives the height a new route begins with. */
  constructor(startHeightM: () => number | null) {
    this.#startHeightM = startHeightM;
  }

  get heightOrStartM(): number {
    return this.heightM ?? this.#startHeightM() ?? HEIGHT_M;
  }

  add(waypoint: Waypoint): void {
    this.waypoints = [...this.waypoints, waypoint];
    this.heightM ??= this.#startHeightM();
  }

  /** A point ten metres on, to be given its place by numbers. */
  addTyped(): void {
    const last = this.waypoints.at(-1);
    this.add(last ? { north: last.north + 10, east: last.east } : { north: 10, east: 0 });
  }

  move(at: number, to: Waypoint): void {
    this.waypoints = this.waypoints.map((w, k) => (k === at ? to : w));
  }

  remove(at: number): void {
    this.waypoints = this.waypoints.filter((_, k) => k !== at);
  }

  clear(): void {
    this.waypoints = [];
    this.heightM = null;
  }

  route(): Route {
    const down_m = 0 - this.heightOrStartM;
    return {
      waypoints: this.waypoints.map((w) => ({ north_m: w.north, east_m: w.east, down_m })),
      speed_m_s: this.speedM_s,
      corner_radius_m: this.cornerRadiusM,
    };
  }
}
