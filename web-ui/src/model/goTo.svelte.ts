// Where the targets are to go: a place on the map and a height, the ways there, and the order. Must never decide whether a way is free, or send
// anything but what was previewed: the node refuses what is closed and leads around it.

import { FLAG } from '../protocol/frame';
import type { VehicleCommand } from '../protocol/types';
import { t } from '../language/language.svelte';
import { placeText, setText } from '../language/units.svelte';
import type { Commander } from './commander.svelte';
import type { Place } from './formationWords';
import type { Session } from './session.svelte';
import type { Targets } from './targets.svelte';

/** Height in metres above the swarm's origin. */
type Spot = Place & { id: number; upM: number };
export type Way = { id: number; from: Place; to: Place; upM: number };

/** Nobody is sent to the ground by a height that was left as it was found. */
const LOWEST_START_M = 2;

/** The ways of all to a place: together they keep the arrangement that they have, in height as well, so that no two are sent to one spot. */
export function waysTo(spots: readonly Spot[], place: Place, heightM: number): Way[] {
  const mean = (of: (spot: Spot) => number): number => spots.reduce((sum, spot) => sum + of(spot), 0) / spots.length;
  const middle = { north: mean((s) => s.north), east: mean((s) => s.east), upM: mean((s) => s.upM) };
  return spots.map(({ id, north, east, upM }) => ({
    id,
    from: { north, east },
    to: { north: place.north + north - middle.north, east: place.east + east - middle.east },
    upM: heightM + upM - middle.upM,
  }));
}

export function commandTo(way: Way): VehicleCommand {
  return { command: 'go_to', position: { north_m: way.to.north, east_m: way.to.east, down_m: 0 - way.upM }, yaw_rad: null, speed_m_s: null };
}

export class GoTo {
  place = $state.raw<Place | null>(null);
  /** As typed; null: as high as they are. */
  typedM = $state<number | null>(null);
  /** The order that was given last, by its key in the ledger. */
  #given = $state<number | null>(null);

  constructor(
    readonly session: Session,
    readonly targets: Targets,
    readonly commander: Commander,
  ) {}

  /** Puts the place; what was said of the order before this one is over. */
  put(place: Place): void {
    this.place = place;
    this.#given = null;
  }

  clear(): void {
    this.place = this.typedM = this.#given = null;
  }

  get heightM(): number {
    if (this.typedM !== null) return this.typedM;
    const spots = this.#spots();
    const mean = spots.reduce((sum, spot) => sum + spot.upM, 0) / Math.max(1, spots.length);
    return Math.max(LOWEST_START_M, Math.round(mean * 2) / 2);
  }

  ways(): Way[] {
    return this.place ? waysTo(this.#spots(), this.place, this.heightM) : [];
  }

  /** Sends what is previewed. */
  async send(): Promise<void> {
    const place = this.place;
    const ways = this.ways();
    if (!place || ways.length === 0) return;
    const where = `${placeText(place.north)} ${place.north < 0 ? 'S' : 'N'}, ${placeText(place.east)} ${place.east < 0 ? 'W' : 'E'}, ${setText('height', this.heightM)}`;
    const orders = ways.map((way) => ({ vehicle: way.id, command: commandTo(way) }));
    this.#given = await this.commander.runEach(orders, t('Fly there'), where);
    if (this.refused === '') this.clear();
  }

  /** Who would not go there, and why; empty as long as nobody has refused. */
  get refused(): string {
    const entries = this.commander.ledger.batches.find((batch) => batch.key === this.#given)?.entries ?? [];
    return entries.filter((entry) => entry.phase === 'refused' || entry.phase === 'unknown').map((entry) => `${entry.vehicle}: ${entry.detail}`).join('; ');
  }

  /** Where the targets are, as far as that is known. Those on the ground stay there, unless nobody flies: then the node says why not. */
  #spots(): Spot[] {
    const { fleet, info } = this.session;
    const ground = info.frame?.origin.altitude_amsl_m ?? 0;
    const known = this.targets.ids.map((id) => fleet.indexOf(id)).filter((i) => i >= 0 && fleet.has(i, FLAG.position));
    const flying = known.filter((i) => this.session.rowAt(i)?.airborne);
    return (flying.length > 0 ? flying : known).map((i) => {
      const id = fleet.ids[i] ?? 0;
      return { id, north: fleet.northM[i] ?? 0, east: fleet.eastM[i] ?? 0, upM: (fleet.altitudeM[i] ?? 0) - ground };
    });
  }
}
