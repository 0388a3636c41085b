// Fences on the canvas. The kind is in the line and the filling, not in the colour alone: an inclusion zone is a broken line with
// nothing in it, an exclusion zone a full line with hatching inside; both are named.

import type { PlacedFences, PlacedZone } from '../../model/fences';
import { FONT } from './paintGround';
import type { Palette } from './palette';
import type { View } from './view';

const HATCH_PX = 11;
const LINE_PX = 15;
/** A zone smaller than this on the screen gets no name. */
const NAMED_PX = 24;

export function paintFences(ctx: CanvasRenderingContext2D, view: View, palette: Palette, fences: PlacedFences): void {
  const named: Label[] = [];
  ctx.save();
  for (const zone of fences.zones) {
    const outline = new Path2D();
    for (const corner of zone.corners) outline.lineTo(view.x(corner.east), view.y(corner.north));
    outline.closePath();
    if (zone.kind === 'exclusion') exclusion(ctx, view, palette, zone, outline);
    else inclusion(ctx, palette, outline);
    name(ctx, view, palette, zone, named);
  }
  if (fences.breachReturn) breachReturn(ctx, view, palette, fences.breachReturn);
  ctx.restore();
}

function inclusion(ctx: CanvasRenderingContext2D, palette: Palette, outline: Path2D): void {
  ctx.strokeStyle = palette.fence;
  ctx.lineWidth = 1.8;
  ctx.setLineDash([10, 4, 2, 4]);
  ctx.stroke(outline);
  ctx.setLineDash([]);
}

function exclusion(ctx: CanvasRenderingContext2D, view: View, palette: Palette, zone: PlacedZone, outline: Path2D): void {
  const box = boxOf(view, zone);
  ctx.save();
  ctx.clip(outline);
  ctx.strokeStyle = palette.warning;
  ctx.globalAlpha = 0.35;
  ctx.lineWidth = 1.2;
  ctx.beginPath();
  // Only what is on the screen is hatched; the lines stand still on the ground's own raster.
  const [left, right] = [Math.max(box.x0, 0), Math.min(box.x1, view.width)];
  const [top, bottom] = [Math.max(box.y0, 0), Math.min(box.y1, view.height)];
  for (let at = Math.floor((left - bottom) / HATCH_PX) * HATCH_PX; at < right - top; at += HATCH_PX) {
    ctx.moveTo(at + top, top);
    ctx.lineTo(at + bottom, bottom);
  }
  ctx.stroke();
  ctx.restore();
  ctx.strokeStyle = palette.warning;
  ctx.lineWidth = 2;
  ctx.stroke(outline);
}

type Label = { x: number; y: number; width: number };

/** Below those that are `named` already, where they would lie on each other. */
function name(ctx: CanvasRenderingContext2D, view: View, palette: Palette, zone: PlacedZone, named: Label[]): void {
  const box = boxOf(view, zone);
  if (box.x1 - box.x0 < NAMED_PX || box.x1 < 0 || box.y1 < 0 || box.x0 > view.width || box.y0 > view.height) return;
  const top = zone.corners.reduce((a, b) => (b.north - b.east > a.north - a.east ? b : a));
  ctx.font = FONT;
  ctx.textAlign = 'left';
  ctx.textBaseline = 'alphabetic';
  const width = ctx.measureText(zone.text).width;
  // A zone that reaches over the edge is named where it can be read.
  const x = Math.min(Math.max(view.x(top.east) + 6, 8), Math.max(8, view.width - width - 70));
  let y = Math.min(Math.max(view.y(top.north) + 15, 76), view.height - 30);
  for (const other of [...named].sort((a, b) => a.y - b.y)) {
    const beside = x > other.x + other.width || other.x > x + width;
    if (!beside && Math.abs(y - other.y) < LINE_PX) y = other.y + LINE_PX;
  }
  named.push({ x, y, width });
  ctx.lineWidth = 3;
  ctx.lineJoin = 'round';
  ctx.strokeStyle = palette.bg;
  ctx.strokeText(zone.text, x, y);
  ctx.fillStyle = zone.kind === 'exclusion' ? palette.warning : palette.text;
  ctx.fillText(zone.text, x, y);
}

function breachReturn(ctx: CanvasRenderingContext2D, view: View, palette: Palette, at: { north: number; east: number }): void {
  const x = view.x(at.east);
  const y = view.y(at.north);
  ctx.strokeStyle = palette.fence;
  ctx.lineWidth = 1.8;
  ctx.beginPath();
  ctx.arc(x, y, 7, 0, Math.PI * 2);
  ctx.moveTo(x - 11, y);
  ctx.lineTo(x + 11, y);
  ctx.moveTo(x, y - 11);
  ctx.lineTo(x, y + 11);
  ctx.stroke();
  ctx.font = FONT;
  ctx.textAlign = 'left';
  ctx.fillStyle = palette.label;
  ctx.fillText('fence return', x + 13, y - 6);
}

function boxOf(view: View, zone: PlacedZone): { x0: number; y0: number; x1: number; y1: number } {
  const box = { x0: Infinity, y0: Infinity, x1: -Infinity, y1: -Infinity };
  for (const corner of zone.corners) {
    const [x, y] = [view.x(corner.east), view.y(corner.north)];
    box.x0 = Math.min(box.x0, x);
    box.x1 = Math.max(box.x1, x);
    box.y0 = Math.min(box.y0, y);
    box.y1 = Math.max(box.y1, y);
  }
  return box;
}
