// From the topology of the world to lines in metres about the swarm's origin. Fetched together with the topology; holds nothing. Pure.

import { mesh } from 'topojson-client';
import type { GeometryCollection, Topology } from 'topojson-specification';
import type { SwarmProjection } from '../../telemetry/geodesy';
import type { WorldLine } from './world';

export type WorldTopology = Topology<{ countries: GeometryCollection }>;

/** What is farther from the origin than this is never in view. */
const FARTHEST_M = 4_000_000;

/** The lines near the origin. One that goes far away is cut there. */
export function placeLines(topology: WorldTopology, projection: SwarmProjection): WorldLine[] {
  const { countries } = topology.objects;
  const coasts = mesh(topology, countries, (a, b) => a === b);
  const borders = mesh(topology, countries, (a, b) => a !== b);
  return [
    ...coasts.coordinates.flatMap((line) => pieces('coast', line, projection)),
    ...borders.coordinates.flatMap((line) => pieces('border', line, projection)),
  ];
}

function pieces(kind: WorldLine['kind'], degrees: readonly (readonly number[])[], projection: SwarmProjection): WorldLine[] {
  const lines: WorldLine[] = [];
  let [north, east]: [number[], number[]] = [[], []];
  const cut = (): void => {
    if (north.length > 1) {
      const least = (values: number[]): number => values.reduce((a, b) => Math.min(a, b), Infinity);
      const most = (values: number[]): number => values.reduce((a, b) => Math.max(a, b), -Infinity);
      lines.push({
        kind, north: Float64Array.from(north), east: Float64Array.from(east),
        minNorth: least(north), maxNorth: most(north), minEast: least(east), maxEast: most(east),
      });
    }
    [north, east] = [[], []];
  };
  for (const [longitude = 0, latitude = 0] of degrees) {
    const at = projection.project(latitude, longitude);
    if (Math.hypot(at.north, at.east) > FARTHEST_M) {
      cut();
      continue;
    }
    north.push(at.north);
    east.push(at.east);
  }
  cut();
  return lines;
}
