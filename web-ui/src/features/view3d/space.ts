// The view in space, put together: camera, model, drawer, and on a canvas above them the signs and labels of the vehicles. Draws when
// something has changed or is under way. Must never send anything.

import type { Console } from '../../app/console.svelte';
import { FLAG } from '../../protocol/frame';
import { carry } from '../../telemetry/carry';
import { classify } from '../../telemetry/staleness';
import { HeldCache } from '../map/heldByOthers';
import { markingOf } from '../map/marking';
import { Pace } from '../map/pace';
import { brackets, cross, eachPlaced, leaderRing, stopSign } from '../map/paintFleet';
import type { FleetScene } from '../map/paintFleet';
import { FONT, paintHatching } from '../map/paintGround';
import { paintAuthority } from '../map/paintAuthority';
import { paintLabels } from '../map/paintLabels';
import { paintNames, seenTracks } from '../observed/paintTracks';
import type { SeenTrack } from '../observed/paintTracks';
import { levelColour, readPalette } from '../map/palette';
import type { Palette } from '../map/palette';
import { ruleText } from '../../language/units.svelte';
import type { Drawer } from './drawer';
import { Orbit } from './orbit';
import { SpaceModel } from './spaceModel';
import { t } from '../../language/language.svelte';

export class Space {
  readonly orbit = new Orbit();
  readonly model: SpaceModel;
  /** Pictures that were drawn. */
  frames = 0;
  readonly #pace = new Pace(() => this.#draw());
  #palette: Palette;
  #ratio = 1;
  #placed = false;
  readonly #ctx: CanvasRenderingContext2D;
  readonly #held: HeldCache;
  readonly #at = { x: 0, y: 0, depth: 0 };

  constructor(
    readonly console: Console,
    readonly drawer: Drawer,
    readonly overlay: HTMLCanvasElement,
  ) {
    const ctx = overlay.getContext('2d');
    if (!ctx) throw new Error('this browser gives no 2D canvas');
    this.#ctx = ctx;
    this.#held = new HeldCache(() => console.session.control, console.operator.id);
    this.#palette = readPalette(overlay);
    this.model = new SpaceModel(console);
  }

  /** Asks for a drawing on the next animation frame. */
  wake = (): void => this.#pace.soon();

  /** Asks for a drawing of news that come by themselves. */
  news = (): void => this.#pace.news();

  stop(): void {
    this.#pace.stop();
    this.drawer.dispose();
  }

  themeChanged(): void {
    this.#palette = readPalette(this.overlay);
    this.wake();
  }

  resize(width: number, height: number, ratio: number): void {
    this.orbit.width = Math.max(1, width);
    this.orbit.height = Math.max(1, height);
    this.#ratio = ratio;
    this.overlay.width = Math.round(this.orbit.width * ratio);
    this.overlay.height = Math.round(this.orbit.height * ratio);
    this.drawer.resize(this.orbit.width, this.orbit.height, ratio);
    this.#placed = false;
    // Canvases with another size are empty until they are drawn: that must not be seen.
    this.#pace.now();
  }

  zoom = (factor: number): void => {
    this.orbit.zoom(factor);
    this.#freed();
    this.wake();
  };

  fit = (): void => {
    this.#placed = false;
    const box = this.model.extent(false);
    if (box) this.orbit.fit(box);
    this.wake();
  };

  turn(bearingRad: number, downRad: number): void {
    this.orbit.turn(bearingRad, downRad);
    this.wake();
  }

  pan(dx: number, dy: number): void {
    this.orbit.panBy(dx, dy);
    if (this.console.map.camera !== 'free') this.console.map.setCamera('free');
    this.wake();
  }

  /** Index of the vehicle nearest to a place in the picture within `reachPx`, or -1. */
  hitTest(x: number, y: number, reachPx: number): number {
    let best = -1;
    let least = reachPx;
    eachPlaced(this.console.session.fleet, (i) => {
      const at = this.place(i);
      const distance = Math.hypot(at.x - x, at.y - y);
      if (distance <= least) {
        best = i;
        least = distance;
      }
    });
    return best;
  }

  /** Where a vehicle is in the picture; written anew for every question. */
  place = (index: number): { x: number; y: number; depth: number } => {
    const { fleet } = this.console.session;
    const up = (fleet.shownAltitudeM[index] ?? 0) - this.model.originAltitudeM();
    this.orbit.project(fleet.shownNorthM[index] ?? 0, fleet.shownEastM[index] ?? 0, up, this.#at);
    return this.#at;
  };

  #freed(): void {
    if (this.console.map.camera === 'fleet') this.console.map.setCamera('free');
  }

