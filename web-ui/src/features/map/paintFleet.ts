// Slots, ways and vehicles on the canvas. Shapes carry the state: an arrowhead flies, a hollow one stands on the
// ground, a broken outline is stale, a cross is lost, an octagon is stopped; colour only repeats it.

import { FLAG } from '../../protocol/frame';
import { isAirborne } from '../../telemetry/carry';
import type { Fleet } from '../../telemetry/fleet';
import { classify } from '../../telemetry/staleness';
import type { Staleness } from '../../telemetry/staleness';
import { levelColour } from './palette';
import type { Palette } from './palette';
import type { View } from './view';

/** What is known of a vehicle beside the live arrays. */
export type Marking = { level: number; problem: string; height: string; stopped: boolean };

export type FleetScene = {
  fleet: Fleet;
  now: number;
  selected: ReadonlySet<number>;
  marking: (index: number) => Marking;
};

const GLYPH_PX = 12;
/** Signs shrink to this in a crowd. */
export const CROWD_SCALE = 0.78;
const SLOT_PX = 10;
const RIM_PX = 1.5;
const SLOT_DASH = [3, 4];
/** In a crowd there are thousands of dashes. */
const CROWD_DASH = [3, 9];
const NO_DASH: number[] = [];
/** How far ahead the way of a vehicle is drawn. */
export const MOTION_S = 3;
/** Above so many vehicles labels say the id only. */
export const SHORT_LABELS_FROM = 40;

/** Runs over the vehicles of the last frame whose place is known. A place that is not known is never drawn. */
export function eachPlaced(fleet: Fleet, visit: (index: number) => void): void {
  for (let i = 0; i < fleet.size; i++) if (fleet.present[i] === 1 && fleet.has(i, FLAG.position)) visit(i);
}

/** Where each would be in some seconds if it went on as it goes now. */
export function paintMotion(ctx: CanvasRenderingContext2D, view: View, palette: Palette, fleet: Fleet): void {
  ctx.save();
  ctx.strokeStyle = palette.accent;
  ctx.lineWidth = 1.6;
  ctx.beginPath();
  eachPlaced(fleet, (i) => {
    const north = (fleet.velocityNorth[i] ?? 0) * MOTION_S;
    const east = (fleet.velocityEast[i] ?? 0) * MOTION_S;
    if (Math.hypot(north, east) * view.scale < GLYPH_PX) return;
    const [x0, y0] = [view.x(fleet.shownEastM[i] ?? 0), view.y(fleet.shownNorthM[i] ?? 0)];
    const [x1, y1] = [x0 + east * view.scale, y0 - north * view.scale];
    const angle = Math.atan2(y1 - y0, x1 - x0);
    ctx.moveTo(x0, y0);
    ctx.lineTo(x1, y1);
    // A bar across its end, so that it is no trail.
    ctx.moveTo(x1 - Math.sin(angle) * 4, y1 + Math.cos(angle) * 4);
    ctx.lineTo(x1 + Math.sin(angle) * 4, y1 - Math.cos(angle) * 4);
  });
  ctx.stroke();
  ctx.restore();
}

/** Ghosts where the tasks want the vehicles, and a line from each vehicle to its own. Each is stroked for itself: thousands of dashes in one
 *  path take a browser without a graphics card twice as long. */
export function paintSlots(ctx: CanvasRenderingContext2D, view: View, palette: Palette, fleet: Fleet): void {
  const crowd = fleet.presentCount > SHORT_LABELS_FROM;
  const r = crowd ? SLOT_PX * CROWD_SCALE : SLOT_PX;
  const dash = crowd ? CROWD_DASH : SLOT_DASH;
  ctx.save();
  ctx.strokeStyle = palette.slot;
  ctx.lineWidth = 1.2;
  eachPlaced(fleet, (i) => {
    if (!fleet.has(i, FLAG.slot) || fleet.has(i, FLAG.leader)) return;
    const [x, y] = [view.x(fleet.slotEastM[i] ?? 0), view.y(fleet.slotNorthM[i] ?? 0)];
    const [fromX, fromY] = [view.x(fleet.shownEastM[i] ?? 0), view.y(fleet.shownNorthM[i] ?? 0)];
    ctx.setLineDash(NO_DASH);
    ctx.beginPath();
    ctx.arc(x, y, r, 0, Math.PI * 2);
    ctx.stroke();
    // One that is in its slot, as most are, needs no line.
    if (Math.hypot(x - fromX, y - fromY) < r) return;
    ctx.setLineDash(dash);
    ctx.beginPath();
    ctx.moveTo(fromX, fromY);
    ctx.lineTo(x, y);
    ctx.stroke();
  });
  ctx.restore();
}

export function paintVehicles(ctx: CanvasRenderingContext2D, view: View, palette: Palette, scene: FleetScene): void {
  const { fleet, now } = scene;
  eachPlaced(fleet, (i) => {
    const x = view.x(fleet.shownEastM[i] ?? 0);
    const y = view.y(fleet.shownNorthM[i] ?? 0);
    if (x < -30 || y < -30 || x > view.width + 30 || y > view.height + 30) return;
    const staleness = classify(fleet.ageMs(i, now), fleet.has(i, FLAG.connected));
    ctx.save();
    ctx.translate(x, y);
    if (fleet.presentCount > SHORT_LABELS_FROM) ctx.scale(CROWD_SCALE, CROWD_SCALE);
    if (scene.selected.has(fleet.ids[i] ?? 0)) brackets(ctx, palette);
    if (fleet.has(i, FLAG.leader)) leaderRing(ctx, palette);
    const { level, stopped } = scene.marking(i);
    if (staleness === 'lost') cross(ctx, levelColour(palette, Math.max(2, level)), palette);
    else if (stopped) stopSign(ctx, palette);
    else {
      ctx.rotate(fleet.yawRad[i] ?? 0);
      arrow(ctx, palette, levelColour(palette, level), staleness, isAirborne(fleet, i), fleet.has(i, FLAG.armed));
    }
    ctx.restore();
  });
}

