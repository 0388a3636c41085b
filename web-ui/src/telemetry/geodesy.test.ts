// The projection: against distances known from the sphere, and against itself backwards.

import { describe, expect, it } from 'vitest';
import { EARTH_RADIUS_M, SwarmProjection } from './geodesy';

const ZURICH = { latitude_deg: 47.397742, longitude_deg: 8.545594, altitude_amsl_m: 488 };

describe('project', () => {
  it('the origin is zero', () => {
    const p = new SwarmProjection(ZURICH).project(ZURICH.latitude_deg, ZURICH.longitude_deg);
    expect([p.north, p.east]).toEqual([0, 0]);
  });

  it('a hundredth of a degree north is a ten-thousandth of the way round, over 3.6', () => {
    const p = new SwarmProjection(ZURICH).project(ZURICH.latitude_deg + 0.01, ZURICH.longitude_deg);
    expect(p.north).toBeCloseTo((EARTH_RADIUS_M * 0.01 * Math.PI) / 180, 3);
    expect(p.east).toBeCloseTo(0, 6);
  });

  it('east shrinks with the cosine of the latitude', () => {
    const p = new SwarmProjection(ZURICH).project(ZURICH.latitude_deg, ZURICH.longitude_deg + 0.001);
    const expected = ((EARTH_RADIUS_M * 0.001 * Math.PI) / 180) * Math.cos((ZURICH.latitude_deg * Math.PI) / 180);
    expect(p.east).toBeCloseTo(expected, 4);
  });

  it('distances from the origin are those on the sphere, also far away', () => {
    const p = new SwarmProjection({ latitude_deg: 0, longitude_deg: 0, altitude_amsl_m: 0 }).project(0, 30);
    expect(p.east).toBeCloseTo((EARTH_RADIUS_M * Math.PI) / 6, 3);
  });
});

describe('unproject', () => {
  it.each([
    [0, 0],
    [0.5, -0.25],
    [-4200, 3100],
    [50_000, -20_000],
  ])('%d m north, %d m east and back is within a tenth of a millimetre', (north, east) => {
    const projection = new SwarmProjection(ZURICH);
    const { latitudeDeg, longitudeDeg } = projection.unproject(north, east);
    const back = projection.project(latitudeDeg, longitudeDeg);
    expect(back.north).toBeCloseTo(north, 4);
    expect(back.east).toBeCloseTo(east, 4);
  });
});
