// The heights of all vehicles beside each other at the map's right edge: what a map seen from above cannot show.

import { FONT } from './paintGround';
import { levelColour } from './palette';
import type { Palette } from './palette';
import type { View } from './view';
import { t } from '../../language/language.svelte';
import { shown, unitName, units } from '../../language/units.svelte';

/** One vehicle on the ladder. */
export type Rung = { heightM: number; level: number; leader: boolean; selected: boolean };

/** Room for the map's tools above and the pointer's coordinates below. */
const TOP_PX = 428;
const BOTTOM_PX = 44;
const LEAST_PX = 100;

/** Upper end of the scale: the next 10, 20, 50, 100, … above the highest vehicle, in the unit that is shown. Feet begin with 50. */
export function ladderTop(highestM: number): number {
  const highest = Math.max(units.name === 'metric' ? 0 : 40, shown('height', highestM));
  for (let top = 10; ; top *= 10) {
    for (const factor of [1, 2, 5]) if (highest <= top * factor * 0.95) return top * factor;
  }
}

export function paintLadder(ctx: CanvasRenderingContext2D, view: View, palette: Palette, rungs: readonly Rung[]): void {
  const length = view.height - TOP_PX - BOTTOM_PX;
  if (rungs.length === 0 || length < LEAST_PX) return;
  const top = ladderTop(rungs.reduce((most, r) => Math.max(most, r.heightM), 0));
  const x = view.width - 22;
  const y = (height: number) => TOP_PX + length * (1 - Math.max(-0.02, height / top));
  ctx.save();
  ctx.font = FONT;
  ctx.textAlign = 'right';
  ctx.textBaseline = 'middle';
  ctx.lineWidth = 3;
  ctx.strokeStyle = palette.bg;
  ctx.fillStyle = palette.label;
  const step = top / 5;
  for (let height = 0; height <= top; height += step) {
    const text = height === top ? t('{height} high', { height: `${height} ${unitName('height')}` }) : `${height}`;
    ctx.strokeText(text, x - 18, y(height));
    ctx.fillText(text, x - 18, y(height));
  }
  ctx.strokeStyle = palette.axis;
  ctx.lineWidth = 1;
  ctx.beginPath();
  ctx.moveTo(x + 0.5, y(top));
  ctx.lineTo(x + 0.5, y(0));
  for (let height = 0; height <= top; height += step) {
    ctx.moveTo(x - 4, Math.round(y(height)) + 0.5);
    ctx.lineTo(x + 5, Math.round(y(height)) + 0.5);
  }
  ctx.stroke();
  // The urgent and the selected last, so that nothing hides them.
  const order = [...rungs].sort((a, b) => a.level - b.level || Number(a.selected) - Number(b.selected));
  for (const rung of order) {
    ctx.strokeStyle = rung.selected && rung.level < 2 ? palette.accentStrong : levelColour(palette, rung.level);
    ctx.lineWidth = rung.leader ? 4 : 2;
    ctx.beginPath();
    ctx.moveTo(x - (rung.leader ? 12 : 8), y(shown('height', rung.heightM)));
    ctx.lineTo(x + (rung.leader ? 13 : 9), y(shown('height', rung.heightM)));
    ctx.stroke();
  }
  ctx.restore();
}
