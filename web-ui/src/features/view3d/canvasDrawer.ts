// Draws the view in space on a plain canvas, for browsers and machines without WebGL: the same lines, walls and aircraft, nearest last.

import { levelColour } from '../map/palette';
import type { Palette } from '../map/palette';
import { DART, POSE } from './craft';
import { CRAFT_M, CRAFT_PX, FILL_OPACITY } from './drawer';
import type { Drawer } from './drawer';
import { LINE } from './lineSet';
import type { LineSet } from './lineSet';
import type { Orbit, Spot3 } from './orbit';
import type { SpaceModel } from './spaceModel';

type At = { x: number; y: number; depth: number };

const FACES = [
  ['nose', 'right', 'tail'], ['nose', 'tail', 'left'],
] as const;

export class CanvasDrawer implements Drawer {
  readonly kind = 'canvas';
  readonly #ctx: CanvasRenderingContext2D;
  #ratio = 1;

  constructor(readonly canvas: HTMLCanvasElement) {
    const ctx = canvas.getContext('2d', { alpha: false });
    if (!ctx) throw new Error('this browser gives no 2D canvas');
    this.#ctx = ctx;
  }

  resize(width: number, height: number, ratio: number): void {
    this.#ratio = ratio;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
  }

  draw(model: SpaceModel, orbit: Orbit, palette: Palette): void {
    const ctx = this.#ctx;
    const eye = orbit.eye();
    ctx.setTransform(this.#ratio, 0, 0, this.#ratio, 0, 0);
    ctx.fillStyle = palette.bg;
    ctx.fillRect(0, 0, orbit.width, orbit.height);
    ctx.lineWidth = 1;
    for (const set of model.sets()) if (set.count > 0) this.#lines(set, orbit, eye, palette);
    this.#walls(model, orbit, eye, palette);
    this.#craft(model, orbit, eye, palette);
  }

  dispose(): void {}

  #lines(set: LineSet, orbit: Orbit, eye: Spot3, palette: Palette): void {
    const ctx = this.#ctx;
    const [a, b]: [At, At] = [{ x: 0, y: 0, depth: 0 }, { x: 0, y: 0, depth: 0 }];
    ctx.strokeStyle = palette[set.ink];
    ctx.globalAlpha = set.opacity;
    ctx.beginPath();
    const d = set.data;
    for (let at = 0; at < set.count * LINE; at += LINE) {
      orbit.projectFrom(eye, d[at] ?? 0, d[at + 1] ?? 0, d[at + 2] ?? 0, a);
      orbit.projectFrom(eye, d[at + 3] ?? 0, d[at + 4] ?? 0, d[at + 5] ?? 0, b);
      // One end behind the camera: the part before it.
      if (Number.isNaN(a.x) !== Number.isNaN(b.x)) clip(orbit, eye, d, at, a, b);
      if (Number.isNaN(a.x) || Number.isNaN(b.x)) continue;
      ctx.moveTo(a.x, a.y);
      ctx.lineTo(b.x, b.y);
    }
    ctx.stroke();
    ctx.globalAlpha = 1;
  }

  #walls(model: SpaceModel, orbit: Orbit, eye: Spot3, palette: Palette): void {
    const ctx = this.#ctx;
    const at: At = { x: 0, y: 0, depth: 0 };
    for (const zone of model.zones()) {
      const { floorM, ceilingM } = model.band(zone);
      ctx.fillStyle = zone.kind === 'exclusion' ? palette.warning : palette.fence;
      ctx.globalAlpha = FILL_OPACITY[zone.kind];
      zone.corners.forEach((corner, k) => {
        const next = zone.corners[(k + 1) % zone.corners.length] ?? corner;
        ctx.beginPath();
        for (const [place, up] of [[corner, floorM], [next, floorM], [next, ceilingM], [corner, ceilingM]] as const) {
          orbit.projectFrom(eye, place.north, place.east, up, at);
          // A wall that reaches behind the camera has its edges only.
          if (Number.isNaN(at.x)) return;
          ctx.lineTo(at.x, at.y);
        }
        ctx.fill();
      });
    }
    ctx.globalAlpha = 1;
  }

  #craft(model: SpaceModel, orbit: Orbit, eye: Spot3, palette: Palette): void {
    const { craft } = model;
    const at: At = { x: 0, y: 0, depth: 0 };
    const order: { k: number; depth: number }[] = [];
    for (let k = 0; k < craft.count; k++) {
      orbit.projectFrom(eye, craft.poses[k * POSE] ?? 0, craft.poses[k * POSE + 1] ?? 0, craft.poses[k * POSE + 2] ?? 0, at);
      if (!Number.isNaN(at.x)) order.push({ k, depth: at.depth });
    }
    order.sort((a, b) => b.depth - a.depth);
    for (const { k, depth } of order) this.#dart(model, orbit, eye, palette, k, Math.max(CRAFT_M, CRAFT_PX * orbit.metresPerPixel(depth)));
  }

  #dart(model: SpaceModel, orbit: Orbit, eye: Spot3, palette: Palette, k: number, length: number): void {
    const ctx = this.#ctx;
    const { poses, level, hollow } = model.craft;
    const p = k * POSE;
    const yaw = poses[p + 3] ?? 0;
    const [cos, sin] = [Math.cos(yaw) * length, Math.sin(yaw) * length];
    const at: At = { x: 0, y: 0, depth: 0 };
    const colour = levelColour(palette, level[k] ?? 0);
    ctx.fillStyle = hollow[k] ? palette.bg : colour;
    ctx.strokeStyle = hollow[k] ? colour : palette.outline;
    ctx.lineWidth = 1.4;
    for (const face of FACES) {
      ctx.beginPath();
      for (const corner of face) {
        const [forward, right, up] = DART[corner];
        orbit.projectFrom(eye, (poses[p] ?? 0) + forward * cos - right * sin, (poses[p + 1] ?? 0) + forward * sin + right * cos, (poses[p + 2] ?? 0) + up * length, at);
        ctx.lineTo(at.x, at.y);
      }
      ctx.closePath();
      ctx.fill();
      ctx.stroke();
    }
  }
}

/** Moves the end that is behind the camera to just before it, by halving. */
function clip(orbit: Orbit, eye: Spot3, d: Float32Array, at: number, a: At, b: At): void {
  const [seen, hidden, from, to] = Number.isNaN(a.x) ? [b, a, at + 3, at] : [a, b, at, at + 3];
  let [inside, outside] = [0, 1];
  for (let k = 0; k < 12; k++) {
    const t = (inside + outside) / 2;
    const along = (axis: number) => (d[from + axis] ?? 0) + ((d[to + axis] ?? 0) - (d[from + axis] ?? 0)) * t;
    orbit.projectFrom(eye, along(0), along(1), along(2), hidden);
    if (Number.isNaN(hidden.x)) outside = t;
    else inside = t;
  }
  if (!Number.isNaN(hidden.x)) return;
  hidden.x = seen.x;
  hidden.y = seen.y;
}
