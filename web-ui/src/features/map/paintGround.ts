// What lies under the vehicles: graticule, scale bar, compass, and the hatching of a map that is out of date.

import type { Palette } from './palette';
import type { View } from './view';
import { ruleStep, ruleStepUp, ruleText } from '../../language/units.svelte';

export const FONT = '11px system-ui, "Segoe UI", Roboto, "Liberation Sans", Arial, sans-serif';
/** Least distance between two fine grid lines in pixels. */
const MINOR_PX = 18;
const SCALE_BAR_PX = 120;

export function paintGround(ctx: CanvasRenderingContext2D, view: View, palette: Palette): void {
  ctx.fillStyle = palette.bg;
  ctx.fillRect(0, 0, view.width, view.height);
}

/** Grid of round steps about the swarm's origin; every fifth line is stronger and labelled. */
export function paintGrid(ctx: CanvasRenderingContext2D, view: View, palette: Palette): void {
  const minor = ruleStepUp(MINOR_PX / view.scale);
  const major = minor * 5;
  lines(ctx, view, minor, palette.minor);
  lines(ctx, view, major, palette.major);
  ctx.strokeStyle = palette.axis;
  ctx.beginPath();
  const x0 = Math.round(view.x(0)) + 0.5;
  const y0 = Math.round(view.y(0)) + 0.5;
  ctx.moveTo(x0, 0);
  ctx.lineTo(x0, view.height);
  ctx.moveTo(0, y0);
  ctx.lineTo(view.width, y0);
  ctx.stroke();
  gridLabels(ctx, view, minor, major, palette);
}

function lines(ctx: CanvasRenderingContext2D, view: View, step: number, colour: string): void {
  ctx.strokeStyle = colour;
  ctx.lineWidth = 1;
  ctx.beginPath();
  for (let e = Math.ceil(view.east(0) / step) * step; view.x(e) <= view.width; e += step) {
    const x = Math.round(view.x(e)) + 0.5;
    ctx.moveTo(x, 0);
    ctx.lineTo(x, view.height);
  }
  for (let n = Math.ceil(view.north(view.height) / step) * step; view.y(n) >= 0; n += step) {
    const y = Math.round(view.y(n)) + 0.5;
    ctx.moveTo(0, y);
    ctx.lineTo(view.width, y);
  }
  ctx.stroke();
}

function gridLabels(ctx: CanvasRenderingContext2D, view: View, minor: number, step: number, palette: Palette): void {
  ctx.font = FONT;
  ctx.fillStyle = palette.label;
  ctx.textBaseline = 'alphabetic';
  ctx.textAlign = 'center';
  // Room for the tool column on the right and the scale bar on the left is kept free.
  for (let e = Math.ceil(view.east(190) / step) * step; view.x(e) <= view.width - 130; e += step) {
    ctx.fillText(axisLabel(e, minor, 'E', 'W'), view.x(e), view.height - 8);
  }
  ctx.textAlign = 'left';
  for (let n = Math.ceil(view.north(view.height - 70) / step) * step; view.y(n) >= 96; n += step) {
    ctx.fillText(axisLabel(n, minor, 'N', 'S'), 8, view.y(n) - 4);
  }
}

function axisLabel(value: number, minor: number, positive: string, negative: string): string {
  const metres = Math.abs(value);
  return metres < minor / 2 ? '0' : `${ruleText(metres, minor)} ${value > 0 ? positive : negative}`;
}

/** Scale bar at the lower left, north arrow at the upper left. */
export function paintFurniture(ctx: CanvasRenderingContext2D, view: View, palette: Palette): void {
  const metres = ruleStep(SCALE_BAR_PX / view.scale);
  const width = metres * view.scale;
  const x = 14;
  const y = view.height - 16;
  ctx.lineWidth = 2;
  ctx.strokeStyle = palette.text;
  ctx.beginPath();
  ctx.moveTo(x, y - 5);
  ctx.lineTo(x, y);
  ctx.lineTo(x + width, y);
  ctx.lineTo(x + width, y - 5);
  ctx.stroke();
  ctx.font = `600 ${FONT}`;
  ctx.fillStyle = palette.text;
  ctx.textAlign = 'left';
  ctx.fillText(ruleText(metres, metres), x + 2, y - 9);
  ctx.beginPath();
  ctx.moveTo(28, 16);
  ctx.lineTo(35, 40);
  ctx.lineTo(28, 34);
  ctx.lineTo(21, 40);
  ctx.closePath();
  ctx.fill();
  ctx.textAlign = 'center';
  ctx.fillText('N', 28, 56);
}

/** Hatching over the ground: what is drawn on it is not the present. */
export function paintHatching(ctx: CanvasRenderingContext2D, view: View, palette: Palette): void {
  ctx.save();
  ctx.strokeStyle = palette.hatch;
  ctx.lineWidth = 6;
  ctx.beginPath();
  for (let x = -view.height; x < view.width; x += 24) {
    ctx.moveTo(x, view.height);
    ctx.lineTo(x + view.height, 0);
  }
  ctx.stroke();
  ctx.restore();
}
