// Where each track was in the last minute, thinned out and bounded. Touches neither framework nor DOM.

/** How far back, and how close together at most, on the node's clock. */
const REACH_MS = 60_000;
const APART_MS = 500;
/** Of so many tracks a trail is kept; who tells of more gets none for the rest. */
const MOST_TRACKS = 256;

export type TrailSpot = { atMs: number; north: number; east: number; upM: number };
export type Placed = { track: number; time: number; position: { north_m: number; east_m: number; down_m: number }; guessed_range: boolean };

const NONE: readonly TrailSpot[] = [];

export class TrackTrails {
  #trails = new Map<number, TrailSpot[]>();

  /** Takes what is tracked now. A track that is no more has no trail either. */
  take(tracks: readonly Placed[]): void {
    const kept = new Map<number, TrailSpot[]>();
    for (const { track, time, position, guessed_range } of tracks) {
      if (kept.size >= MOST_TRACKS) break;
      const trail = this.#trails.get(track) ?? [];
      const atMs = time / 1000;
      const last = trail.at(-1);
      // A clock that went back is another run of the node: what was before is another thing's.
      if (last && atMs < last.atMs) trail.length = 0;
      // Where it is along the line of sight is not known while its range is guessed: the guesses are no way that it went.
      if (!guessed_range && (!last || atMs < last.atMs || atMs - last.atMs >= APART_MS)) {
        trail.push({ atMs, north: position.north_m, east: position.east_m, upM: -position.down_m });
      }
      const from = trail.findIndex((spot) => atMs - spot.atMs <= REACH_MS);
      if (from > 0) trail.splice(0, from);
      kept.set(track, trail);
    }
    this.#trails = kept;
  }

  /** Oldest first; where it is now is not in it. */
  of(track: number): readonly TrailSpot[] {
    return this.#trails.get(track) ?? NONE;
  }
}

/** How fresh a spot of a trail is: 1 now, 0 when it goes. */
export function freshness(spot: TrailSpot, nowMs: number): number {
  return Math.min(1, Math.max(0, 1 - (nowMs - spot.atMs) / REACH_MS));
}
