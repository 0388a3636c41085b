// Trails, slots and vehicles on the canvas. Shapes carry the state: an arrowhead flies, a hollow one stands on the
// ground, a broken outline is stale, a cross is lost, an octagon is stopped; colour only repeats it.

import { FLAG } from '../../protocol/frame';
import { LANDED_STATES } from '../../protocol/words';
import type { Fleet } from '../../telemetry/fleet';
import { classify } from '../../telemetry/staleness';
import { TRAIL_POINTS } from '../../telemetry/trails';
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
const FADE_STEPS = 4;
/** How far ahead the way of a vehicle is drawn. */
export const MOTION_S = 3;
/** Points of all trails together that are drawn. */
const TRAIL_BUDGET = 60_000;
/** Above so many vehicles labels say the id only. */
export const SHORT_LABELS_FROM = 40;

/** Runs over the vehicles of the last frame whose place is known. A place that is not known is never drawn. */
export function eachPlaced(fleet: Fleet, visit: (index: number) => void): void {
  for (let i = 0; i < fleet.size; i++) if (fleet.present[i] === 1 && fleet.has(i, FLAG.position)) visit(i);
}

export function paintTrails(ctx: CanvasRenderingContext2D, view: View, palette: Palette, fleet: Fleet): void {
  ctx.save();
  ctx.strokeStyle = palette.trail;
  ctx.lineWidth = fleet.presentCount > SHORT_LABELS_FROM ? 1 : 1.5;
  ctx.lineJoin = 'round';
  // Trails of a crowd are thinned out: their number tells where all came from, not each bend of one.
  const stride = Math.max(1, Math.ceil((fleet.presentCount * TRAIL_POINTS) / TRAIL_BUDGET));
  for (let step = 0; step < FADE_STEPS; step++) {
    ctx.globalAlpha = 0.12 + (0.5 * (step + 1)) / FADE_STEPS;
    ctx.beginPath();
    eachPlaced(fleet, (i) => trailPart(ctx, view, fleet, i, step, stride));
    ctx.stroke();
  }
  ctx.restore();
}

/** Adds the part of a trail with one degree of fading; points closer than two pixels are left out. */
function trailPart(ctx: CanvasRenderingContext2D, view: View, fleet: Fleet, index: number, step: number, stride: number): void {
  const length = fleet.trails.length(index);
  const from = Math.floor((length * step) / FADE_STEPS);
  const to = Math.floor((length * (step + 1)) / FADE_STEPS) + 1;
  let lastX = NaN;
  let lastY = NaN;
  fleet.trails.visit(index, from, to, stride, (north, east) => {
    const x = view.x(east);
    const y = view.y(north);
    if (Number.isNaN(lastX)) ctx.moveTo(x, y);
    else if (Math.abs(x - lastX) + Math.abs(y - lastY) < 2) return;
    else ctx.lineTo(x, y);
    lastX = x;
    lastY = y;
  });
  if (step === FADE_STEPS - 1 && length > 0) ctx.lineTo(view.x(fleet.eastM[index] ?? 0), view.y(fleet.northM[index] ?? 0));
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
    const [x0, y0] = [view.x(fleet.eastM[i] ?? 0), view.y(fleet.northM[i] ?? 0)];
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

/** Ghosts where the tasks want the vehicles, and a line from each vehicle to its own. */
export function paintSlots(ctx: CanvasRenderingContext2D, view: View, palette: Palette, fleet: Fleet): void {
  ctx.save();
  ctx.strokeStyle = palette.slot;
  ctx.lineWidth = 1.2;
  ctx.beginPath();
  eachPlaced(fleet, (i) => {
    if (!fleet.has(i, FLAG.slot) || fleet.has(i, FLAG.leader)) return;
    const x = view.x(fleet.slotEastM[i] ?? 0);
    const y = view.y(fleet.slotNorthM[i] ?? 0);
    ctx.moveTo(x + SLOT_PX, y);
    ctx.arc(x, y, SLOT_PX, 0, Math.PI * 2);
  });
  ctx.stroke();
  ctx.setLineDash([3, 4]);
  ctx.beginPath();
  eachPlaced(fleet, (i) => {
    if (!fleet.has(i, FLAG.slot) || fleet.has(i, FLAG.leader)) return;
    ctx.moveTo(view.x(fleet.eastM[i] ?? 0), view.y(fleet.northM[i] ?? 0));
    ctx.lineTo(view.x(fleet.slotEastM[i] ?? 0), view.y(fleet.slotNorthM[i] ?? 0));
  });
  ctx.stroke();
  ctx.restore();
}

export function paintVehicles(ctx: CanvasRenderingContext2D, view: View, palette: Palette, scene: FleetScene): void {
  const { fleet, now } = scene;
  eachPlaced(fleet, (i) => {
    const x = view.x(fleet.eastM[i] ?? 0);
    const y = view.y(fleet.northM[i] ?? 0);
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

export function isAirborne(fleet: Fleet, index: number): boolean {
  const landed = LANDED_STATES[fleet.landed[index] ?? 0];
  return landed === 'unknown' ? fleet.has(index, FLAG.armed) : landed !== 'on_ground';
}

function arrow(
  ctx: CanvasRenderingContext2D, palette: Palette, colour: string, staleness: Staleness, airborne: boolean, armed: boolean,
): void {
  const r = airborne ? GLYPH_PX : GLYPH_PX * 0.8;
  ctx.beginPath();
  ctx.moveTo(0, -r);
  ctx.lineTo(r * 0.72, r * 0.8);
  ctx.lineTo(0, r * 0.42);
  ctx.lineTo(-r * 0.72, r * 0.8);
  ctx.closePath();
  ctx.lineJoin = 'round';
  if (airborne && staleness !== 'stale') {
    ctx.lineWidth = 3;
    ctx.strokeStyle = palette.outline;
    ctx.stroke();
    ctx.globalAlpha = staleness === 'delayed' ? 0.65 : 1;
    ctx.fillStyle = colour;
    ctx.fill();
    return;
  }
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
    const distance = Math.hypot(view.x(fleet.eastM[i] ?? 0) - x, view.y(fleet.northM[i] ?? 0) - y);
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
    const x = view.x(fleet.eastM[i] ?? 0);
    const y = view.y(fleet.northM[i] ?? 0);
    const inX = x >= Math.min(x0, x1) && x <= Math.max(x0, x1);
    if (inX && y >= Math.min(y0, y1) && y <= Math.max(y0, y1)) ids.push(fleet.ids[i] ?? 0);
  });
  return ids;
}
