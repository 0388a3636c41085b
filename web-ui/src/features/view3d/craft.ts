// The vehicles as the drawers in space need them: pose, colour and whether they are drawn hollow. Arrays that only grow; no objects per
// vehicle.

import { FLAG } from '../../protocol/frame';
import { isAirborne } from '../../telemetry/carry';
import type { Fleet } from '../../telemetry/fleet';
import { classify } from '../../telemetry/staleness';
import { eachPlaced } from '../map/paintFleet';
import type { FleetScene } from '../map/paintFleet';

/** Numbers of a pose: north, east, up, yaw, pitch, roll. */
export const POSE = 6;

/** The dart: nose, right wing tip, tail, left wing tip, keel, in units of its length; forward, right, up. */
export const DART = {
  nose: [0.62, 0, 0.05],
  right: [-0.42, 0.42, 0.05],
  tail: [-0.2, 0, 0.08],
  left: [-0.42, -0.42, 0.05],
  keel: [-0.3, 0, -0.16],
} as const;

export class Craft {
  count = 0;
  poses = new Float32Array(64 * POSE);
  /** Index in the live arrays. */
  index = new Uint16Array(64);
  level = new Uint8Array(64);
  /** On the ground, or of doubtful age: only edges. */
  hollow = new Uint8Array(64);

  /** Those that are drawn as aircraft: not the lost and not the stopped, which have signs of their own. */
  fill(scene: FleetScene, originAltitudeM: number): void {
    this.count = 0;
    eachPlaced(scene.fleet, (i) => {
      const { level, stopped } = scene.marking(i);
      const staleness = classify(scene.fleet.ageMs(i, scene.now), scene.fleet.has(i, FLAG.connected));
      if (stopped || staleness === 'lost') return;
      this.#add(scene.fleet, i, originAltitudeM);
      this.level[this.count - 1] = level;
      this.hollow[this.count - 1] = staleness === 'stale' || !isAirborne(scene.fleet, i) ? 1 : 0;
    });
  }

  #add(fleet: Fleet, i: number, originAltitudeM: number): void {
    if (this.count === this.index.length) this.#grow();
    const at = this.count * POSE;
    this.poses[at] = fleet.shownNorthM[i] ?? 0;
    this.poses[at + 1] = fleet.shownEastM[i] ?? 0;
    this.poses[at + 2] = (fleet.shownAltitudeM[i] ?? 0) - originAltitudeM;
    this.poses[at + 3] = fleet.yawRad[i] ?? 0;
    this.poses[at + 4] = fleet.pitchRad[i] ?? 0;
    this.poses[at + 5] = fleet.rollRad[i] ?? 0;
    this.index[this.count++] = i;
  }

  #grow(): void {
    const n = this.index.length * 2;
    const grown = <T extends Float32Array | Uint16Array | Uint8Array>(larger: T, old: T): T => {
      larger.set(old);
      return larger;
    };
    this.poses = grown(new Float32Array(n * POSE), this.poses);
    this.index = grown(new Uint16Array(n), this.index);
    this.level = grown(new Uint8Array(n), this.level);
    this.hollow = grown(new Uint8Array(n), this.hollow);
  }
}
