// What is measured, on the canvas: legs with their distance and bearing, and the sum where there are several.

import { lengthText } from '../../language/units.svelte';
import { FONT } from '../map/paintGround';
import type { Palette } from '../map/palette';
import type { View } from '../map/view';
import { legText, totalM } from './measure';
import type { Leg } from './measure';

export function paintMeasure(ctx: CanvasRenderingContext2D, view: View, palette: Palette, legs: readonly Leg[], first: { north: number; east: number } | null): void {
  if (!first) return;
  ctx.save();
  ctx.lineJoin = 'round';
  const spots = [first, ...legs.map((l) => l.to)];
  for (const [width, colour] of [[4.5, palette.bg], [2, palette.accentStrong]] as const) {
    ctx.lineWidth = width;
    ctx.strokeStyle = colour;
    ctx.beginPath();
    for (const spot of spots) ctx.lineTo(view.x(spot.east), view.y(spot.north));
    ctx.stroke();
  }
  for (const spot of spots) {
    ctx.beginPath();
    ctx.arc(view.x(spot.east), view.y(spot.north), 4, 0, Math.PI * 2);
    ctx.fillStyle = palette.bg;
    ctx.fill();
    ctx.stroke();
  }
  legs.forEach((l, k) => {
    const last = k === legs.length - 1 && legs.length > 1;
    const lines = last ? [legText(l), `Σ ${lengthText(totalM(legs))}`] : [legText(l)];
    plate(ctx, palette, (view.x(l.from.east) + view.x(l.to.east)) / 2, (view.y(l.from.north) + view.y(l.to.north)) / 2, lines);
  });
  ctx.restore();
}

function plate(ctx: CanvasRenderingContext2D, palette: Palette, x: number, y: number, lines: readonly string[]): void {
  ctx.font = `600 ${FONT}`;
  ctx.textAlign = 'center';
  ctx.textBaseline = 'middle';
  const width = Math.max(...lines.map((line) => ctx.measureText(line).width)) + 12;
  const height = lines.length * 15 + 5;
  ctx.fillStyle = palette.bg;
  ctx.globalAlpha = 0.88;
  ctx.fillRect(x - width / 2, y - height / 2, width, height);
  ctx.globalAlpha = 1;
  ctx.fillStyle = palette.accentStrong;
  lines.forEach((line, k) => ctx.fillText(line, x, y - height / 2 + 10 + k * 15));
}
