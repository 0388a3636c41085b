// What the swarm sees, asked for while the map shows it: where its cameras look, and what is tracked. Must never ask for what is not shown.

import { Pulse } from '../../model/pulse';
import { getCameraViews, getTracks } from '../../protocol/rest';
import type { CameraViewList, TrackList } from '../../protocol/types';

const EVERY_MS = 400;
/** While there is nothing to be seen. */
const IDLE_MS = 2000;
/** Above so many cameras the pace goes down with their number: one answer holds them all. */
const FULL_PACE = 20;

export class Observed {
  views: CameraViewList = { time: 0, views: [] };
  tracks: TrackList = { time: 0, tracks: [] };
  /** `performance.now()` when each was answered: ages count on from there. */
  viewsAt = 0;
  tracksAt = 0;
  readonly #pulses: readonly Pulse[];

  /** `shown` says which of both the map shows; `changed` is called when there is something new to draw. */
  constructor(shown: { cameras: () => boolean; tracks: () => boolean }, changed: () => void) {
    const askViews = async () => {
      const before = this.views.views.length;
      this.views = await getCameraViews();
      this.viewsAt = performance.now();
      if (before + this.views.views.length > 0) changed();
    };
    const askTracks = async () => {
      const before = this.tracks.tracks.length;
      this.tracks = await getTracks();
      this.tracksAt = performance.now();
      if (before + this.tracks.tracks.length > 0) changed();
    };
    const pace = (count: number) => (count === 0 ? IDLE_MS : EVERY_MS * Math.max(1, count / FULL_PACE));
    this.#pulses = [
      new Pulse(askViews, () => (shown.cameras() ? pace(this.views.views.length) : EVERY_MS), shown.cameras),
      new Pulse(askTracks, () => pace(this.tracks.tracks.length), shown.tracks),
    ];
  }

  /** Asks until the returned function is called. */
  watch(): () => void {
    for (const pulse of this.#pulses) pulse.start();
    return () => {
      for (const pulse of this.#pulses) pulse.stop();
    };
  }
}
