// The points being measured between. Must never be anything but the operator's own marks: nothing is sent.

import type { MeasurePoint } from './measure';

export class MeasureDraft {
  points = $state.raw<readonly MeasurePoint[]>([]);

  add(point: MeasurePoint): void {
    this.points = [...this.points, point];
  }

  undo(): void {
    this.points = this.points.slice(0, -1);
  }

  clear(): void {
    this.points = [];
  }
}
