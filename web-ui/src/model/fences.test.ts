import { describe, expect, it } from 'vitest';
import type { FencePlan, FenceZone } from '../protocol/types';
import { SwarmProjection } from '../telemetry/geodesy';
import { bandText, placeFences } from './fences';

const ORIGIN = { latitude_deg: 47.4, longitude_deg: 8.5, altitude_amsl_m: 488 };
const ZONE: FenceZone = {
  name: 'field', kind: 'inclusion', outline: { shape: 'local_polygon', corners_m: [[0, 0], [0, 10], [20, 10]] },
  floor_m: null, ceiling_m: 60, altitude_reference: 'origin', action: 'hold',
};
const plan = (...zones: FenceZone[]): FencePlan => ({ zones, breach_return: null });

describe('bandText', () => {
  it('says floor, ceiling and what they count from', () => {
    expect(bandText(ZONE)).toBe('up to 60 m');
    expect(bandText({ ...ZONE, floor_m: 0 })).toBe('0 to 60 m');
    expect(bandText({ ...ZONE, floor_m: 500, ceiling_m: null, altitude_reference: 'amsl' })).toBe('from 500 m AMSL');
    expect(bandText({ ...ZONE, ceiling_m: null })).toBe('all heights');
  });
});

describe('placeFences', () => {
  it('local zones need no origin, zones in degrees wait for it', () => {
    const degrees: FenceZone = { ...ZONE, outline: { shape: 'circle', centre: { latitude_deg: 47.4, longitude_deg: 8.5 }, radius_m: 30 } };
    expect(placeFences(plan(ZONE, degrees), null).zones.map((z) => z.corners.length)).toEqual([3]);
    const [, circle] = placeFences(plan(ZONE, degrees), ORIGIN).zones;
    for (const { north, east } of circle!.corners) expect(Math.hypot(north, east)).toBeCloseTo(30, 6);
  });

  it('degrees come out where the projection of the swarm puts them', () => {
    const at = new SwarmProjection(ORIGIN).unproject(50, -20);
    const corner = { latitude_deg: at.latitudeDeg, longitude_deg: at.longitudeDeg };
    const outline = { shape: 'polygon' as const, corners: [corner, corner, corner] };
    const { zones, breachReturn } = placeFences({ zones: [{ ...ZONE, outline }], breach_return: { place: corner, height_m: null } }, ORIGIN);
    expect(zones[0]!.corners[0]!.north).toBeCloseTo(50, 4);
    expect(zones[0]!.corners[0]!.east).toBeCloseTo(-20, 4);
    expect(breachReturn!.east).toBeCloseTo(-20, 4);
  });

  it('heights above the sea come out above the origin', () => {
    const amsl: FenceZone = { ...ZONE, floor_m: 498, ceiling_m: null, altitude_reference: 'amsl' };
    const { zones } = placeFences(plan(ZONE, amsl), ORIGIN);
    expect(zones.map((z) => [z.floorM, z.ceilingM])).toEqual([[null, 60], [10, null]]);
    expect(placeFences(plan(amsl), null).zones[0]!.floorM).toBeNull();
  });

  it('the text on the map says name, kind and band', () => {
    expect(placeFences(plan({ ...ZONE, kind: 'exclusion' }), ORIGIN).zones[0]!.text).toBe('field: keep out, up to 60 m');
  });
});
