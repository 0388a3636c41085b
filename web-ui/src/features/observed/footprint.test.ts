import { describe, expect, it } from 'vitest';
import { footprint } from './footprint';
import type { Pose } from './footprint';

const RIGHT_ANGLE = Math.PI / 2;
const pose = (change: Partial<Pose>): Pose => ({
  position: { north_m: 0, east_m: 0, down_m: -20 }, roll_rad: 0, pitch_rad: -RIGHT_ANGLE, yaw_rad: 0, field_of_view_rad: RIGHT_ANGLE, ...change,
});
const rounded = (of: Pose) => footprint(of, 640, 320).corners.map(({ north, east }) => [Math.round(north * 100) / 100 + 0, Math.round(east * 100) / 100 + 0]);

describe('footprint', () => {
  it('straight down is the picture itself, its top to where the camera looks', () => {
    expect(rounded(pose({}))).toEqual([[10, -20], [10, 20], [-10, 20], [-10, -20]]);
    expect(rounded(pose({ yaw_rad: RIGHT_ANGLE }))).toEqual([[20, 10], [-20, 10], [-20, -10], [20, -10]]);
    expect(footprint(pose({}), 640, 320).cut).toEqual([false, false, false, false]);
  });

  it('moves with the camera and grows with its height', () => {
    expect(rounded(pose({ position: { north_m: 100, east_m: -50, down_m: -40 } }))).toEqual([[120, -90], [120, -10], [80, -10], [80, -90]]);
  });

  it('aslant is a trapezium that is wider far away', () => {
    const { corners, cut } = footprint(pose({ pitch_rad: -Math.PI / 4 }), 640, 320);
    const [a, b, c, d] = corners.map((corner) => corner!);
    // The axis meets the ground as far ahead as the camera is high; half the picture's height is arctan 0.5 about it.
    expect(a!.north).toBeCloseTo(20 * Math.tan(Math.PI / 4 + Math.atan(0.5)), 6);
    expect(d!.north).toBeCloseTo(20 * Math.tan(Math.PI / 4 - Math.atan(0.5)), 6);
    expect(b!.east - a!.east).toBeGreaterThan(c!.east - d!.east);
    expect(cut).not.toContain(true);
  });

  it('at the horizon ends where the ground is far away, and says on which side', () => {
    const { corners, cut } = footprint(pose({ pitch_rad: 0 }), 640, 320);
    expect(corners).toHaveLength(4);
    expect(cut.filter(Boolean)).toHaveLength(1);
    expect(Math.max(...corners.map((corner) => corner.north))).toBeCloseTo(160, 6);
    // The side that is cut is the far one.
    const k = cut.indexOf(true);
    expect(corners[k]!.north).toBeCloseTo(160, 6);
    expect(corners[(k + 1) % 4]!.north).toBeCloseTo(160, 6);
  });

  it('rolled, one corner can be above the horizon alone', () => {
    const { corners, cut } = footprint(pose({ pitch_rad: -0.45, roll_rad: 0.35 }), 640, 320);
    expect(corners).toHaveLength(5);
    expect(cut.filter(Boolean)).toHaveLength(1);
    // Rolled to the right: the picture's left side looks up, so it is there that the ground ends.
    expect(corners[cut.indexOf(true)]!.east).toBeLessThan(0);
  });

  it.each<[string, Partial<Pose>]>([
    ['looking up', { pitch_rad: 1 }],
    ['on the ground', { position: { north_m: 0, east_m: 0, down_m: 0 } }],
    ['below the origin', { position: { north_m: 0, east_m: 0, down_m: 5 } }],
    ['no field of view', { field_of_view_rad: 0 }],
    ['no number', { field_of_view_rad: NaN }],
  ])('%s sees nothing that could be drawn', (_, change) => {
    expect(footprint(pose(change), 640, 480).corners).toEqual([]);
  });

  it('a picture without a size sees nothing', () => {
    expect(footprint(pose({}), 0, 480).corners).toEqual([]);
  });
});
