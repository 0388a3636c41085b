// What is seen in space, as lines, walls and poses: worked out anew from the live arrays for every picture, the same for both drawers.
// Heights are above the swarm's origin. Must never keep what it was told: the live arrays are the truth.

import type { Console } from '../../app/console.svelte';
import type { PlacedZone } from '../../model/fences';
import { FLAG } from '../../protocol/frame';
import type { Fleet } from '../../telemetry/fleet';
import { TRAIL_POINTS } from '../../telemetry/trails';
import { everything, flownRoute, followedBounds } from '../map/extent';
import { FenceCache } from '../map/fenceCache';
import { drawnLinks } from '../map/linkTable';
import { MOTION_S, eachPlaced } from '../map/paintFleet';
import type { FleetScene } from '../map/paintFleet';
import { errorRings } from '../observed/errorShape';
import { seenGround } from '../observed/paintObserved';
import { seenTracks } from '../observed/paintTracks';
import type { SeenTrack } from '../observed/paintTracks';
import { ruleStepUp } from '../../language/units.svelte';
import { isEmpty } from '../map/view';
import { Craft } from './craft';
import { LineSet } from './lineSet';
import type { Box3, Orbit } from './orbit';

/** Grid lines each way from the middle. */
const GRID_LINES = 30;
const SLOT_CORNERS = 14;
/** Points of all trails together. */
const TRAIL_BUDGET = 40_000;
/** A fence without a ceiling is drawn this much higher than the highest vehicle. */
const HEADROOM_M = 20;

const NO_ZONES: readonly PlacedZone[] = [];

export class SpaceModel {
  /** The ground: seen at a slant it needs stronger lines than the map. */
  readonly minor = new LineSet('major', 0.9);
  readonly major = new LineSet('axis', 1);
  readonly axes = new LineSet('label', 1);
  readonly drops = new LineSet('label', 0.75);
  readonly oldTrails = new LineSet('trail', 0.35);
  readonly newTrails = new LineSet('trail', 0.8);
  readonly slots = new LineSet('slot', 0.9);
  readonly motion = new LineSet('accent', 0.95);
  readonly routes = new LineSet('route', 0.9);
  readonly previews = new LineSet('accent', 0.95);
  readonly inclusions = new LineSet('fence', 1);
  readonly exclusions = new LineSet('warning', 0.95);
  readonly links = [new LineSet('ready', 0.9), new LineSet('advisory', 1), new LineSet('warning', 1), new LineSet('critical', 1)] as const;
  readonly seen = new LineSet('accent', 0.8);
  readonly tracks = new LineSet('label', 1);
  readonly lookedAt = new LineSet('accent', 1);
  readonly oldTrackTrails = new LineSet('label', 0.3);
  readonly newTrackTrails = new LineSet('label', 0.7);
  readonly errors = new LineSet('label', 0.6);
  readonly craft = new Craft();
  readonly fences: FenceCache;
  gridStepM = 1;

  constructor(readonly console: Console) {
    this.fences = new FenceCache(console);
  }

  /** What goes out of sight in the distance: the ground; what is flown and forbidden does not. */
  ground(): readonly LineSet[] {
    return [this.minor, this.major, this.axes];
  }

  sets(): readonly LineSet[] {
    return [
      ...this.ground(), this.inclusions, this.exclusions, this.drops, this.oldTrails, this.newTrails, this.routes, this.slots,
      this.motion, this.previews, ...this.links, this.seen, this.oldTrackTrails, this.newTrackTrails, this.errors, this.tracks, this.lookedAt,
    ];
  }

  zones(): readonly PlacedZone[] {
    return this.console.map.layers.fences ? this.fences.get().zones : NO_ZONES;
  }

  originAltitudeM(): number {
    return this.console.session.fleet.projection?.origin.altitude_amsl_m ?? 0;
  }

  /** Height of the highest vehicle, and of the ground at least. */
  highestM(): number {
    const { fleet } = this.console.session;
    const origin = this.originAltitudeM();
    let highest = 0;
    eachPlaced(fleet, (i) => (highest = Math.max(highest, (fleet.shownAltitudeM[i] ?? 0) - origin)));
    return highest;
  }

  /** Lower and upper edge of a zone as it is drawn. */
  band(zone: PlacedZone): { floorM: number; ceilingM: number } {
    const floorM = zone.floorM ?? 0;
    return { floorM, ceilingM: Math.max(floorM, zone.ceilingM ?? this.highestM() + HEADROOM_M) };
  }

  /** What the camera keeps in view; null while nothing is known. */
  extent(followed: boolean): Box3 | null {
    const bounds = followed ? followedBounds(this.console) : everything(this.console);
    return isEmpty(bounds) ? null : { ...bounds, maxUp: this.highestM() };
  }