  /** Draws, and says whether vehicles are under way. */
  #draw(): boolean {
    const { map, session, targets } = this.console;
    const now = performance.now();
    const underWay = carry(session.fleet, now, session.replay.pace);
    this.#moveCamera();
    const scene: FleetScene = {
      fleet: session.fleet, now, selected: targets.marked, marking: (index) => markingOf(session, index),
    };
    this.model.build(this.orbit, scene);
    this.drawer.draw(this.model, this.orbit, this.#palette);
    const ctx = this.#ctx;
    ctx.setTransform(this.#ratio, 0, 0, this.#ratio, 0, 0);
    ctx.clearRect(0, 0, this.orbit.width, this.orbit.height);
    if (session.everLive && !session.hears) this.#hatch(ctx);
    if (map.layers.fences) this.#zoneNames(ctx);
    eachPlaced(scene.fleet, (i) => this.#sign(ctx, scene, i));
    paintAuthority(ctx, this.orbit, this.#palette, scene.fleet, this.#held.get(), this.place);
    if (map.layers.labels) paintLabels(ctx, this.orbit, this.#palette, scene, this.place);
    if (map.layers.tracks) paintNames(ctx, this.orbit, this.#palette, seenTracks(this.console.tracks, now), this.#placeOf);
    this.#furniture(ctx);
    this.frames++;
    return underWay;
  }

  #hatch(ctx: CanvasRenderingContext2D): void {
    ctx.globalAlpha = 0.6;
    paintHatching(ctx, this.console.map.view, this.#palette);
    ctx.globalAlpha = 1;
  }

  #moveCamera(): void {
    const { map } = this.console;
    if (map.camera === 'free' && this.#placed) return;
    const box = this.model.extent(map.camera === 'follow');
    if (!box) return;
    if (map.camera === 'follow' && this.#placed) {
      this.orbit.lookAt((box.minNorth + box.maxNorth) / 2, (box.minEast + box.maxEast) / 2, box.maxUp / 2);
    } else if (!this.#placed || this.orbit.isOff(box)) {
      this.orbit.fit(box);
    }
    this.#placed = true;
  }

  /** What an aircraft's shape cannot say: a target, the leader, one that is lost or stopped. */
  #sign(ctx: CanvasRenderingContext2D, scene: FleetScene, i: number): void {
    const { fleet, now } = scene;
    const selected = scene.selected.has(fleet.ids[i] ?? 0);
    const leads = fleet.has(i, FLAG.leader);
    const { level, stopped } = scene.marking(i);
    const lost = classify(fleet.ageMs(i, now), fleet.has(i, FLAG.connected)) === 'lost';
    if (!selected && !leads && !lost && !stopped) return;
    const { x, y } = this.place(i);
    if (Number.isNaN(x)) return;
    ctx.save();
    ctx.translate(x, y);
    if (selected) brackets(ctx, this.#palette);
    if (leads) leaderRing(ctx, this.#palette);
    if (lost) cross(ctx, levelColour(this.#palette, Math.max(2, level)), this.#palette);
    else if (stopped) stopSign(ctx, this.#palette);
    ctx.restore();
  }

  /** The track nearest to a place in the picture within `reachPx`, or null. */
  trackAt(x: number, y: number, reachPx: number): number | null {
    let best: number | null = null;
    let least = reachPx;
    for (const seen of seenTracks(this.console.tracks, performance.now())) {
      const at = this.#placeOf(seen);
      const distance = Math.hypot(at.x - x, at.y - y);
      if (!(distance <= least)) continue;
      best = seen.track;
      least = distance;
    }
    return best;
  }

  /** Where a track is in the picture; written anew for every question. */
  #placeOf = ({ north, east, upM }: SeenTrack): { x: number; y: number } => {
    this.orbit.project(north, east, upM, this.#at);
    return this.#at;
  };

  #zoneNames(ctx: CanvasRenderingContext2D): void {
    ctx.font = FONT;
    ctx.textAlign = 'center';
    ctx.textBaseline = 'alphabetic';
    ctx.lineJoin = 'round';
    for (const zone of this.model.zones()) {
      const { ceilingM } = this.model.band(zone);
      const n = zone.corners.length;
      const mean = (of: (corner: { north: number; east: number }) => number) => zone.corners.reduce((sum, c) => sum + of(c), 0) / n;
      this.orbit.project(mean((c) => c.north), mean((c) => c.east), ceilingM, this.#at);
      const { x, y } = this.#at;
      if (!(x > 0 && y > 20 && x < this.orbit.width && y < this.orbit.height)) continue;
      ctx.lineWidth = 3;
      ctx.strokeStyle = this.#palette.bg;
      ctx.strokeText(zone.text, x, y - 6);
      ctx.fillStyle = zone.kind === 'exclusion' ? this.#palette.warning : this.#palette.text;
      ctx.fillText(zone.text, x, y - 6);
    }
  }

  /** Compass at the upper left, how wide the grid is at the lower left. */
  #furniture(ctx: CanvasRenderingContext2D): void {
    const { text } = this.#palette;
    ctx.save();
    ctx.translate(30, 36);
    ctx.rotate(-this.orbit.bearingRad);
    ctx.fillStyle = text;
    ctx.beginPath();
    ctx.moveTo(0, -14);
    ctx.lineTo(7, 10);
    ctx.lineTo(0, 4);
    ctx.lineTo(-7, 10);
    ctx.closePath();
    ctx.fill();
    ctx.translate(0, -20);
    ctx.rotate(this.orbit.bearingRad);
    ctx.font = `600 ${FONT}`;
    ctx.textAlign = 'center';
    ctx.textBaseline = 'middle';
    ctx.fillText('N', 0, 0);
    ctx.restore();
    if (!this.console.map.layers.grid) return;
    ctx.font = FONT;
    ctx.textAlign = 'left';
    ctx.textBaseline = 'alphabetic';
    ctx.fillStyle = this.#palette.label;
    const { gridStepM } = this.model;
    ctx.fillText(t('grid {step}, fine {fine}', { step: ruleText(gridStepM, gridStepM / 5), fine: ruleText(gridStepM / 5, gridStepM / 5) }), 14, this.orbit.height - 16);
  }
}
