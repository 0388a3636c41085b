import { describe, expect, it } from 'vitest';
import { Tracks } from '../../model/tracks.svelte';
import type { TrackEstimate } from '../../protocol/types';
import { View } from '../map/view';
import { seenTracks, trackAt } from './paintTracks';

const S = 1e6;
const estimate = (change: Partial<TrackEstimate>): TrackEstimate => ({
  track: 7, name: '', class: 'bird', classes: { bird: 0.7 }, covariance_m2: [9, 0, 0, 4, 0, 1], pinned: false, guessed_range: false, confidence: 0.8, age_s: 5, seen: 50 * S, sensors: ['2/camera'], source: 'fused',
  position: { north_m: 10, east_m: 20, down_m: -30 }, velocity: { north_m_s: 1, east_m_s: 0, down_m_s: 0 }, time: 50 * S, error_m: 3, ...change,
});
const told = (...tracks: TrackEstimate[]): Tracks => {
  const all = new Tracks();
  all.take({ time: 50 * S, tracks }, 1000);
  return all;
};

describe('what is drawn of tracks', () => {
  it('is where each is, how well that is known, and whether it is looked at', () => {
    const tracks = told(estimate({}), estimate({ track: 8, name: 'Ghost', covariance_m2: null }));
    tracks.selected = 8;
    const [first, second] = seenTracks(tracks, 1000);
    expect(first).toMatchObject({ north: 10, east: 20, upM: 30, text: 'Track 7 bird', stale: false, selected: false, ellipse: { longM: 6, shortM: 4 } });
    expect(second).toMatchObject({ text: 'Ghost bird', selected: true, ellipse: null });
  });

  it('looks old when it is, also when nothing more is heard', () => {
    const tracks = told(estimate({}), estimate({ track: 8, time: 46 * S }));
    expect(seenTracks(tracks, 1500).map(({ stale }) => stale)).toEqual([false, true]);
    expect(seenTracks(tracks, 4100).map(({ stale }) => stale)).toEqual([true, true]);
  });

  it('is not kept over a loss of the connection, but for the trails', () => {
    const tracks = told(estimate({}));
    tracks.clear();
    expect([seenTracks(tracks, 2000), tracks.ever]).toEqual([[], true]);
    tracks.take({ time: 51 * S, tracks: [estimate({ time: 51 * S })] }, 3000);
    expect(seenTracks(tracks, 3000)[0]!.trail).toHaveLength(2);
  });
});

describe('a tap', () => {
  it('means the nearest track within reach', () => {
    const view = new View();
    const seen = seenTracks(told(estimate({}), estimate({ track: 8, position: { north_m: 12, east_m: 20, down_m: -30 } })), 1000);
    const [x, y] = [view.x(20), view.y(12)];
    expect(trackAt(view, seen, x, y, 10)).toBe(8);
    expect(trackAt(view, seen, x, view.y(10), 10)).toBe(7);
    expect(trackAt(view, seen, x + 50, y, 10)).toBeNull();
  });
});
