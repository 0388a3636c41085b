// Geometry of the drawing board of a free shape: metres forward and right of the first place to points of the board and back, what of it is
// shown, its grid, and what changes when a place is put, moved or taken away. Pure. Must never judge whether a shape can be flown.

import { ruleStepUp } from '../../language/units.svelte';
import type { OffsetFrd } from '../../protocol/types';

export type Size = { widthPx: number; heightPx: number };
export type Point = { xPx: number; yPx: number };
/** What of the ground the board shows: what is in its middle, and how large. */
export type View = { forwardM: number; rightM: number; mPerPx: number };
export type Ground = { forwardM: number; rightM: number };

/** To what a dragged place snaps, what an arrow key moves one by, and what it does with Shift. */
export const SNAP_M = 0.5;
export const FINE_M = 0.1;
/** Farther out nothing is drawn by hand; more is typed. */
export const FARTHEST_M = 1000;
/** Two places nearer than this are marked. What is too near is the server's to say. */
export const NEAR_M = 1;
/** More places than one node flies vehicles are kept, but neither drawn nor compared with each other. */
export const MOST_DRAWN = 250;

const LEAST_SHOWN_M = 20;
const EDGE_PX = 26;
/** A view that shows so many times more than need be is drawn closer. */
const LOOSEST = 4;
const LEAST_GRID_PX = 28;

/** Places are kept to the millimetre: what the eye and the fields show is what is written. */
export function toMm(metres: number): number {
  return Math.round(metres * 1000) / 1000 + 0;
}

export function snapped(metres: number, stepM = SNAP_M): number {
  const bounded = Math.min(FARTHEST_M, Math.max(-FARTHEST_M, metres));
  return toMm(Math.round(bounded / stepM) * stepM);
}

export function toBoard(view: View, size: Size, at: Ground): Point {
  return { xPx: size.widthPx / 2 + (at.rightM - view.rightM) / view.mPerPx, yPx: size.heightPx / 2 - (at.forwardM - view.forwardM) / view.mPerPx };
}

export function toGround(view: View, size: Size, at: Point): Ground {
  return { forwardM: view.forwardM + (size.heightPx / 2 - at.yPx) * view.mPerPx, rightM: view.rightM + (at.xPx - size.widthPx / 2) * view.mPerPx };
}

export const groundOf = (offset: OffsetFrd): Ground => ({ forwardM: offset.forward_m, rightM: offset.right_m });

/** The view that shows every place and the origin with room around them. One that shows them already stays, so that the board does not
 *  move under the hand with each place. */
export function fitted(places: readonly OffsetFrd[], size: Size, before: View | null = null): View {
  const forward = [0, ...places.map((place) => place.forward_m)];
  const right = [0, ...places.map((place) => place.right_m)];
  const [bottom, top, left, farRight] = [least(forward), most(forward), least(right), most(right)];
  const room = 1 + 0.4;
  const inner = { widthPx: Math.max(1, size.widthPx - 2 * EDGE_PX), heightPx: Math.max(1, size.heightPx - 2 * EDGE_PX) };
  const mPerPx = Math.max(
    ((top - bottom) * room) / inner.heightPx,
    ((farRight - left) * room) / inner.widthPx,
    LEAST_SHOWN_M / Math.min(inner.widthPx, inner.heightPx),
  );
  if (before && before.mPerPx <= mPerPx * LOOSEST && holds(before, size, [bottom, top], [left, farRight])) return before;
  return { forwardM: (top + bottom) / 2, rightM: (farRight + left) / 2, mPerPx };
}

function holds(view: View, size: Size, forward: readonly number[], right: readonly number[]): boolean {
  const halfHeightM = (size.heightPx / 2 - EDGE_PX) * view.mPerPx;
  const halfWidthM = (size.widthPx / 2 - EDGE_PX) * view.mPerPx;
  return forward.every((m) => Math.abs(m - view.forwardM) <= halfHeightM) && right.every((m) => Math.abs(m - view.rightM) <= halfWidthM);
}

const least = (values: readonly number[]): number => values.reduce((a, b) => Math.min(a, b));
const most = (values: readonly number[]): number => values.reduce((a, b) => Math.max(a, b));

export type Grid = { stepM: number; xPx: number[]; yPx: number[] };

/** Lines of the grid at round figures of the units of the page. */
export function gridOf(view: View, size: Size): Grid {
  const stepM = ruleStepUp(LEAST_GRID_PX * view.mPerPx);
  const topLeft = toGround(view, size, { xPx: 0, yPx: 0 });
  const bottomRight = toGround(view, size, { xPx: size.widthPx, yPx: size.heightPx });
  const multiples = (from: number, to: number): number[] => {
    const first = Math.ceil(from / stepM);
    return Array.from({ length: Math.max(0, Math.floor(to / stepM) - first + 1) }, (_, k) => (first + k) * stepM);
  };
  return {
    stepM,
    xPx: multiples(topLeft.rightM, bottomRight.rightM).map((rightM) => toBoard(view, size, { forwardM: 0, rightM }).xPx),
    yPx: multiples(bottomRight.forwardM, topLeft.forwardM).map((forwardM) => toBoard(view, size, { forwardM, rightM: 0 }).yPx),
  };
}

/** The place that is nearest to a point of the board and within reach of a finger, or null. */
export function placeAt(points: readonly Point[], at: Point, reachPx: number): number | null {
  let best: number | null = null;
  let bestPx = reachPx;
  for (const [k, point] of points.entries()) {
    const offPx = Math.hypot(point.xPx - at.xPx, point.yPx - at.yPx);
    if (offPx <= bestPx) [best, bestPx] = [k, offPx];
  }
  return best;
}

/** Which places have another one nearer than `NEAR_M`. */
export function nearOnes(places: readonly OffsetFrd[]): Set<number> {
  const near = new Set<number>();
  for (const [k, a] of places.entries()) {
    for (let m = 0; m < k; m++) if (apartM(a, places[m]!) < NEAR_M) near.add(k).add(m);
  }
  return near;
}

function apartM(a: OffsetFrd, b: OffsetFrd): number {
  return Math.hypot(a.forward_m - b.forward_m, a.right_m - b.right_m, a.down_m - b.down_m);
}

export function placeAdded(places: readonly OffsetFrd[], at: Ground): OffsetFrd[] {
  return [...places, { forward_m: snapped(at.forwardM), right_m: snapped(at.rightM), down_m: 0 }];
}

/** With other figures for one place; the first one is where all others are measured from and stays. */
export function placeSet(places: readonly OffsetFrd[], which: number, to: Partial<OffsetFrd>): OffsetFrd[] {
  return places.map((place, k) => (k === which && k > 0 ? { ...place, ...to } : place));
}

export function placeRemoved(places: readonly OffsetFrd[], which: number): OffsetFrd[] {
  return places.filter((_, k) => k !== which || k === 0);
}

/** A free spot behind the last place, for who cannot point at one. */
export function freeSpot(places: readonly OffsetFrd[], apart: number): Ground {
  const last = places.at(-1) ?? { forward_m: 0, right_m: 0, down_m: 0 };
  let spot: OffsetFrd = { ...last, down_m: 0 };
  const compared = places.slice(0, MOST_DRAWN);
  do spot = { ...spot, forward_m: snapped(spot.forward_m - Math.max(SNAP_M, apart)) };
  while (spot.forward_m > -FARTHEST_M && compared.some((place) => apartM(place, spot) < NEAR_M));
  return groundOf(spot);
}
