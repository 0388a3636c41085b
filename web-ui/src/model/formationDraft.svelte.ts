// The formation and the route an operator is putting together, and what the server said to the last one sent.
// Must never decide feasibility: the server's answer is shown as it came.

import { FLAG } from '../protocol/frame';
import { ApiError, endFormation, putFormation, putRoute } from '../protocol/rest';
import type { FormationRequest, HeadingRequest, Route, Shape } from '../protocol/types';
import { label } from '../protocol/words';
import type { Journal } from './journal.svelte';
import type { Session } from './session.svelte';
import { slotOffsets, turned } from './slotPreview';
import type { Targets } from './targets.svelte';
import type { VehicleRow } from './vehicleRow.svelte';

export type Outcome = { tone: 'pending' | 'accepted' | 'refused'; text: string } | null;
export type Waypoint = { north: number; east: number };

const AVAILABLE = new Set(['holding', 'going_to', 'following', 'leading']);

export class FormationDraft {
  shape = $state<Shape>('wedge');
  spacingM = $state(5);
  heading = $state<HeadingRequest['kind']>('auto');
  headingDeg = $state(0);
  altitudeStepM = $state(0);
  leader = $state<number | null>(null);
  /** Show where the slots would be on the map: from the first change until it is sent or put away. */
  preview = $state(false);
  outcome = $state.raw<Outcome>(null);

  waypoints = $state.raw<readonly Waypoint[]>([]);
  routeHeightM = $state<number | null>(null);
  routeSpeedM_s = $state(5);
  cornerRadiusM = $state(8);
  routeOutcome = $state.raw<Outcome>(null);

  readonly #session: Session;
  readonly #targets: Targets;
  readonly #journal: Journal;

  constructor(session: Session, targets: Targets, journal: Journal) {
    this.#session = session;
    this.#targets = targets;
    this.#journal = journal;
  }

  /** Who would take part as far as this page can tell: the targets that are in the air and in the swarm's hands. */
  members = $derived.by<VehicleRow[]>(() => {
    const wanted = new Set(this.#targets.ids);
    return this.#session.rows.filter((row) => wanted.has(row.id) && AVAILABLE.has(row.flightState) && row.staleness !== 'lost');
  });

  leaderId = $derived.by<number | null>(() => {
    const ids = this.members.map((row) => row.id);
    for (const id of [this.leader, this.#session.info.formation?.leader ?? null]) {
      if (id !== null && ids.includes(id)) return id;
    }
    return ids[0] ?? null;
  });

  request(): FormationRequest {
    const heading: HeadingRequest =
      this.heading === 'fixed' ? { kind: 'fixed', heading_deg: this.headingDeg } : { kind: this.heading };
    return {
      shape: this.shape,
      spacing_m: this.spacingM,
      heading,
      altitude_step_m: this.altitudeStepM,
      leader: this.leader,
      members: this.#targets.all ? null : this.#targets.ids,
    };
  }

  /** Places of the slots in metres about the swarm's origin, leader first; empty without a leader whose place is known. */
  previewSlots(): { north: number; east: number }[] {
    const fleet = this.#session.fleet;
    const index = this.leaderId === null ? -1 : fleet.indexOf(this.leaderId);
    if (!this.preview || index < 0 || !fleet.has(index, FLAG.position)) return [];
    const heading = this.heading === 'fixed' ? (this.headingDeg * Math.PI) / 180 : (fleet.yawRad[index] ?? 0);
    const north = fleet.northM[index] ?? 0;
    const east = fleet.eastM[index] ?? 0;
    return slotOffsets(this.shape, this.members.length, this.spacingM, 0).map((offset) => {
      const by = turned(offset, heading);
      return { north: north + by.north, east: east + by.east };
    });
  }

  async send(): Promise<void> {
    const name = label(this.shape);
    this.outcome = { tone: 'pending', text: `${name}: asking the coordinator` };
    try {
      const receipt = await putFormation(this.request());
      const text =
        `${name} of ${receipt.members.length} behind ${receipt.leader}: ${receipt.duration_s.toFixed(0)} s to form, ` +
        `never closer than ${receipt.planned_min_distance_m.toFixed(1)} m`;
      this.outcome = { tone: 'accepted', text };
      this.preview = false;
    } catch (error) {
      this.outcome = this.#refused(`${name} refused`, error);
    }
  }

  async end(): Promise<void> {
    this.outcome = { tone: 'pending', text: 'Ending the formation' };
    try {
      await endFormation();
      this.outcome = { tone: 'accepted', text: 'Formation ended: its vehicles hold' };
    } catch (error) {
      this.outcome = this.#refused('Not ended', error);
    }
  }

  addWaypoint(waypoint: Waypoint): void {
    this.waypoints = [...this.waypoints, waypoint];
    if (this.routeHeightM === null) this.routeHeightM = this.#leaderHeight();
  }

  moveWaypoint(at: number, to: Waypoint): void {
    this.waypoints = this.waypoints.map((w, k) => (k === at ? to : w));
  }

  removeWaypoint(at: number): void {
    this.waypoints = this.waypoints.filter((_, k) => k !== at);
  }

  clearRoute(): void {
    this.waypoints = [];
    this.routeHeightM = null;
    this.routeOutcome = null;
  }

  async sendRoute(): Promise<void> {
    const down = -(this.routeHeightM ?? this.#leaderHeight());
    const route: Route = {
      waypoints: this.waypoints.map((w) => ({ north_m: w.north, east_m: w.east, down_m: down })),
      speed_m_s: this.routeSpeedM_s,
      corner_radius_m: this.cornerRadiusM,
    };
    this.routeOutcome = { tone: 'pending', text: 'Sending the route' };
    try {
      await putRoute(route);
      this.routeOutcome = { tone: 'accepted', text: `Route of ${route.waypoints.length} points taken up` };
      this.waypoints = [];
    } catch (error) {
      this.routeOutcome = this.#refused('Route refused', error);
    }
  }

  /** Height of the leader above the swarm's origin, to the half metre. */
  #leaderHeight(): number {
    const { fleet, info } = this.#session;
    const leader = info.formation?.leader ?? this.leaderId;
    const index = leader === null ? -1 : fleet.indexOf(leader);
    const ground = info.frame?.origin.altitude_amsl_m ?? fleet.projection?.origin.altitude_amsl_m ?? 0;
    return index < 0 ? 10 : Math.max(2, Math.round(((fleet.altitudeM[index] ?? 0) - ground) * 2) / 2);
  }

  #refused(what: string, error: unknown): Outcome {
    const why = error instanceof ApiError ? error.message : String(error);
    this.#journal.notice('warning', 'formation', `${what}: ${why}`);
    return { tone: 'refused', text: `${what}: ${why}` };
  }
}
