// Where vehicles came from, on the canvas. Trails are drawn seldom and kept as a picture; what came since is drawn each time.

import type { Fleet } from '../../telemetry/fleet';
import { TRAIL_POINTS } from '../../telemetry/trails';
import { SHORT_LABELS_FROM, eachPlaced } from './paintFleet';
import type { Palette } from './palette';
import type { View } from './view';

const FADE_STEPS = 4;
/** Points of all trails together that are drawn. */
const TRAIL_BUDGET = 60_000;

export class TrailPainter {
  /** North and east of the newest point of each trail when trails were drawn; NaN where there was none. */
  #ends = new Float64Array(0);

  /** Draws the trails as far as they go now. */
  paint(ctx: CanvasRenderingContext2D, view: View, palette: Palette, fleet: Fleet): void {
    if (this.#ends.length < 2 * fleet.size) this.#ends = new Float64Array(2 * fleet.ids.length);
    this.#ends.fill(NaN);
    ctx.save();
    this.#pen(ctx, palette, fleet);
    // Trails of a crowd are thinned out: their number tells where all came from, not each bend of one.
    const stride = Math.max(1, Math.ceil((fleet.presentCount * TRAIL_POINTS) / TRAIL_BUDGET));
    for (let step = 0; step < FADE_STEPS; step++) {
      ctx.globalAlpha = alphaOf(step);
      ctx.beginPath();
      eachPlaced(fleet, (i) => this.#part(ctx, view, fleet, i, step, stride));
      ctx.stroke();
    }
    ctx.restore();
  }

  /** Draws the way from where the trails ended then to where the vehicles are now. */
  paintSince(ctx: CanvasRenderingContext2D, view: View, palette: Palette, fleet: Fleet): void {
    ctx.save();
    this.#pen(ctx, palette, fleet);
    ctx.globalAlpha = alphaOf(FADE_STEPS - 1);
    ctx.beginPath();
    eachPlaced(fleet, (i) => {
      const [north, east] = [this.#ends[2 * i] ?? NaN, this.#ends[2 * i + 1] ?? NaN];
      if (Number.isNaN(north)) return;
      ctx.moveTo(view.x(east), view.y(north));
      ctx.lineTo(view.x(fleet.shownEastM[i] ?? 0), view.y(fleet.shownNorthM[i] ?? 0));
    });
    ctx.stroke();
    ctx.restore();
  }

  #pen(ctx: CanvasRenderingContext2D, palette: Palette, fleet: Fleet): void {
    ctx.strokeStyle = palette.trail;
    ctx.lineWidth = fleet.presentCount > SHORT_LABELS_FROM ? 1 : 1.5;
    ctx.lineJoin = 'round';
  }

  /** Adds the part of a trail with one degree of fading; points closer than two pixels are left out, but for the newest. */
  #part(ctx: CanvasRenderingContext2D, view: View, fleet: Fleet, index: number, step: number, stride: number): void {
    const length = fleet.trails.length(index);
    const from = Math.floor((length * step) / FADE_STEPS);
    const to = Math.floor((length * (step + 1)) / FADE_STEPS) + 1;
    let lastX = NaN;
    let lastY = NaN;
    fleet.trails.visit(index, from, to, stride, (north, east) => {
      const x = view.x(east);
      const y = view.y(north);
      this.#ends[2 * index] = north;
      this.#ends[2 * index + 1] = east;
      if (Number.isNaN(lastX)) ctx.moveTo(x, y);
      else if (Math.abs(x - lastX) + Math.abs(y - lastY) < 2) return;
      else ctx.lineTo(x, y);
      lastX = x;
      lastY = y;
    });
    if (step === FADE_STEPS - 1 && length > 0) ctx.lineTo(view.x(this.#ends[2 * index + 1] ?? 0), view.y(this.#ends[2 * index] ?? 0));
  }
}

function alphaOf(step: number): number {
  return 0.12 + (0.5 * (step + 1)) / FADE_STEPS;
}
