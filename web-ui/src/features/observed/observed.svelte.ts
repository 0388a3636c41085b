// Where the cameras of the swarm look, asked for while the map shows it. Must never ask for what is not shown.

import { Pulse } from '../../model/pulse';
import { getCameraViews } from '../../protocol/rest';
import type { CameraViewList } from '../../protocol/types';

const EVERY_MS = 400;
/** While there is nothing to be seen. */
const IDLE_MS = 2000;
/** Above so many cameras the pace goes down with their number: one answer holds them all. */
const FULL_PACE = 20;

export class Observed {
  views: CameraViewList = { time: 0, views: [] };
  /** `performance.now()` when it was answered: ages count on from there. */
  viewsAt = 0;
  readonly #pulse: Pulse;

  /** `shown` says whether the map shows it; `changed` is called when there is something new to draw. */
  constructor(shown: () => boolean, changed: () => void) {
    const ask = async () => {
      const before = this.views.views.length;
      this.views = await getCameraViews();
      this.viewsAt = performance.now();
      if (before + this.views.views.length > 0) changed();
    };
    const pace = (count: number) => (count === 0 ? IDLE_MS : EVERY_MS * Math.max(1, count / FULL_PACE));
    this.#pulse = new Pulse(ask, () => (shown() ? pace(this.views.views.length) : EVERY_MS), shown);
  }

  /** Asks until the returned function is called. */
  watch(): () => void {
    this.#pulse.start();
    return () => this.#pulse.stop();
  }
}
