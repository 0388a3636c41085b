// A small person at the upper left of each vehicle that is under another operator's control; struck through, and in outline only, where that
// one is not heard. All signs of a kind are one path: a thousand cost a few strokes.

import type { Fleet } from '../../telemetry/fleet';
import type { Held } from './heldByOthers';
import { CROWD_SCALE, SHORT_LABELS_FROM, eachPlaced } from './paintFleet';
import type { Locator } from './paintLabels';
import type { Palette } from './palette';

/** From the middle of the vehicle to the middle of the sign, each way. */
const OFF_PX = 13;
const PLATE_PX = 7;
/** Farther off the picture than this nothing of a sign is seen. */
const MARGIN_PX = 24;

type Spot = readonly [x: number, y: number];

export function paintAuthority(
  ctx: CanvasRenderingContext2D, size: { width: number; height: number }, palette: Palette, fleet: Fleet, held: Held, at: Locator,
): void {
  if (held.size === 0) return;
  const scale = fleet.presentCount > SHORT_LABELS_FROM ? CROWD_SCALE : 1;
  const spots: Record<'heard' | 'silent', Spot[]> = { heard: [], silent: [] };
  eachPlaced(fleet, (i) => {
    const kind = held.get(fleet.ids[i] ?? 0);
    if (kind === undefined) return;
    const { x, y } = at(i);
    // Not a number is no place either.
    if (!(x > -MARGIN_PX && y > -MARGIN_PX && x < size.width + MARGIN_PX && y < size.height + MARGIN_PX)) return;
    spots[kind].push([x - OFF_PX * scale, y - OFF_PX * scale]);
  });
  const all = [...spots.heard, ...spots.silent];
  if (all.length === 0) return;
  ctx.save();
  ctx.lineWidth = 1;
  ctx.fillStyle = palette.bg;
  ctx.strokeStyle = palette.axis;
  ctx.beginPath();
  for (const [x, y] of all) circle(ctx, x, y, PLATE_PX * scale);
  ctx.fill();
  ctx.stroke();
  if (spots.heard.length > 0) {
    ctx.fillStyle = palette.text;
    ctx.beginPath();
    for (const [x, y] of spots.heard) person(ctx, x, y, scale);
    ctx.fill();
  }
  if (spots.silent.length > 0) {
    ctx.lineWidth = 1.2;
    ctx.strokeStyle = palette.warning;
    ctx.beginPath();
    for (const [x, y] of spots.silent) {
      person(ctx, x, y, scale);
      ctx.moveTo(x - 5.5 * scale, y - 5.5 * scale);
      ctx.lineTo(x + 5.5 * scale, y + 5.5 * scale);
    }
    ctx.stroke();
  }
  ctx.restore();
}

function circle(ctx: CanvasRenderingContext2D, x: number, y: number, r: number): void {
  ctx.moveTo(x + r, y);
  ctx.arc(x, y, r, 0, Math.PI * 2);
}

/** Head and shoulders, as the sign in the list has them. */
function person(ctx: CanvasRenderingContext2D, x: number, y: number, scale: number): void {
  circle(ctx, x, y - 2.2 * scale, 2.1 * scale);
  const [foot, reach] = [y + 4.4 * scale, 3.9 * scale];
  ctx.moveTo(x - reach, foot);
  ctx.arc(x, foot, reach, Math.PI, 0);
  ctx.closePath();
}
