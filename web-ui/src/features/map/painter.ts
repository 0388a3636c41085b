// Draws the map when something has changed, on the next animation frame and not before. Owns the canvas, not the data.

import type { Console } from '../../app/console.svelte';
import { placeFences } from '../../model/fences';
import type { PlacedFences } from '../../model/fences';
import { FLAG } from '../../protocol/frame';
import type { FencePlan, Geodetic, Route } from '../../protocol/types';
import { paintLabels, paintSlots, paintTrails, paintVehicles } from './paintFleet';
import type { Marking } from './paintFleet';
import { paintFences } from './paintFences';
import { paintFurniture, paintGrid, paintHatching } from './paintGround';
import { paintLadder } from './paintLadder';
import type { Rung } from './paintLadder';
import { paintAnchor, paintBox, paintDraftRoute, paintPreview, paintRoute } from './paintPlan';
import { readPalette } from './palette';
import type { Palette } from './palette';
import { include, isEmpty, noBounds } from './view';
import type { Bounds } from './view';

const FIT_PADDING_PX = 96;
/** ... but on a small map no more than this share of it. */
const FIT_PADDING_SHARE = 0.17;
/** The camera that keeps all in view moves when one comes closer to the edge than this. */
const EDGE_PX = 28;
const CALM: Marking = { level: 0, problem: '', height: '', stopped: false };

const NO_FENCES: PlacedFences = { zones: [], breachReturn: null };

export type SelectionBox = { x0: number; y0: number; x1: number; y1: number };

