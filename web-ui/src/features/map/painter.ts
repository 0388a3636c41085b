// Draws the map when something has changed or is under way. Owns the canvas, not the data.

import type { Console } from '../../app/console.svelte';
import { t } from '../../language/language.svelte';
import type { PlacedFences } from '../../model/fences';
import { FLAG } from '../../protocol/frame';
import { carry } from '../../telemetry/carry';
import type { SwarmProjection } from '../../telemetry/geodesy';
import { paintBase } from '../basemap/paintBase';
import { paintWorld } from '../basemap/paintWorld';
import { CLOSEST_SCALE } from '../basemap/world';
import { paintWays } from '../goto/paintWays';
import { legs } from '../measure/measure';
import type { Leg, Spot } from '../measure/measure';
import { paintMeasure } from '../measure/paintMeasure';
import { paintGroundSeen, seenGround } from '../observed/paintObserved';
import type { SeenGround } from '../observed/paintObserved';
import { paintTracks, seenTracks } from '../observed/paintTracks';
import type { SeenTrack } from '../observed/paintTracks';
import { everything, flownRoute, followedBounds } from './extent';
import { FenceCache } from './fenceCache';
import { HeldCache } from './heldByOthers';
import type { Held } from './heldByOthers';
import { toolsBox } from './labelRoom';
import { drawnLinks } from './linkTable';
import { markingOf } from './marking';
import { paintMotion, paintSlots, paintVehicles } from './paintFleet';
import type { FleetScene, Marking } from './paintFleet';
import { paintFences } from './paintFences';
import { paintFurniture, paintGrid, paintGround, paintHatching } from './paintGround';
import { paintAuthority } from './paintAuthority';
import { paintLabels } from './paintLabels';
import type { OnCanvas } from './paintLabels';
import { paintLadder } from './paintLadder';
import { Pace } from './pace';
import { paintLinks } from './paintLinks';
import type { Rung } from './paintLadder';
import { paintAnchor, paintAssignment, paintBox, paintDraftRoute, paintPreview, paintRoute } from './paintPlan';
import { TrailPainter } from './paintTrails';
import { readPalette } from './palette';
import type { Palette } from './palette';
import { Underlay } from './underlay';
import { isEmpty } from './view';

const FIT_PADDING_PX = 96;
/** ... but on a small map no more than this share of it. */
const FIT_PADDING_SHARE = 0.17;
/** A map narrower than this has little room. */
const ROOMY_PX = 560;
/** The camera that keeps all in view moves when one comes closer to the edge than this. */
const EDGE_PX = 28;

export type SelectionBox = { x0: number; y0: number; x1: number; y1: number };

