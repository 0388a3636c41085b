// A zone being drawn on the map: its corners, kind, heights, and what becomes of whom is where it must not be. Must never send anything, and never
// judge the outline: the node says what is no fence, and why.

import type { BreachAction, FencePlan, FenceZone, ZoneKind } from '../protocol/types';
import type { SwarmProjection } from '../telemetry/geodesy';
import { t } from '../language/language.svelte';
import type { PlacedZone } from './fences';

type Corner = { north: number; east: number };

/** What an outline needs to be one. */
export const FEWEST_CORNERS = 3;

export class FenceDraft {
  waypoints = $state.raw<readonly Corner[]>([]);
  name = $state('');
  kind = $state<ZoneKind>('inclusion');
  action = $state<BreachAction>('hold');
  /** Metres above the swarm's origin; null: without end. */
  floorM = $state<number | null>(null);
  ceilingM = $state<number | null>(null);
  /** The zone whose place this one takes; null: it is a new one. */
  instead = $state.raw<FenceZone | null>(null);

  add(corner: Corner): void {
    this.waypoints = [...this.waypoints, corner];
  }

  move(at: number, to: Corner): void {
    this.waypoints = this.waypoints.map((corner, k) => (k === at ? to : corner));
  }

  remove(at: number): void {
    this.waypoints = this.waypoints.filter((_, k) => k !== at);
  }

  clear(): void {
    this.waypoints = [];
    this.name = '';
    this.instead = null;
    this.floorM = this.ceilingM = null;
  }

  /** Takes up a zone in force to change it; `placed` says where it is. */
  take(zone: FenceZone, placed: PlacedZone): void {
    const [first, last] = [placed.corners[0], placed.corners.at(-1)];
    const repeated = first && last && first.north === last.north && first.east === last.east;
    this.waypoints = repeated ? placed.corners.slice(0, -1) : placed.corners;
    this.name = zone.name;
    this.kind = zone.kind;
    this.action = zone.action;
    this.floorM = placed.floorM;
    this.ceilingM = placed.ceilingM;
    this.instead = zone;
  }

  /** The plan in force with this zone in it, in degrees: a fence stays where it was drawn, whatever becomes of the swarm's origin. */
  planOn(inForce: FencePlan, projection: SwarmProjection): FencePlan {
    const corners = this.waypoints.map(({ north, east }) => {
      const { latitudeDeg, longitudeDeg } = projection.unproject(north, east);
      return { latitude_deg: latitudeDeg, longitude_deg: longitudeDeg };
    });
    const zone: FenceZone = {
      name: this.name.trim() || freeName(inForce), kind: this.kind, outline: { shape: 'polygon', corners },
      floor_m: this.floorM, ceiling_m: this.ceilingM, altitude_reference: 'origin', action: this.action,
    };
    return { ...inForce, zones: [...this.others(inForce), zone] };
  }

  /** The zones that stay as they are: all but the one that is changed. If somebody else has changed that meanwhile, theirs stays too. */
  others(inForce: FencePlan): FenceZone[] {
    const was = JSON.stringify(this.instead);
    const at = inForce.zones.findIndex((zone) => JSON.stringify(zone) === was);
    return inForce.zones.filter((_, k) => k !== at);
  }
}

function freeName(plan: FencePlan): string {
  const taken = new Set(plan.zones.map((zone) => zone.name));
  let number = plan.zones.length + 1;
  while (taken.has(t('zone {number}', { number }))) number++;
  return t('zone {number}', { number });
}
