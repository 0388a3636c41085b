// Coasts and borders of the world out of Natural Earth (public domain, as the package `world-atlas` carries it at 1:50 million), in metres about the
// swarm's origin. Fetched when somebody first looks from far enough; must never be drawn closer than it is true.

import type { SwarmProjection } from '../../telemetry/geodesy';
import type { WorldTopology } from './worldLines';

export type WorldLine = { kind: 'coast' | 'border'; north: Float64Array; east: Float64Array; minNorth: number; maxNorth: number; minEast: number; maxEast: number };

/** Pixels per metre: a line may lie some kilometres beside where it belongs, and looked at more closely it would mislead. */
export const CLOSEST_SCALE = 0.02;
const RETRY_MS = 10_000;

export class World {
  #place: ((projection: SwarmProjection) => WorldLine[]) | null = null;
  #asked = false;
  #placed: { projection: SwarmProjection; lines: WorldLine[] } | null = null;

  /** `came` is called when there is something to draw. */
  constructor(readonly came: () => void) {}

  /** The lines about this origin; none as long as they are not here. */
  lines(projection: SwarmProjection): readonly WorldLine[] {
    if (!this.#place) {
      if (!this.#asked) void this.#fetch();
      return [];
    }
    if (this.#placed?.projection !== projection) this.#placed = { projection, lines: this.#place(projection) };
    return this.#placed.lines;
  }

  async #fetch(): Promise<void> {
    this.#asked = true;
    try {
      const [{ placeLines }, { default: url }] = await Promise.all([import('./worldLines'), import('world-atlas/countries-50m.json?url')]);
      const answer = await fetch(url);
      if (!answer.ok) throw new Error(`${answer.status}`);
      const topology = (await answer.json()) as WorldTopology;
      this.#place = (projection) => placeLines(topology, projection);
      this.came();
    } catch {
      // Without it the map is what it was; it is asked for again with a later look from afar.
      setTimeout(() => (this.#asked = false), RETRY_MS);
    }
  }
}
