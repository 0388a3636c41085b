import { describe, expect, it } from 'vitest';
import { Fleet } from '../telemetry/fleet';
import { FLAG } from '../protocol/frame';
import { History, KEPT, SAMPLE_MS } from './history';

/** A fleet of one, heard at `heardAt`. */
function fleetOf(heardAt: number): Fleet {
  const fleet = new Fleet();
  fleet.size = 1;
  fleet.ids[0] = 7;
  fleet.present[0] = 1;
  fleet.flags[0] = FLAG.position;
  fleet.heardAt[0] = heardAt;
  fleet.velocityNorth[0] = 3;
  fleet.velocityEast[0] = 4;
  fleet.batteryPercent[0] = 80;
  fleet.trackingErrorM[0] = NaN;
  return fleet;
}

describe('the past of a vehicle', () => {
  it('is sampled at its own rate, oldest first, in seconds before now', () => {
    const history = new History();
    for (let now = 0; now <= 2000; now += 100) history.take(fleetOf(now), () => now / 100, now);
    const [times, height, speed] = history.of(7, ['height', 'speed'], 2000);
    expect(times).toEqual([-2, -1.5, -1, -0.5, 0]);
    expect(height).toEqual([0, 5, 10, 15, 20]);
    expect(speed).toEqual([5, 5, 5, 5, 5]);
  });

  it('has gaps where nothing is known or nobody was heard', () => {
    const history = new History();
    history.take(fleetOf(0), () => 1, 0);
    history.take(fleetOf(0), () => 1, 5000);
    const [, height, error] = history.of(7, ['height', 'error'], 5000);
    expect(height).toEqual([1, null]);
    expect(error).toEqual([null, null]);
    expect(history.of(8, ['height'], 5000)[1]).toEqual([null, null]);
  });

  it('is bounded, and the newest stay', () => {
    const history = new History();
    for (let k = 0; k < KEPT + 10; k++) history.take(fleetOf(k * SAMPLE_MS), () => k, k * SAMPLE_MS);
    const [times, height] = history.of(7, ['height'], (KEPT + 9) * SAMPLE_MS);
    expect(times).toHaveLength(KEPT);
    expect(height?.[0]).toBe(10);
    expect(height?.at(-1)).toBe(KEPT + 9);
    history.clear();
    expect(history.of(7, ['height'], 0)[0]).toEqual([]);
  });
});