export class Painter {
  /** Animation frames that were drawn. */
  frames = 0;
  /** Tiles of the operator's own base map in the last picture. */
  baseTiles = 0;
  /** Coasts and borders in the last picture. */
  worldLines = 0;
  /** `performance.now()` when a vehicle was first on the canvas. */
  firstVehicleMs: number | null = null;
  box: SelectionBox | null = null;
  /** Written anew for every question: no garbage for each label. */
  readonly #place: OnCanvas = { x: 0, y: 0 };
  readonly #pace = new Pace(() => this.#draw());
  readonly #trails = new TrailPainter();
  readonly #underlay: Underlay;
  #projection: SwarmProjection | null = null;
  #palette: Palette;
  #ratio = 1;
  #placedOnce = false;
  readonly #fences: FenceCache;
  readonly #held: HeldCache;
  readonly #ctx: CanvasRenderingContext2D;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly console: Console,
  ) {
    const ctx = canvas.getContext('2d', { alpha: false });
    if (!ctx) throw new Error('this browser gives no 2D canvas');
    this.#ctx = ctx;
    this.#underlay = new Underlay(document.createElement('canvas'));
    this.#fences = new FenceCache(console);
    this.#held = new HeldCache(() => console.session.control, console.operator.id);
    this.#palette = readPalette(canvas);
  }

  /** Asks for a drawing of everything on the next animation frame. */
  wake = (): void => {
    this.#underlay.forget();
    this.#pace.soon();
  };

  /** Asks for a drawing of news that come by themselves. */
  news = (): void => this.#pace.news();

  stop(): void {
    this.#pace.stop();
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
    // A canvas with another size is empty, and black: without a drawing before the browser paints, that would be seen.
    this.#pace.now();
  }

  /** Brings all vehicles and plans into view. */
  fit(): void {
    const bounds = everything(this.console);
    if (!isEmpty(bounds)) this.console.map.view.fit(bounds, this.#padding(), this.#covered());
    this.wake();
  }

  /** Draws, and says whether vehicles are under way. */
  #draw(): boolean {
    const { map, session, targets } = this.console;
    if (map.look !== 'flat') return false;
    const now = performance.now();
    const underWay = carry(session.fleet, now, session.replay.pace);
    this.#moveCamera();
    const ctx = this.#ctx;
    const palette = this.#palette;
    const { view } = map;
    ctx.setTransform(this.#ratio, 0, 0, this.#ratio, 0, 0);
    // With another origin the trails begin anew, and what was drawn of the old ones leads nowhere.
    if (this.#projection !== session.fleet.projection) this.#underlay.forget();
    this.#projection = session.fleet.projection;
    this.#underlay.lay(ctx, view, this.#ratio, now, this.#paintLowest);
    if (map.layers.trails) this.#trails.paintSince(ctx, view, palette, session.fleet);
    const scene = { fleet: session.fleet, now, selected: targets.marked, marking: this.#marking };
    this.#paintUnder(ctx, palette, scene);
    paintVehicles(ctx, view, palette, scene);
    if (map.layers.tracks) paintTracks(ctx, view, palette, this.tracksSeen());
    paintAuthority(ctx, view, palette, session.fleet, this.held(), this.#onCanvas);
    if (map.layers.labels) paintLabels(ctx, view, palette, scene, this.#onCanvas);
    this.#paintMarks(ctx, palette);
    paintFurniture(ctx, view, palette);
    if (map.layers.heights) paintLadder(ctx, view, palette, this.#rungs());
    this.frames++;
    if (this.firstVehicleMs === null && session.fleet.presentCount > 0) this.firstVehicleMs = performance.now();
    return underWay;
  }

  #onCanvas = (index: number): OnCanvas => {
    const { view } = this.console.map;
    const { fleet } = this.console.session;
    this.#place.x = view.x(fleet.shownEastM[index] ?? 0);
    this.#place.y = view.y(fleet.shownNorthM[index] ?? 0);
    return this.#place;
  };

  /** Ground, grid, fences and trails. */
  #paintLowest = (ctx: CanvasRenderingContext2D): void => {
    const palette = this.#palette;
    const { map, session } = this.console;
    const { view, layers, base } = map;
    const { projection } = session.fleet;
    paintGround(ctx, view, palette);
    this.worldLines = layers.world && projection && view.scale <= CLOSEST_SCALE ? paintWorld(ctx, view, palette, map.world.lines(projection)) : 0;
    this.baseTiles = base && projection ? paintBase(ctx, view, this.#ratio, projection, base, palette) : 0;
    if (layers.grid) paintGrid(ctx, view, palette);
    if (layers.fences) paintFences(ctx, view, palette, this.fences());
    if (layers.trails) this.#trails.paint(ctx, view, palette, session.fleet);
  };

  /** Plans, ways, slots and links: what vehicles must not be hidden by. */
  #paintUnder(ctx: CanvasRenderingContext2D, palette: Palette, scene: FleetScene): void {
    const { map, session, formation } = this.console;
    const { view, layers } = map;
    const { fleet, info } = session;
    if (layers.cameras) paintGroundSeen(ctx, view, palette, this.groundSeen(), scene.selected);
    const route = layers.plans ? flownRoute(this.console) : null;
    if (route) {
      const points = route.waypoints.map((w) => ({ north: w.north_m, east: w.east_m }));
      paintRoute(ctx, view, palette, points, info.formation?.route_finished ?? false);
    }
    // Under the vehicles: where they were last is what an operator needs most then.
    if (session.everLive && !session.hears) paintHatching(ctx, view, palette);
    if (layers.links) paintLinks(ctx, view, palette, { north: 0, east: 0 }, session.hello?.node ?? t('this node'), drawnLinks(session, scene.now));
    if (layers.slots) paintSlots(ctx, view, palette, fleet);
    if (layers.motion) paintMotion(ctx, view, palette, fleet);
    this.#paintAnchors(ctx, palette);
    paintAssignment(ctx, view, palette, formation.previewWays());
    paintPreview(ctx, view, palette, formation.previewSlots(), formation.anchor === 'leader');
  }

  /** The operator's own marks: routes being drawn, what is measured, the selection box. */
  #paintMarks(ctx: CanvasRenderingContext2D, palette: Palette): void {
    const { map, formation, fence } = this.console;
    const { view } = map;
    paintDraftRoute(ctx, view, palette, formation.route.waypoints, this.#leaderPlace());
    if (formation.anchor === 'path') paintDraftRoute(ctx, view, palette, formation.path.waypoints, null);
    // An outline is a way that ends where it begins.
    paintDraftRoute(ctx, view, palette, fence.waypoints, fence.waypoints.at(-1) ?? null);
    if (map.tool === 'goto') paintWays(ctx, view, palette, this.console.goTo.ways());
    if (map.tool === 'measure') paintMeasure(ctx, view, palette, this.measured(), this.#firstMeasured());
    if (this.box) paintBox(ctx, palette, this.box.x0, this.box.y0, this.box.x1, this.box.y1);
  }

  /** Where a vehicle is, or null while nobody knows. */
  locate = (id: number): Spot | null => {
    const { fleet } = this.console.session;
    const i = fleet.indexOf(id);
    if (i < 0 || !fleet.has(i, FLAG.position)) return null;
    return { north: fleet.shownNorthM[i] ?? 0, east: fleet.shownEastM[i] ?? 0, up: fleet.shownAltitudeM[i] ?? 0, words: t('vehicle {id}', { id }) };
  };

  /** The legs that are measured now. */
  measured(): Leg[] {
    const { map } = this.console;
    return map.tool === 'measure' ? legs(map.measure.points, this.locate) : [];
  }

  #firstMeasured(): { north: number; east: number } | null {
    for (const point of this.console.map.measure.points) {
      const at = point.kind === 'vehicle' ? this.locate(point.id) : point;
      if (at) return at;
    }
    return null;
  }

  #marking = (index: number): Marking => markingOf(this.console.session, index);

  #rungs(): Rung[] {
    const { session, targets } = this.console;
    return session.rows
      .filter((row) => !Number.isNaN(row.heightM))
      .map((row) => ({ heightM: row.heightM, level: row.level, leader: row.leader, selected: targets.marked.has(row.id) }));
  }

  fences(): PlacedFences {
    return this.#fences.get();
  }

  /** Which vehicles are under another operator's control. */
  held(): Held {
    return this.#held.get();
  }

  /** The ground that cameras see, by what was answered last. */
  groundSeen(): SeenGround[] {
    const { observed } = this.console;
    return seenGround(observed.views, performance.now() - observed.viewsAt);
  }

  tracksSeen(): SeenTrack[] {
    return seenTracks(this.console.tracks, performance.now());
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
    return { north: fleet.shownNorthM[index] ?? 0, east: fleet.shownEastM[index] ?? 0 };
  }

  #moveCamera(): void {
    const { map } = this.console;
    if (map.camera === 'follow') {
      const bounds = followedBounds(this.console);
      if (isEmpty(bounds)) return;
      map.view.centerNorth = (bounds.minNorth + bounds.maxNorth) / 2;
      map.view.centerEast = (bounds.minEast + bounds.maxEast) / 2;
      return;
    }
    if (map.camera !== 'fleet') return;
    const bounds = everything(this.console);
    if (isEmpty(bounds)) return;
    if (!this.#placedOnce || !map.view.contains(bounds, EDGE_PX)) {
      this.#placedOnce = true;
      map.view.fit(bounds, this.#padding(), this.#covered());
    }
  }

  /** What the map's tools lie over where there is little room; elsewhere the padding is wider than they are. */
  #covered(): number {
    const { view } = this.console.map;
    return view.width > ROOMY_PX ? 0 : toolsBox(view).w;
  }

  #padding(): number {
    const { width, height } = this.console.map.view;
    return Math.min(FIT_PADDING_PX, FIT_PADDING_SHARE * Math.min(width, height));
  }
}