export class Painter {
  /** Animation frames that were drawn. */
  frames = 0;
  box: SelectionBox | null = null;
  #dirty = true;
  #request = 0;
  #palette: Palette;
  #ratio = 1;
  #placedOnce = false;
  #placedPlan: FencePlan | null = null;
  #placedOrigin: Geodetic | null = null;
  #placedFences: PlacedFences = NO_FENCES;
  readonly #ctx: CanvasRenderingContext2D;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly console: Console,
  ) {
    const ctx = canvas.getContext('2d', { alpha: false });
    if (!ctx) throw new Error('this browser gives no 2D canvas');
    this.#ctx = ctx;
    this.#palette = readPalette(canvas);
  }

  /** Asks for a drawing on the next animation frame. */
  wake = (): void => {
    this.#dirty = true;
    if (this.#request === 0) this.#request = requestAnimationFrame(this.#draw);
  };

  stop(): void {
    cancelAnimationFrame(this.#request);
    this.#request = -1;
  }

  themeChanged(): void {
    this.#palette = readPalette(this.canvas);
    this.wake();
  }

  /** Takes the size of the element in CSS pixels and the screen's pixel ratio. */
  resize(width: number, height: number, ratio: number): void {
    const view = this.console.map.view;
    view.width = Math.max(1, width);
    view.height = Math.max(1, height);
    this.#ratio = ratio;
    this.canvas.width = Math.round(view.width * ratio);
    this.canvas.height = Math.round(view.height * ratio);
    if (this.console.map.camera === 'fleet') this.fit();
    this.wake();
  }

  /** Brings all vehicles and plans into view. */
  fit(): void {
    const bounds = this.#everything();
    if (!isEmpty(bounds)) this.console.map.view.fit(bounds, this.#padding());
    this.wake();
  }

  #draw = (): void => {
    this.#request = 0;
    if (!this.#dirty) return;
    this.#dirty = false;
    this.#moveCamera();
    const ctx = this.#ctx;
    const palette = this.#palette;
    const { map, session, targets, formation } = this.console;
    const { view } = map;
    const { fleet, info } = session;
    ctx.setTransform(this.#ratio, 0, 0, this.#ratio, 0, 0);
    paintGrid(ctx, view, palette);
    paintFences(ctx, view, palette, this.fences());
    const route = this.#flownRoute();
    if (route) {
      const points = route.waypoints.map((w) => ({ north: w.north_m, east: w.east_m }));
      paintRoute(ctx, view, palette, points, info.formation?.route_finished ?? false);
    }
    // Under the vehicles: where they were last is what an operator needs most then.
    if (session.everLive && !session.canCommand) paintHatching(ctx, view, palette);
    if (map.trails) paintTrails(ctx, view, palette, fleet);
    paintSlots(ctx, view, palette, fleet);
    this.#paintAnchors(ctx, palette);
    paintPreview(ctx, view, palette, formation.previewSlots(), formation.anchor === 'leader');
    const scene = { fleet, now: performance.now(), selected: targets.selected, marking: this.#marking };
    paintVehicles(ctx, view, palette, scene);
    paintLabels(ctx, view, palette, scene);
    paintDraftRoute(ctx, view, palette, formation.route.waypoints, this.#leaderPlace());
    if (formation.anchor === 'path') paintDraftRoute(ctx, view, palette, formation.path.waypoints, null);
    if (this.box) paintBox(ctx, palette, this.box.x0, this.box.y0, this.box.x1, this.box.y1);
    paintFurniture(ctx, view, palette);
    paintLadder(ctx, view, palette, this.#rungs());
    this.frames++;
  };

  #marking = (index: number): Marking => {
    const row = this.console.session.rowAt(index);
    return row ? { level: row.level, problem: row.problems.split(' · ', 1)[0] ?? '', height: row.height, stopped: row.stopped } : CALM;
  };

  #rungs(): Rung[] {
    const { session, targets } = this.console;
    return session.rows
      .filter((row) => !Number.isNaN(row.heightM))
      .map((row) => ({ heightM: row.heightM, level: row.level, leader: row.leader, selected: targets.selected.has(row.id) }));
  }

  /** The fences in force about the swarm's origin, worked out anew only when they or the origin are others. */
  fences(): PlacedFences {
    const plan = this.console.watch.fences?.plan ?? null;
    const origin = this.console.session.fleet.projection?.origin ?? null;
    if (plan !== this.#placedPlan || origin !== this.#placedOrigin) {
      this.#placedPlan = plan;
      this.#placedOrigin = origin;
      this.#placedFences = plan ? placeFences(plan, origin) : NO_FENCES;
    }
    return this.#placedFences;
  }

  /** The leader's route, or the path that a formation without a leader goes along. */
  #flownRoute(): Route | null {
    const flown = this.console.session.info.formation;
    if (!flown) return null;
    return flown.route ?? (flown.request.anchor.kind === 'path' ? flown.request.anchor.route : null);
  }

  #paintAnchors(ctx: CanvasRenderingContext2D, palette: Palette): void {
    const { map, session, formation } = this.console;
    const flown = session.info.formation;
    if (flown?.leader === null && flown.anchor) {
      paintAnchor(ctx, map.view, palette, { north: flown.anchor.north_m, east: flown.anchor.east_m }, null, true);
    }
    const basis = formation.anchor === 'leader' ? null : formation.previewBasis();
    if (basis) paintAnchor(ctx, map.view, palette, basis, basis.headingRad, false);
  }

  #leaderPlace(): { north: number; east: number } | null {
    const { fleet, info } = this.console.session;
    const leader = info.formation?.leader ?? this.console.formation.leaderId;
    const index = leader === null ? -1 : fleet.indexOf(leader);
    if (index < 0 || !fleet.has(index, FLAG.position)) return null;
    return { north: fleet.northM[index] ?? 0, east: fleet.eastM[index] ?? 0 };
  }

  #moveCamera(): void {
    const { map } = this.console;
    if (map.camera === 'follow') {
      const bounds = this.#followed();
      if (isEmpty(bounds)) return;
      map.view.centerNorth = (bounds.minNorth + bounds.maxNorth) / 2;
      map.view.centerEast = (bounds.minEast + bounds.maxEast) / 2;
      return;
    }
    if (map.camera !== 'fleet') return;
    const bounds = this.#everything();
    if (isEmpty(bounds)) return;
    if (!this.#placedOnce || !map.view.contains(bounds, EDGE_PX)) {
      this.#placedOnce = true;
      map.view.fit(bounds, this.#padding());
    }
  }

  #padding(): number {
    const { width, height } = this.console.map.view;
    return Math.min(FIT_PADDING_PX, FIT_PADDING_SHARE * Math.min(width, height));
  }

  /** What the following camera looks at: the selected vehicles, or the leader, or all. */
  #followed(): Bounds {
    const { session, targets } = this.console;
    const { fleet, info } = session;
    const bounds = noBounds();
    const leader = info.formation?.leader ?? null;
    const ids = targets.selected.size > 0 ? [...targets.selected] : leader !== null ? [leader] : targets.ids;
    for (const id of ids) {
      const index = fleet.indexOf(id);
      if (index >= 0 && fleet.has(index, FLAG.position)) include(bounds, fleet.northM[index] ?? 0, fleet.eastM[index] ?? 0);
    }
    return bounds;
  }

  #everything(): Bounds {
    const { session, formation } = this.console;
    const { fleet, info } = session;
    const bounds = noBounds();
    for (let i = 0; i < fleet.size; i++) {
      if (fleet.present[i] !== 1 || !fleet.has(i, FLAG.position)) continue;
      include(bounds, fleet.northM[i] ?? 0, fleet.eastM[i] ?? 0);
      if (fleet.has(i, FLAG.slot)) include(bounds, fleet.slotNorthM[i] ?? 0, fleet.slotEastM[i] ?? 0);
    }
    if (info.formation && !info.formation.route_finished) {
      for (const w of this.#flownRoute()?.waypoints ?? []) include(bounds, w.north_m, w.east_m);
    }
    for (const w of formation.route.waypoints) include(bounds, w.north, w.east);
    for (const slot of formation.previewSlots()) include(bounds, slot.north, slot.east);
    return bounds;
  }
}
