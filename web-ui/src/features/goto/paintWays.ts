// The ways that a command to go somewhere would have vehicles fly, straight as they are asked for. Says nothing of what lies between.

import type { Way } from '../../model/goTo.svelte';
import type { Palette } from '../map/palette';
import type { View } from '../map/view';

const RING_PX = 9;

export function paintWays(ctx: CanvasRenderingContext2D, view: View, palette: Palette, ways: readonly Way[]): void {
  ctx.save();
  ctx.strokeStyle = palette.accentStrong;
  ctx.fillStyle = palette.accentStrong;
  ctx.lineWidth = 2;
  for (const { from, to } of ways) {
    const [x, y] = [view.x(to.east), view.y(to.north)];
    ctx.setLineDash([7, 5]);
    ctx.beginPath();
    ctx.moveTo(view.x(from.east), view.y(from.north));
    ctx.lineTo(x, y);
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.beginPath();
    ctx.arc(x, y, RING_PX, 0, 2 * Math.PI);
    ctx.stroke();
    ctx.beginPath();
    ctx.arc(x, y, 2, 0, 2 * Math.PI);
    ctx.fill();
  }
  ctx.restore();
}
