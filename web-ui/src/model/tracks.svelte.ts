// What is tracked, as the stream says it, where each was in the last minute, and which one is looked at. Must never ask or command.

import { TrackTrails } from '../telemetry/trackTrails';
import type { TrackEstimate, TrackList } from '../protocol/types';

const NOTHING: TrackList = { time: 0, tracks: [] };

export class Tracks {
  list = $state.raw<TrackList>(NOTHING);
  /** There was one since the page was opened: what is about tracks is offered from then on, and does not come and go with them. */
  ever = $state(false);
  /** The one that is looked at; it may have ended. */
  selected = $state<number | null>(null);
  /** `performance.now()` when the list came: ages count on from there. */
  at = 0;
  readonly trails = new TrackTrails();

  /** `pace`: so many seconds of what is tracked pass in one. */
  constructor(readonly pace: () => number = () => 1) {}

  take(list: TrackList, at: number): void {
    this.list = list;
    this.at = at;
    this.trails.take(list.tracks);
    if (list.tracks.length > 0) this.ever = true;
  }

  /** On a new connection there are none until the node says so. Their trails are kept for when it does. */
  clear(): void {
    this.list = NOTHING;
  }

  /** What is said from now on is of another moment. */
  restart(): void {
    this.clear();
    this.trails.take([]);
  }

  of(track: number): TrackEstimate | undefined {
    return this.list.tracks.find((one) => one.track === track);
  }

  /** Seconds since a moment on the node's clock. */
  secondsSince(nodeTimeUs: number, now: number): number {
    return Math.max(0, (this.list.time - nodeTimeUs) / 1e6 + ((now - this.at) / 1000) * this.pace());
  }
}
