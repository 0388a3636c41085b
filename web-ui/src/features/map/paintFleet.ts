// Trails, slots, vehicles and their labels on the canvas. Shapes carry the state: an arrowhead flies, a hollow one stands on the
// ground, a broken outline is stale, a cross is lost, an octagon is stopped; colour only repeats it.

import { FLAG } from '../../protocol/frame';
import { LANDED_STATES } from '../../protocol/words';
import type { Fleet } from '../../telemetry/fleet';
import { classify } from '../../telemetry/staleness';
import type { Staleness } from '../../telemetry/staleness';
import { FONT } from './paintGround';
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
const CROWD_SCALE = 0.78;
const SLOT_PX = 10;
const FADE_STEPS = 4;
/** Above so many vehicles labels say the id only. */
const SHORT_LABELS_FROM = 40;

/** Runs over the vehicles of the last frame whose place is known. A place that is not known is never drawn. */
function eachPlaced(fleet: Fleet, visit: (index: number) => void): void {
  for (let i = 0; i < fleet.size; i++) if (fleet.present[i] === 1 && fleet.has(i, FLAG.position)) visit(i);
}

export function paintTrails(ctx: CanvasRenderingContext2D, view: View, palette: Palette, fleet: Fleet): void {
  ctx.save();
  ctx.strokeStyle = palette.trail;
  ctx.lineWidth = 1.5;
  ctx.lineJoin = 'round';
  for (let step = 0; step < FADE_STEPS; step++) {
    ctx.globalAlpha = 0.12 + (0.5 * (step + 1)) / FADE_STEPS;
    ctx.beginPath();
    eachPlaced(fleet, (i) => trailPart(ctx, view, fleet, i, step));
    ctx.stroke();
  }
  ctx.restore();
}

/** Adds the part of a trail with one degree of fading; points closer than two pixels are left out. */
function trailPart(ctx: CanvasRenderingContext2D, view: View, fleet: Fleet, index: number, step: number): void {
  const length = fleet.trails.length(index);
  const from = Math.floor((length * step) / FADE_STEPS);
  const to = Math.floor((length * (step + 1)) / FADE_STEPS);
  let lastX = NaN;
  let lastY = NaN;
  fleet.trails.forEach(index, (north, east, k) => {
    if (k < from || k > to) return;
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

function cross(ctx: CanvasRenderingContext2D, colour: string, palette: Palette): void {
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
function stopSign(ctx: CanvasRenderingContext2D, palette: Palette): void {
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

function brackets(ctx: CanvasRenderingContext2D, palette: Palette): void {
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

function leaderRing(ctx: CanvasRenderingContext2D, palette: Palette): void {
  ctx.strokeStyle = palette.vehicle;
  ctx.lineWidth = 1.5;
  ctx.beginPath();
  ctx.arc(0, 0, 17, 0, Math.PI * 2);
  ctx.moveTo(20.5, 0);
  ctx.arc(0, 0, 20.5, 0, Math.PI * 2);
  ctx.stroke();
}

type Box = { x: number; y: number; w: number; h: number };

/** Labels right of the vehicles, or where there is room; one without room is left out unless its vehicle wants attention. */
export function paintLabels(ctx: CanvasRenderingContext2D, view: View, palette: Palette, scene: FleetScene): void {
  const { fleet } = scene;
  const taken: Box[] = [];
  const short = fleet.presentCount > SHORT_LABELS_FROM;
  // No label over a neighbour's sign, as long as the neighbours can be counted quickly.
  if (!short) {
    eachPlaced(fleet, (i) => {
      taken.push({ x: view.x(fleet.eastM[i] ?? 0) - 11, y: view.y(fleet.northM[i] ?? 0) - 11, w: 22, h: 22 });
    });
  }
  ctx.save();
  ctx.textBaseline = 'middle';
  ctx.textAlign = 'left';
  ctx.lineJoin = 'round';
  ctx.lineWidth = 3;
  ctx.strokeStyle = palette.bg;
  eachPlaced(fleet, (i) => {
    const x = view.x(fleet.eastM[i] ?? 0);
    const y = view.y(fleet.northM[i] ?? 0);
    if (x < 0 || y < 0 || x > view.width || y > view.height) return;
    const id = fleet.ids[i] ?? 0;
    const { level, problem, height } = scene.marking(i);
    const head = fleet.has(i, FLAG.leader) ? `${id} leader` : `${id}`;
    const rest = level >= 2 ? problem : short || !isAirborne(fleet, i) ? '' : height;
    ctx.font = `600 12px ${FONT.slice(FONT.indexOf(' ') + 1)}`;
    const headWidth = ctx.measureText(head).width;
    ctx.font = FONT;
    const restWidth = rest ? ctx.measureText(rest).width + 6 : 0;
    const important = level >= 2 || scene.selected.has(id);
    const reach = fleet.has(i, FLAG.leader) || scene.selected.has(id) ? 26 : 17;
    const box = place(x, y, headWidth + restWidth, reach, taken, important);
    if (!box) return;
    taken.push(box);
    // A plate: a route that runs behind the words must not look like a line through them.
    ctx.fillStyle = ctx.strokeStyle;
    ctx.globalAlpha = 0.8;
    ctx.fillRect(box.x - 2, box.y, headWidth + restWidth + 4, 16);
    ctx.globalAlpha = 1;
    write(ctx, head, box.x, box.y + 8, `600 12px ${FONT.slice(FONT.indexOf(' ') + 1)}`, palette.text);
    if (rest) write(ctx, rest, box.x + headWidth + 6, box.y + 8, FONT, level >= 2 ? levelColour(palette, level) : palette.label);
  });
  ctx.restore();
}

function write(ctx: CanvasRenderingContext2D, text: string, x: number, y: number, font: string, colour: string): void {
  ctx.font = font;
  ctx.strokeText(text, x, y);
  ctx.fillStyle = colour;
  ctx.fillText(text, x, y);
}

function place(x: number, y: number, width: number, reach: number, taken: readonly Box[], important: boolean): Box | null {
  const candidates: Box[] = [
    { x: x + reach, y: y - 8, w: width, h: 16 },
    { x: x - width - reach, y: y - 8, w: width, h: 16 },
    { x: x - width / 2, y: y - reach - 16, w: width, h: 16 },
    { x: x - width / 2, y: y + reach, w: width, h: 16 },
  ];
  const free = candidates.find((c) => !taken.some((t) => c.x < t.x + t.w && t.x < c.x + c.w && c.y < t.y + t.h && t.y < c.y + c.h));
  return free ?? (important ? (candidates[0] ?? null) : null);
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