  build(orbit: Orbit, scene: FleetScene): void {
    const { layers } = this.console.map;
    for (const set of this.sets()) set.clear();
    this.#grid(orbit, layers.grid);
    this.craft.fill(scene, this.originAltitudeM());
    this.#drops(orbit, scene.fleet);
    if (layers.trails) this.#trails(scene.fleet);
    if (layers.slots) this.#slots(scene.fleet);
    if (layers.motion) this.#motion(scene.fleet);
    if (layers.plans) this.#route();
    if (layers.links) this.#links(scene.now);
    if (layers.cameras) this.#groundSeen(scene.now);
    if (layers.tracks) this.#tracksSeen(scene.now);
    this.#previews();
    for (const zone of this.zones()) this.#edges(zone);
  }

  #grid(orbit: Orbit, shown: boolean): void {
    const step = ruleStepUp(orbit.distanceM / 24);
    this.gridStepM = step * 5;
    if (!shown) return;
    const north = Math.round(orbit.north / step);
    const east = Math.round(orbit.east / step);
    const reach = GRID_LINES * step;
    for (let k = -GRID_LINES; k <= GRID_LINES; k++) {
      const alongEast = (east + k) % 5 === 0 ? this.major : this.minor;
      alongEast.add(north * step - reach, (east + k) * step, 0, north * step + reach, (east + k) * step, 0);
      const alongNorth = (north + k) % 5 === 0 ? this.major : this.minor;
      alongNorth.add((north + k) * step, east * step - reach, 0, (north + k) * step, east * step + reach, 0);
    }
    this.axes.add(north * step - reach, 0, 0, north * step + reach, 0, 0);
    this.axes.add(0, east * step - reach, 0, 0, east * step + reach, 0);
  }

  /** A plumb line from each vehicle to the ground, with a cross at its foot. */
  #drops(orbit: Orbit, fleet: Fleet): void {
    const origin = this.originAltitudeM();
    const foot = orbit.metresPerPixel(orbit.distanceM) * 4;
    eachPlaced(fleet, (i) => {
      const [n, e, u] = [fleet.shownNorthM[i] ?? 0, fleet.shownEastM[i] ?? 0, (fleet.shownAltitudeM[i] ?? 0) - origin];
      this.drops.add(n, e, u, n, e, 0);
      this.drops.add(n - foot, e, 0, n + foot, e, 0);
      this.drops.add(n, e - foot, 0, n, e + foot, 0);
    });
  }

  #trails(fleet: Fleet): void {
    const origin = this.originAltitudeM();
    const stride = Math.max(1, Math.ceil((fleet.presentCount * TRAIL_POINTS) / TRAIL_BUDGET));
    eachPlaced(fleet, (i) => {
      const length = fleet.trails.length(i);
      const half = Math.floor(length / 2);
      for (const [set, from, to] of [[this.oldTrails, 0, half + 1], [this.newTrails, half, length]] as const) {
        let last: readonly [number, number, number] | null = null;
        fleet.trails.visit(i, from, to, stride, (north, east, altitude) => {
          const up = altitude - origin;
          if (last) set.add(last[0], last[1], last[2], north, east, up);
          last = [north, east, up];
        });
        const end = last as readonly [number, number, number] | null;
        if (set === this.newTrails && end) {
          set.add(end[0], end[1], end[2], fleet.shownNorthM[i] ?? 0, fleet.shownEastM[i] ?? 0, (fleet.shownAltitudeM[i] ?? 0) - origin);
        }
      }
    });
  }

  #slots(fleet: Fleet): void {
    const origin = this.originAltitudeM();
    eachPlaced(fleet, (i) => {
      if (!fleet.has(i, FLAG.slot) || fleet.has(i, FLAG.leader)) return;
      const to = [fleet.slotNorthM[i] ?? 0, fleet.slotEastM[i] ?? 0, (fleet.slotAltitudeM[i] ?? 0) - origin] as const;
      this.slots.ring(...to, 1.2, SLOT_CORNERS);
      this.slots.broken([fleet.shownNorthM[i] ?? 0, fleet.shownEastM[i] ?? 0, (fleet.shownAltitudeM[i] ?? 0) - origin], to, 8, 0.5);
    });
  }

  #motion(fleet: Fleet): void {
    const origin = this.originAltitudeM();
    eachPlaced(fleet, (i) => {
      const [n, e, u] = [fleet.shownNorthM[i] ?? 0, fleet.shownEastM[i] ?? 0, (fleet.shownAltitudeM[i] ?? 0) - origin];
      const [vn, ve, vd] = [fleet.velocityNorth[i] ?? 0, fleet.velocityEast[i] ?? 0, fleet.velocityDown[i] ?? 0];
      this.motion.add(n, e, u, n + vn * MOTION_S, e + ve * MOTION_S, u - vd * MOTION_S);
    });
  }

  #route(): void {
    const points = flownRoute(this.console)?.waypoints ?? [];
    points.forEach((point, k) => {
      const up = -point.down_m;
      this.routes.ring(point.north_m, point.east_m, up, 0.8, 8);
      const next = points[k + 1];
      if (next) this.routes.add(point.north_m, point.east_m, up, next.north_m, next.east_m, -next.down_m);
    });
  }

  #links(now: number): void {
    const origin = this.originAltitudeM();
    const [good, fair, poor, lost] = this.links;
    for (const link of drawnLinks(this.console.session, now)) {
      const to = [link.north, link.east, link.altitudeM - origin] as const;
      if (link.quality === 0) good.add(0, 0, 0, ...to);
      else if (link.quality === 1) fair.broken([0, 0, 0], to, 24, 0.65);
      else if (link.quality === 2) poor.broken([0, 0, 0], to, 48, 0.3);
      else lost.broken([0, 0, 0], to, 24, 0.15);
    }
  }

  /** What each camera sees of the ground, and the edges of its view down to there. */
  #groundSeen(now: number): void {
    const { observed } = this.console;
    for (const { corners, cut, from, stale } of seenGround(observed.views, now - observed.viewsAt)) {
      corners.forEach((corner, k) => {
        const next = corners[(k + 1) % corners.length] ?? corner;
        if (!cut[k]) this.seen.broken([corner.north, corner.east, 0], [next.north, next.east, 0], stale ? 24 : 1, stale ? 0.4 : 1);
        this.seen.broken([from.north, from.east, from.upM], [corner.north, corner.east, 0], 24, 0.3);
      });
    }
  }

  /** What is tracked: a box about it, its way as of the vehicles, how well its place is known, and where it was. */
  #tracksSeen(now: number): void {
    for (const track of seenTracks(this.console.tracks, now)) {
      const { north, east, upM, velocityNorth, velocityEast, stale, selected } = track;
      const set = selected ? this.lookedAt : this.tracks;
      set.ring(north, east, upM, 1.6, 4);
      set.ring(north, east, upM, 0.8, 4);
      set.broken([north, east, upM], [north, east, 0], 16, 0.4);
      if (!stale) set.add(north, east, upM, north + velocityNorth * MOTION_S, east + velocityEast * MOTION_S, upM);
      this.#errorOf(track);
      this.#trailOf(track);
    }
  }

  /** Three lines on the ellipsoid of two standard deviations; broken where its range is only guessed. */
  #errorOf({ covariance, guessed, north, east, upM }: SeenTrack): void {
    for (const ring of errorRings(covariance)) {
      ring.forEach((from, k) => {
        const to = ring[(k + 1) % ring.length] ?? from;
        if (guessed && k % 2 === 1) return;
        this.errors.add(north + from.north, east + from.east, upM + from.up, north + to.north, east + to.east, upM + to.up);
      });
    }
  }

  /** Its older half is fainter, as of the vehicles. */
  #trailOf({ trail, north, east, upM }: SeenTrack): void {
    trail.forEach((from, k) => {
      const to = trail[k + 1] ?? { north, east, upM };
      const set = k < trail.length / 2 ? this.oldTrackTrails : this.newTrackTrails;
      set.add(from.north, from.east, from.upM, to.north, to.east, to.upM);
    });
  }

  /** Slots of a formation behind a leader: of others the height is not known before they are flown. */
  #previews(): void {
    const { formation, session, targets } = this.console;
    if (formation.anchor !== 'leader') return;
    const leader = session.fleet.indexOf(formation.leaderId ?? targets.ids[0] ?? -1);
    if (leader < 0) return;
    const up = (session.fleet.shownAltitudeM[leader] ?? 0) - this.originAltitudeM();
    for (const slot of formation.previewSlots()) this.previews.ring(slot.north, slot.east, up + slot.upM, 1.4, SLOT_CORNERS);
  }

  /** Both edges and the uprights of a zone; those of an inclusion zone are broken, as on the map. */
  #edges(zone: PlacedZone): void {
    const { floorM, ceilingM } = this.band(zone);
    const whole = zone.kind === 'exclusion';
    const set = whole ? this.exclusions : this.inclusions;
    const add = (a: readonly [number, number, number], b: readonly [number, number, number]) => {
      if (whole) set.add(...a, ...b);
      else set.broken(a, b, Math.max(1, Math.min(40, Math.round(Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) / this.gridStepM) * 4)), 0.7);
    };
    // A circle has too many corners for an upright at each.
    const every = zone.corners.length > 24 ? Math.ceil(zone.corners.length / 12) : 1;
    zone.corners.forEach((corner, k) => {
      const next = zone.corners[(k + 1) % zone.corners.length] ?? corner;
      for (const up of [floorM, ceilingM]) add([corner.north, corner.east, up], [next.north, next.east, up]);
      if (k % every === 0) add([corner.north, corner.east, floorM], [corner.north, corner.east, ceilingM]);
    });
  }
}
