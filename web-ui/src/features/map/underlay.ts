// The lowest part of the map, which changes seldom, kept as a picture: laid down again while the view stands, so that a picture of many
// vehicles that fly does not cost their trails, the grid and the fences each time. Knows nothing of what is drawn.

import type { View } from './view';

/** A picture is laid down for so long; what flies goes some metres meanwhile. */
export const KEPT_MS = 400;

type Place = { centerNorth: number; centerEast: number; scale: number; width: number; height: number; ratio: number };

export class Underlay {
  readonly #ctx: CanvasRenderingContext2D;
  #place: Place | null = null;
  /** `performance.now()` of the picture that is kept; null if it is none. */
  #drawnAt: number | null = null;

  /** `canvas` is for its own use. */
  constructor(readonly canvas: HTMLCanvasElement) {
    const ctx = canvas.getContext('2d', { alpha: false });
    if (!ctx) throw new Error('this browser gives no 2D canvas');
    this.#ctx = ctx;
  }

  /** What was drawn is not true any more. */
  forget(): void {
    this.#drawnAt = null;
  }

  /** Puts the lowest part on a canvas, whose unit is a CSS pixel; `draw` draws it where it is needed anew. */
  lay(ctx: CanvasRenderingContext2D, view: View, ratio: number, now: number, draw: (ctx: CanvasRenderingContext2D) => void): void {
    const stood = this.#stands(view, ratio);
    if (!stood) {
      // A view under way is another one next time: a picture of this one would be of no use.
      const { centerNorth, centerEast, scale, width, height } = view;
      this.#place = { centerNorth, centerEast, scale, width, height, ratio };
      this.#drawnAt = null;
      draw(ctx);
      return;
    }
    if (this.#drawnAt === null || now - this.#drawnAt >= KEPT_MS) {
      this.#fit(view, ratio);
      draw(this.#ctx);
      this.#drawnAt = now;
    }
    ctx.save();
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.drawImage(this.canvas, 0, 0);
    ctx.restore();
  }

  #stands(view: View, ratio: number): boolean {
    const p = this.#place;
    if (!p) return false;
    const same = p.centerNorth === view.centerNorth && p.centerEast === view.centerEast && p.scale === view.scale;
    return same && p.width === view.width && p.height === view.height && p.ratio === ratio;
  }

  #fit(view: View, ratio: number): void {
    const [width, height] = [Math.round(view.width * ratio), Math.round(view.height * ratio)];
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    this.#ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  }
}
