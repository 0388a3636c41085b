import { describe, expect, it } from 'vitest';
import { TrackTrails, freshness } from './trackTrails';

const at = (track: number, seconds: number, north = seconds) => ({ guessed_range: false, track, time: seconds * 1e6, position: { north_m: north, east_m: 2, down_m: -9 } });

describe('the trail of a track', () => {
  it('is thinned out: half a second lies between two spots', () => {
    const trails = new TrackTrails();
    for (let k = 0; k <= 20; k++) trails.take([at(7, k / 10)]);
    expect(trails.of(7).map((spot) => spot.north)).toEqual([0, 0.5, 1, 1.5, 2]);
    expect(trails.of(7)[0]).toEqual({ atMs: 0, north: 0, east: 2, upM: 9 });
  });

  it('reaches back for a minute', () => {
    const trails = new TrackTrails();
    for (let k = 0; k <= 300; k++) trails.take([at(7, k)]);
    expect(trails.of(7)).toHaveLength(61);
    expect(trails.of(7)[0]!.north).toBe(240);
  });

  it('has nothing of a range that is guessed', () => {
    const trails = new TrackTrails();
    trails.take([{ ...at(7, 1, 400), guessed_range: true }]);
    trails.take([at(7, 2)]);
    expect(trails.of(7).map((spot) => spot.north)).toEqual([2]);
  });

  it('goes with its track, and begins anew with another run of the node', () => {
    const trails = new TrackTrails();
    trails.take([at(7, 10), at(8, 10)]);
    trails.take([at(8, 11)]);
    expect([trails.of(7).length, trails.of(8).length]).toEqual([0, 2]);
    trails.take([at(8, 1)]);
    expect(trails.of(8).map((spot) => spot.north)).toEqual([1]);
  });

  it('is not kept for a flood of tracks', () => {
    const trails = new TrackTrails();
    const flood = Array.from({ length: 1000 }, (_, track) => at(track, 1));
    trails.take(flood);
    expect(flood.filter(({ track }) => trails.of(track).length > 0)).toHaveLength(256);
  });

  it('fades', () => {
    const spot = { atMs: 1000, north: 0, east: 0, upM: 0 };
    expect([1000, 31_000, 61_000, 99_000].map((now) => freshness(spot, now))).toEqual([1, 0.5, 0, 0]);
  });
});
