// Fences as the map and the list show them: outlines in metres about the swarm's origin, names and bands in words.
// Must never decide who may be where: that is the gate's. Pure.

import type { FencePlan, FenceZone, Geodetic, ZoneKind } from '../protocol/types';
import { SwarmProjection } from '../telemetry/geodesy';
import { quantity } from './vehicleSafety';
import { t } from '../language/language.svelte';
import { shown } from '../language/units.svelte';

type Place = { north: number; east: number };

export type PlacedZone = {
  name: string;
  kind: ZoneKind;
  /** What the map writes beside it. */
  text: string;
  corners: readonly Place[];
  /** Metres above the swarm's origin; null where the zone has no such limit. */
  floorM: number | null;
  ceilingM: number | null;
};

export type PlacedFences = { zones: readonly PlacedZone[]; breachReturn: Place | null };

/** Corners of a circle as it is drawn. */
const CIRCLE_CORNERS = 64;

export function bandText(zone: FenceZone): string {
  const above = zone.altitude_reference === 'amsl' ? ' AMSL' : '';
  const { floor_m: floor, ceiling_m: ceiling } = zone;
  if (floor === null && ceiling === null) return t('all heights');
  if (floor === null) return t('up to {height}', { height: `${quantity(ceiling, 'm')}${above}` });
  if (ceiling === null) return t('from {height}', { height: `${quantity(floor, 'm')}${above}` });
  return t('{floor} to {ceiling}', { floor: quantity(shown('height', floor), ''), ceiling: `${quantity(ceiling, 'm')}${above}` });
}

export function kindText(kind: ZoneKind): string {
  return kind === 'inclusion' ? t('stay inside') : t('keep out');
}

/** Where the zones are; those in degrees need the swarm's origin and are left out as long as it is not known. */
export function placeFences(plan: FencePlan, origin: Geodetic | null): PlacedFences {
  const projection = origin ? new SwarmProjection(origin) : null;
  const placed = (latitude: number, longitude: number): Place | null => {
    if (!projection) return null;
    const { north, east } = projection.project(latitude, longitude);
    return { north, east };
  };
  const zones: PlacedZone[] = [];
  for (const zone of plan.zones) {
    const corners = cornersOf(zone, placed);
    if (corners.length < 3) continue;
    const text = `${zone.name}: ${kindText(zone.kind)}, ${bandText(zone)}`;
    const above = (limitM: number | null) => aboveOrigin(zone, limitM, origin);
    zones.push({ name: zone.name, kind: zone.kind, text, corners, floorM: above(zone.floor_m), ceilingM: above(zone.ceiling_m) });
  }
  const back = plan.breach_return?.place;
  return { zones, breachReturn: back ? placed(back.latitude_deg, back.longitude_deg) : null };
}

/** A limit counted from the swarm's origin; one above the sea cannot be, as long as the origin is not known. */
function aboveOrigin(zone: FenceZone, limitM: number | null, origin: Geodetic | null): number | null {
  if (limitM === null || zone.altitude_reference === 'origin') return limitM;
  return origin ? limitM - origin.altitude_amsl_m : null;
}

function cornersOf(zone: FenceZone, placed: (latitude: number, longitude: number) => Place | null): Place[] {
  const outline = zone.outline;
  switch (outline.shape) {
    case 'polygon':
      return outline.corners.map((c) => placed(c.latitude_deg, c.longitude_deg)).filter((c) => c !== null);
    case 'local_polygon':
      return outline.corners_m.map(([north, east]) => ({ north, east }));
    case 'circle': {
      const centre = placed(outline.centre.latitude_deg, outline.centre.longitude_deg);
      return centre ? circle(centre, outline.radius_m) : [];
    }
    case 'local_circle':
      return circle({ north: outline.centre_m[0], east: outline.centre_m[1] }, outline.radius_m);
  }
}

function circle(centre: Place, radius: number): Place[] {
  return Array.from({ length: CIRCLE_CORNERS }, (_, k) => {
    const angle = (2 * Math.PI * k) / CIRCLE_CORNERS;
    return { north: centre.north + radius * Math.cos(angle), east: centre.east + radius * Math.sin(angle) };
  });
}
