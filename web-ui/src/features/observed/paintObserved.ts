// What cameras see of the ground, on the canvas. What is old looks old: its outline is broken, and it goes.

import type { CameraViewList } from '../../protocol/types';
import { LOST_FROM_MS, STALE_FROM_MS } from '../../telemetry/staleness';
import type { Palette } from '../map/palette';
import type { View } from '../map/view';
import { footprint } from './footprint';
import type { Footprint } from './footprint';

export type SeenGround = Footprint & { vehicle: number; payload: string; from: { north: number; east: number; upM: number }; stale: boolean };

/** The ground that each camera sees, as far as it is known well enough to be drawn. */
export function seenGround(list: CameraViewList, sinceAnswerMs: number): SeenGround[] {
  return list.views.flatMap(({ vehicle, payload, pose, width_px, height_px, age_s }) => {
    const ageMs = age_s * 1000 + sinceAnswerMs;
    const seen = ageMs < LOST_FROM_MS ? footprint(pose, width_px, height_px) : null;
    if (!seen || seen.corners.length === 0) return [];
    const from = { north: pose.position.north_m, east: pose.position.east_m, upM: -pose.position.down_m };
    return [{ ...seen, vehicle, payload, from, stale: ageMs >= STALE_FROM_MS }];
  });
}

export function paintGroundSeen(ctx: CanvasRenderingContext2D, view: View, palette: Palette, seen: readonly SeenGround[], selected: ReadonlySet<number>): void {
  ctx.save();
  ctx.strokeStyle = palette.accent;
  ctx.fillStyle = palette.accent;
  for (const { corners, cut, from, vehicle, stale } of seen) {
    const xs = corners.map((corner) => view.x(corner.east));
    const ys = corners.map((corner) => view.y(corner.north));
    ctx.beginPath();
    corners.forEach((_, k) => ctx.lineTo(xs[k] ?? 0, ys[k] ?? 0));
    ctx.closePath();
    ctx.globalAlpha = stale ? 0.04 : 0.1;
    ctx.fill();
    ctx.globalAlpha = selected.has(vehicle) ? 1 : 0.65;
    ctx.lineWidth = selected.has(vehicle) ? 2 : 1.2;
    ctx.setLineDash(stale ? [2, 5] : []);
    ctx.beginPath();
    corners.forEach((_, k) => {
      // Beyond a side that is cut the camera sees on: no line there.
      if (cut[k]) return;
      const next = (k + 1) % corners.length;
      ctx.moveTo(xs[k] ?? 0, ys[k] ?? 0);
      ctx.lineTo(xs[next] ?? 0, ys[next] ?? 0);
    });
    ctx.stroke();
    // Whose it is: a thin line from the vehicle to the nearest of what it sees.
    const [x, y] = [view.x(from.east), view.y(from.north)];
    const near = xs.reduce((best, _, k) => (away(xs, ys, k, x, y) < away(xs, ys, best, x, y) ? k : best), 0);
    ctx.globalAlpha *= 0.6;
    ctx.setLineDash([1, 4]);
    ctx.beginPath();
    ctx.moveTo(x, y);
    ctx.lineTo(xs[near] ?? x, ys[near] ?? y);
    ctx.stroke();
  }
  ctx.restore();
}

const away = (xs: readonly number[], ys: readonly number[], k: number, x: number, y: number): number => Math.hypot((xs[k] ?? 0) - x, (ys[k] ?? 0) - y);
