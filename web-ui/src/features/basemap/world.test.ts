import { describe, expect, it } from 'vitest';
import text from 'world-atlas/countries-50m.json?raw';
import { SwarmProjection } from '../../telemetry/geodesy';
import type { WorldLine } from './world';
import { placeLines } from './worldLines';
import type { WorldTopology } from './worldLines';

const world = JSON.parse(text) as WorldTopology;
const about = (latitude_deg: number, longitude_deg: number) => placeLines(world, new SwarmProjection({ latitude_deg, longitude_deg, altitude_amsl_m: 0 }));

/** Distance from the origin to the nearest point of a kind, in kilometres. */
const nearestKm = (lines: WorldLine[], kind: WorldLine['kind']): number =>
  Math.min(...lines.filter((line) => line.kind === kind).flatMap((line) => [...line.north].map((north, k) => Math.hypot(north, line.east[k]!)))) / 1000;

describe('coasts and borders', () => {
  it('lie where they are on Earth, as near as their scale allows', () => {
    // the cliffs of Dover, and the bridge over the Rhine at Kehl
    expect(nearestKm(about(51.13, 1.33), 'coast')).toBeLessThan(15);
    expect(nearestKm(about(48.57, 7.8), 'border')).toBeLessThan(15);
  });

  it('are told apart: no coast near Zurich, and no border near Dover', () => {
    expect(nearestKm(about(47.4, 8.5), 'coast')).toBeGreaterThan(200);
    expect(nearestKm(about(51.13, 1.33), 'border')).toBeGreaterThan(40);
  });

  it('end where they could never be seen, and know their bounds', () => {
    for (const line of about(47.4, 8.5)) {
      expect(Math.hypot(line.maxNorth, 0)).toBeLessThanOrEqual(4_000_000);
      expect(line.north.length).toBeGreaterThan(1);
      expect([line.minNorth, line.maxEast]).toEqual([Math.min(...line.north), Math.max(...line.east)]);
    }
  });
});
