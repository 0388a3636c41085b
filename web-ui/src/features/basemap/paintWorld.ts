// Coasts and borders as thin lines under the grid: where in the world this is, and nothing to fly by.

import type { Palette } from '../map/palette';
import type { View } from '../map/view';
import type { WorldLine } from './world';

/** Returns how many lines were drawn. */
export function paintWorld(ctx: CanvasRenderingContext2D, view: View, palette: Palette, lines: readonly WorldLine[]): number {
  const [west, east] = [view.east(0), view.east(view.width)];
  const [south, north] = [view.north(view.height), view.north(0)];
  const seen = lines.filter((line) => line.maxEast > west && line.minEast < east && line.maxNorth > south && line.minNorth < north);
  ctx.save();
  ctx.strokeStyle = palette.label;
  ctx.lineJoin = 'round';
  for (const kind of ['border', 'coast'] as const) {
    ctx.lineWidth = kind === 'coast' ? 1.6 : 1;
    ctx.setLineDash(kind === 'coast' ? [] : [6, 3, 1.5, 3]);
    ctx.beginPath();
    for (const line of seen) {
      if (line.kind !== kind) continue;
      ctx.moveTo(view.x(line.east[0] ?? 0), view.y(line.north[0] ?? 0));
      for (let k = 1; k < line.north.length; k++) ctx.lineTo(view.x(line.east[k] ?? 0), view.y(line.north[k] ?? 0));
    }
    ctx.stroke();
  }
  ctx.restore();
  return seen.length;
}
