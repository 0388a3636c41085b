// Where the lines of trails go, drawn on a canvas that only writes them down.

import { expect, it } from 'vitest';
import { FLAG } from '../../protocol/frame';
import { Fleet } from '../../telemetry/fleet';
import { TRAIL_POINTS } from '../../telemetry/trails';
import type { Palette } from './palette';
import { TrailPainter } from './paintTrails';
import { View } from './view';

const palette = { trail: '#fff' } as Palette;

function pen(): { ctx: CanvasRenderingContext2D; lines: [number, number][][] } {
  const lines: [number, number][][] = [];
  const ctx = {
    save() {}, restore() {}, beginPath() {}, stroke() {},
    moveTo: (x: number, y: number) => lines.push([[x, y]]),
    lineTo: (x: number, y: number) => lines.at(-1)!.push([x, y]),
  };
  return { ctx: ctx as unknown as CanvasRenderingContext2D, lines };
}

/** Two vehicles that are known to be somewhere. */
function swarm(): Fleet {
  const fleet = new Fleet();
  fleet.size = 2;
  fleet.presentCount = 2;
  for (const i of [0, 1]) [fleet.present[i], fleet.flags[i]] = [1, FLAG.position];
  return fleet;
}

/** Vehicle `i` goes north to so many metres. */
function go(fleet: Fleet, i: number, from: number, to: number): void {
  for (let north = from; north <= to; north++) fleet.trails.push(i, north, i * 100, 0);
  [fleet.northM[i], fleet.eastM[i], fleet.shownNorthM[i], fleet.shownEastM[i]] = [to, i * 100, to + 0.5, i * 100];
}

it('a trail goes from the oldest to the newest point without a gap, and what came since from there to the vehicle', () => {
  const [fleet, view, trails] = [swarm(), new View(), new TrailPainter()];
  go(fleet, 0, 0, 40);
  const first = pen();
  trails.paint(first.ctx, view, palette, fleet);
  expect(first.lines[0]![0]).toEqual([view.x(0), view.y(0)]);
  expect(first.lines.at(-1)!.at(-1)).toEqual([view.x(0), view.y(40)]);
  for (let k = 1; k < first.lines.length; k++) expect(first.lines[k]![0]).toEqual(first.lines[k - 1]!.at(-1));

  go(fleet, 0, 41, 45);
  const since = pen();
  trails.paintSince(since.ctx, view, palette, fleet);
  expect(since.lines).toEqual([[[view.x(0), view.y(40)], [view.x(0), view.y(45.5)]]]);
});

it('who had no trail when trails were drawn gets no line, and neither does who is gone', () => {
  const [fleet, view, trails] = [swarm(), new View(), new TrailPainter()];
  const { ctx, lines } = pen();
  trails.paintSince(ctx, view, palette, fleet);
  go(fleet, 0, 0, 5);
  trails.paint(ctx, view, palette, fleet);
  lines.length = 0;
  go(fleet, 1, 0, 5);
  trails.paintSince(ctx, view, palette, fleet);
  expect(lines.map((line) => line[0])).toEqual([[view.x(0), view.y(5)]]);
  fleet.present[0] = 0;
  lines.length = 0;
  trails.paintSince(ctx, view, palette, fleet);
  expect(lines).toEqual([]);
});

it('the newest point of a long trail is on it though points too close to draw are left out', () => {
  const [fleet, view, trails] = [swarm(), new View(), new TrailPainter()];
  view.scale = 0.3;
  go(fleet, 0, 0, TRAIL_POINTS * 2 + 7);
  const { ctx, lines } = pen();
  trails.paint(ctx, view, palette, fleet);
  expect(lines.at(-1)!.at(-1)).toEqual([view.x(0), view.y(TRAIL_POINTS * 2 + 7)]);
  expect(lines.flat().length).toBeLessThan(TRAIL_POINTS / 4);
});
