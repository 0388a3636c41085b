// Plans on the canvas: the route being flown, the route being drawn, and the slots a formation would have.

import type { Slot } from '../../model/formationWords';
import type { Waypoint } from '../../model/routeDraft.svelte';
import { FONT } from './paintGround';
import type { Palette } from './palette';
import type { View } from './view';
import { shown, unitName } from '../../language/units.svelte';

type Place = { north: number; east: number };

/** The route the leader flies, from where it is now. */
export function paintRoute(ctx: CanvasRenderingContext2D, view: View, palette: Palette, points: readonly Place[], finished: boolean): void {
  if (points.length === 0) return;
  ctx.save();
  ctx.globalAlpha = finished ? 0.35 : 0.8;
  ctx.strokeStyle = palette.route;
  ctx.fillStyle = palette.route;
  ctx.lineWidth = 2;
  ctx.beginPath();
  for (const p of points) ctx.lineTo(view.x(p.east), view.y(p.north));
  ctx.stroke();
  for (const p of points) {
    ctx.beginPath();
    ctx.arc(view.x(p.east), view.y(p.north), 3.5, 0, Math.PI * 2);
    ctx.fill();
  }
  const end = points[points.length - 1];
  if (end) {
    ctx.beginPath();
    ctx.arc(view.x(end.east), view.y(end.north), 8, 0, Math.PI * 2);
    ctx.stroke();
  }
  ctx.restore();
}

/** The route being drawn: numbered handles that can be dragged. */
export function paintDraftRoute(
  ctx: CanvasRenderingContext2D, view: View, palette: Palette, waypoints: readonly Waypoint[], from: Place | null,
): void {
  if (waypoints.length === 0) return;
  ctx.save();
  ctx.strokeStyle = palette.accentStrong;
  ctx.lineWidth = 2;
  ctx.setLineDash([7, 5]);
  ctx.beginPath();
  if (from) ctx.moveTo(view.x(from.east), view.y(from.north));
  for (const w of waypoints) ctx.lineTo(view.x(w.east), view.y(w.north));
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.textAlign = 'center';
  ctx.textBaseline = 'middle';
  ctx.font = `600 ${FONT}`;
  waypoints.forEach((w, k) => {
    ctx.beginPath();
    ctx.arc(view.x(w.east), view.y(w.north), 11, 0, Math.PI * 2);
    ctx.fillStyle = palette.bg;
    ctx.fill();
    ctx.stroke();
    ctx.fillStyle = palette.accentStrong;
    ctx.fillText(`${k + 1}`, view.x(w.east), view.y(w.north) + 0.5);
  });
  ctx.restore();
}

/** Index of the waypoint under a place on the screen, or -1. */
export function waypointAt(view: View, waypoints: readonly Waypoint[], x: number, y: number, reachPx: number): number {
  return waypoints.findLastIndex((w) => Math.hypot(view.x(w.east) - x, view.y(w.north) - y) <= reachPx);
}

/** Where the slots of the formation on the form would be; heights are said where they are not all the same. */
export function paintPreview(ctx: CanvasRenderingContext2D, view: View, palette: Palette, slots: readonly Slot[], led: boolean): void {
  const heights = slots.some((slot) => Math.abs(slot.upM - (slots[0]?.upM ?? 0)) > 0.25);
  ctx.save();
  ctx.strokeStyle = palette.accent;
  ctx.lineWidth = 1.6;
  ctx.setLineDash([4, 3]);
  const stacks = new Map<string, { x: number; y: number; ups: number[] }>();
  slots.forEach((slot, k) => {
    const x = view.x(slot.east);
    const y = view.y(slot.north);
    ctx.beginPath();
    ctx.arc(x, y, k === 0 && led ? 15 : 10, 0, Math.PI * 2);
    ctx.stroke();
    if (!heights) return;
    // Slots above each other share one sign; its label names them all.
    const key = `${Math.round(x / 8)}|${Math.round(y / 8)}`;
    const stack = stacks.get(key) ?? { x, y, ups: [] };
    stack.ups.push(slot.upM);
    stacks.set(key, stack);
  });
  ctx.setLineDash([]);
  ctx.font = FONT;
  ctx.fillStyle = palette.accentStrong;
  ctx.textAlign = 'center';
  ctx.textBaseline = 'middle';
  for (const { x, y, ups } of stacks.values()) ctx.fillText(upsText(ups), x, y + 18);
  ctx.restore();
}

/** Who would take which place of it: a line from each vehicle to its own. */
export function paintAssignment(ctx: CanvasRenderingContext2D, view: View, palette: Palette, ways: readonly { from: Place; to: Place }[]): void {
  ctx.save();
  ctx.strokeStyle = palette.accentStrong;
  ctx.globalAlpha = 0.75;
  ctx.lineWidth = 1.4;
  ctx.setLineDash([2, 4]);
  ctx.beginPath();
  for (const { from, to } of ways) {
    ctx.moveTo(view.x(from.east), view.y(from.north));
    ctx.lineTo(view.x(to.east), view.y(to.north));
  }
  ctx.stroke();
  ctx.restore();
}

export function upsText(ups: readonly number[]): string {
  const signed = (up: number) => `${up < -0.05 ? '-' : '+'}${Math.abs(up).toFixed(1).replace('.0', '')}`;
  return `${ups.map((up) => shown('height', up)).sort((a, b) => a - b).map(signed).join(' ')} ${unitName('height')}`;
}

/** What a formation without a leader goes by: a cross in a diamond, and a line where it looks. */
export function paintAnchor(ctx: CanvasRenderingContext2D, view: View, palette: Palette, at: Place, headingRad: number | null, flown: boolean): void {
  const r = 9;
  ctx.save();
  ctx.translate(view.x(at.east), view.y(at.north));
  ctx.strokeStyle = flown ? palette.route : palette.accentStrong;
  ctx.lineWidth = 1.8;
  ctx.beginPath();
  ctx.moveTo(0, -r);
  ctx.lineTo(r, 0);
  ctx.lineTo(0, r);
  ctx.lineTo(-r, 0);
  ctx.closePath();
  ctx.moveTo(0, -r / 2);
  ctx.lineTo(0, r / 2);
  ctx.moveTo(-r / 2, 0);
  ctx.lineTo(r / 2, 0);
  ctx.stroke();
  if (headingRad !== null) {
    ctx.rotate(headingRad);
    ctx.beginPath();
    ctx.moveTo(0, -r - 3);
    ctx.lineTo(0, -r - 16);
    ctx.moveTo(-4, -r - 11);
    ctx.lineTo(0, -r - 16);
    ctx.lineTo(4, -r - 11);
    ctx.stroke();
  }
  ctx.restore();
}

/** The box being drawn with the pointer to select what is inside. */
export function paintBox(ctx: CanvasRenderingContext2D, palette: Palette, x0: number, y0: number, x1: number, y1: number): void {
  ctx.save();
  ctx.fillStyle = palette.accent;
  ctx.globalAlpha = 0.15;
  ctx.fillRect(x0, y0, x1 - x0, y1 - y0);
  ctx.globalAlpha = 1;
  ctx.strokeStyle = palette.accentStrong;
  ctx.setLineDash([5, 3]);
  ctx.strokeRect(x0, y0, x1 - x0, y1 - y0);
  ctx.restore();
}
