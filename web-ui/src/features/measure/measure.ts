// Distances and bearings between places and vehicles. Pure arithmetic in the swarm's frame.

import { t } from '../../language/language.svelte';
import { lengthText, riseText } from '../../language/units.svelte';

/** A place on the ground, or a vehicle wherever it is by then. */
export type MeasurePoint = { kind: 'place'; north: number; east: number } | { kind: 'vehicle'; id: number };

/** Where a point is; `up` is not known for places on the ground. */
export type Spot = { north: number; east: number; up: number | null; words: string };

export type Leg = {
  from: Spot;
  to: Spot;
  distanceM: number;
  /** Clockwise from north, 0 to under 360; null where both are above each other. */
  bearingDeg: number | null;
  /** How much higher the second is; null if it is not known. */
  riseM: number | null;
};

/** Two places closer than this have no bearing. */
const NO_BEARING_M = 0.01;

export function leg(from: Spot, to: Spot): Leg {
  const north = to.north - from.north;
  const east = to.east - from.east;
  const distanceM = Math.hypot(north, east);
  const degrees = (Math.atan2(east, north) * 180) / Math.PI;
  return {
    from,
    to,
    distanceM,
    bearingDeg: distanceM < NO_BEARING_M ? null : (degrees + 360) % 360,
    riseM: from.up === null || to.up === null ? null : to.up - from.up,
  };
}

/** The legs from each spot to the next; points that are nowhere are left out. */
export function legs(points: readonly MeasurePoint[], locate: (id: number) => Spot | null): Leg[] {
  const spots = points
    .map((p) => (p.kind === 'vehicle' ? locate(p.id) : { north: p.north, east: p.east, up: null, words: 'place' }))
    .filter((spot) => spot !== null);
  return spots.slice(1).map((to, k) => leg(spots[k] ?? to, to));
}

export function totalM(all: readonly Leg[]): number {
  return all.reduce((sum, l) => sum + l.distanceM, 0);
}

export function bearingText(bearingDeg: number | null): string {
  if (bearingDeg === null) return '–';
  return `${(Math.round(bearingDeg) % 360).toString().padStart(3, '0')}°`;
}

export function legText(l: Leg): string {
  const rise = l.riseM === null ? '' : t(', {rise} up', { rise: riseText(l.riseM) });
  return `${lengthText(l.distanceM)}, ${bearingText(l.bearingDeg)}${rise}`;
}
