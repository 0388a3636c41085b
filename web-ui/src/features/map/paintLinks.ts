// The links on the canvas. The line says the quality before its colour does: whole is good, broken is fair, dotted is poor, and one that
// is lost ends in a cross; what is not good is also written.

import { FONT } from './paintGround';
import { levelColour } from './palette';
import type { Palette } from './palette';
import type { Quality } from './links';
import type { View } from './view';

export type DrawnLink = { north: number; east: number; quality: Quality; text: string };

const DASHES: Record<Quality, readonly number[]> = { 0: [], 1: [9, 5], 2: [2, 5], 3: [2, 9] };
/** Above so many faulty links their lines speak for themselves. */
const WRITTEN = 30;

export function paintLinks(
  ctx: CanvasRenderingContext2D, view: View, palette: Palette, from: { north: number; east: number }, name: string, links: readonly DrawnLink[],
): void {
  const x0 = view.x(from.east);
  const y0 = view.y(from.north);
  ctx.save();
  ctx.lineWidth = 1.4;
  for (const quality of [0, 1, 2, 3] as const) {
    ctx.strokeStyle = quality === 0 ? palette.ready : levelColour(palette, quality);
    ctx.setLineDash([...DASHES[quality]]);
    ctx.beginPath();
    for (const link of links) {
      if (link.quality !== quality) continue;
      ctx.moveTo(x0, y0);
      ctx.lineTo(view.x(link.east), view.y(link.north));
    }
    ctx.stroke();
  }
  ctx.setLineDash([]);
  ctx.font = FONT;
  ctx.textAlign = 'center';
  ctx.textBaseline = 'middle';
  ctx.lineJoin = 'round';
  const faulty = links.filter((link) => link.quality > 0);
  for (const link of faulty.slice(0, WRITTEN)) mark(ctx, view, palette, { x: x0, y: y0 }, link);
  station(ctx, palette, x0, y0, name);
  ctx.restore();
}

/** In the middle of the line: a cross for one that is lost, and in words what is wrong. */
function mark(ctx: CanvasRenderingContext2D, view: View, palette: Palette, from: { x: number; y: number }, link: DrawnLink): void {
  const x = (from.x + view.x(link.east)) / 2;
  const y = (from.y + view.y(link.north)) / 2;
  const colour = levelColour(palette, link.quality);
  if (link.quality === 3) {
    ctx.lineWidth = 2.4;
    ctx.strokeStyle = colour;
    ctx.beginPath();
    ctx.moveTo(x - 5, y - 5);
    ctx.lineTo(x + 5, y + 5);
    ctx.moveTo(x + 5, y - 5);
    ctx.lineTo(x - 5, y + 5);
    ctx.stroke();
  }
  ctx.lineWidth = 3;
  ctx.strokeStyle = palette.bg;
  const below = link.quality === 3 ? 14 : 0;
  ctx.strokeText(link.text, x, y + below);
  ctx.fillStyle = colour;
  ctx.fillText(link.text, x, y + below);
}

/** A mast: where the lines come from. */
function station(ctx: CanvasRenderingContext2D, palette: Palette, x: number, y: number, name: string): void {
  for (const [width, colour] of [[5, palette.bg], [1.8, palette.text]] as const) {
    ctx.lineWidth = width;
    ctx.strokeStyle = colour;
    ctx.beginPath();
    ctx.moveTo(x - 6, y + 8);
    ctx.lineTo(x, y - 6);
    ctx.lineTo(x + 6, y + 8);
    ctx.moveTo(x + 5, y - 11);
    ctx.arc(x, y - 8, 5.8, -0.6, 0.6);
    ctx.moveTo(x - 4.8, y - 4.7);
    ctx.arc(x, y - 8, 5.8, Math.PI - 0.6, Math.PI + 0.6);
    ctx.stroke();
  }
  ctx.textAlign = 'left';
  ctx.lineWidth = 3;
  ctx.strokeStyle = palette.bg;
  const text = `${name}, drawn at the frame's origin`;
  ctx.strokeText(text, x + 12, y + 8);
  ctx.fillStyle = palette.label;
  ctx.fillText(text, x + 12, y + 8);
}