function arrow(
  ctx: CanvasRenderingContext2D, palette: Palette, colour: string, staleness: Staleness, airborne: boolean, armed: boolean,
): void {
  const r = airborne ? GLYPH_PX : GLYPH_PX * 0.8;
  if (airborne && staleness !== 'stale') {
    // A larger one behind it is its rim: a fill costs half of what a stroke does.
    dart(ctx, r, RIM_PX);
    ctx.fillStyle = palette.outline;
    ctx.fill();
    dart(ctx, r, 0);
    ctx.globalAlpha = staleness === 'delayed' ? 0.65 : 1;
    ctx.fillStyle = colour;
    ctx.fill();
    return;
  }
  dart(ctx, r, 0);
  ctx.lineJoin = 'round';
  ctx.fillStyle = palette.bg;
  ctx.fill();
  ctx.lineWidth = 1.8;
  ctx.strokeStyle = colour;
  if (staleness === 'stale') ctx.setLineDash([3, 2.5]);
  ctx.stroke();
  if (armed && !airborne) {
    ctx.beginPath();
    ctx.arc(0, 0, 2, 0, Math.PI * 2);
    ctx.fillStyle = colour;
    ctx.fill();
  }
}

/** The outline of an arrow whose tip is `r` from its middle, everywhere larger by `rim`. */
function dart(ctx: CanvasRenderingContext2D, r: number, rim: number): void {
  // At the tip and the tails the sides meet at a sharp angle: there it has to go farther out.
  ctx.beginPath();
  ctx.moveTo(0, -r - rim * 2.1);
  ctx.lineTo(r * 0.72 + rim * 1.5, r * 0.8 + rim * 1.45);
  ctx.lineTo(0, r * 0.42 + rim * 1.15);
  ctx.lineTo(-r * 0.72 - rim * 1.5, r * 0.8 + rim * 1.45);
  ctx.closePath();
}

export function cross(ctx: CanvasRenderingContext2D, colour: string, palette: Palette): void {
  for (const [width, stroke] of [[6, palette.outline], [3, colour]] as const) {
    ctx.lineWidth = width;
    ctx.strokeStyle = stroke;
    ctx.lineCap = 'round';
    ctx.beginPath();
    ctx.moveTo(-7, -7);
    ctx.lineTo(7, 7);
    ctx.moveTo(7, -7);
    ctx.lineTo(-7, 7);
    ctx.stroke();
  }
}

/** Motors stopped in an emergency: a filled octagon with a bar, unlike anything that flies. */
export function stopSign(ctx: CanvasRenderingContext2D, palette: Palette): void {
  const r = 11;
  const c = r * Math.tan(Math.PI / 8);
  ctx.beginPath();
  for (const [x, y] of [[c, -r], [r, -c], [r, c], [c, r], [-c, r], [-r, c], [-r, -c], [-c, -r]] as const) ctx.lineTo(x, y);
  ctx.closePath();
  ctx.lineWidth = 3;
  ctx.strokeStyle = palette.outline;
  ctx.stroke();
  ctx.fillStyle = palette.critical;
  ctx.fill();
  ctx.fillStyle = palette.outline;
  ctx.fillRect(-6, -2, 12, 4);
}

export function brackets(ctx: CanvasRenderingContext2D, palette: Palette): void {
  const r = 19;
  const a = 7;
  ctx.lineWidth = 2;
  ctx.strokeStyle = palette.accentStrong;
  ctx.beginPath();
  for (const [sx, sy] of [[-1, -1], [1, -1], [1, 1], [-1, 1]] as const) {
    ctx.moveTo(sx * r, sy * (r - a));
    ctx.lineTo(sx * r, sy * r);
    ctx.lineTo(sx * (r - a), sy * r);
  }
  ctx.stroke();
}

export function leaderRing(ctx: CanvasRenderingContext2D, palette: Palette): void {
  ctx.strokeStyle = palette.vehicle;
  ctx.lineWidth = 1.5;
  ctx.beginPath();
  ctx.arc(0, 0, 17, 0, Math.PI * 2);
  ctx.moveTo(20.5, 0);
  ctx.arc(0, 0, 20.5, 0, Math.PI * 2);
  ctx.stroke();
}

/** Index of the vehicle nearest to a place on the screen within `reachPx`, or -1. */
export function hitTest(view: View, fleet: Fleet, x: number, y: number, reachPx: number): number {
  let best = -1;
  let bestDistance = reachPx;
  eachPlaced(fleet, (i) => {
    const distance = Math.hypot(view.x(fleet.shownEastM[i] ?? 0) - x, view.y(fleet.shownNorthM[i] ?? 0) - y);
    if (distance <= bestDistance) {
      best = i;
      bestDistance = distance;
    }
  });
  return best;
}

/** Ids of the vehicles inside a box on the screen. */
export function within(view: View, fleet: Fleet, x0: number, y0: number, x1: number, y1: number): number[] {
  const ids: number[] = [];
  eachPlaced(fleet, (i) => {
    const x = view.x(fleet.shownEastM[i] ?? 0);
    const y = view.y(fleet.shownNorthM[i] ?? 0);
    const inX = x >= Math.min(x0, x1) && x <= Math.max(x0, x1);
    if (inX && y >= Math.min(y0, y1) && y <= Math.max(y0, y1)) ids.push(fleet.ids[i] ?? 0);
  });
  return ids;
}
