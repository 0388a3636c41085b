// `window.__skein`: what is on the canvas, for tests that cannot read pixels. Read-only; nothing of the page depends on it.

import type { Console } from '../../app/console.svelte';
import { FLAG } from '../../protocol/frame';
import { drawnLinks } from './linkTable';
import { QUALITY_WORDS } from './links';
import { hitTest } from './paintFleet';
import type { Painter } from './painter';

export type Plotted = {
  id: number;
  /** CSS pixels on the canvas, carried forward; all else is as the vehicle said it. */
  x: number;
  y: number;
  latitudeDeg: number;
  longitudeDeg: number;
  northM: number;
  eastM: number;
  altitudeM: number;
  slot: { northM: number; eastM: number } | null;
};

export type Hook = {
  /** Telemetry frames taken and map frames drawn. */
  framesTaken(): number;
  framesDrawn(): number;
  /** `performance.now()` when a vehicle was first on the canvas; null before. */
  firstVehicleMs(): number | null;
  /** Tiles of the operator's own base map that were drawn last. */
  baseTiles(): number;
  /** Coasts and borders in the last picture. */
  worldLines(): number;
  positions(): Plotted[];
  trailLength(id: number): number;
  /** Id of the vehicle at a place on the canvas, or null. */
  hitTest(x: number, y: number): number | null;
  /** What is measured: metres and degrees of each leg. */
  measured(): { distanceM: number; bearingDeg: number | null; riseM: number | null }[];
  /** The drawn links: of which vehicle, and how good. */
  links(): { id: number; quality: string; text: string }[];
  /** The ground that cameras are drawn to see, and the tracks that are drawn. */
  groundSeen(): { vehicle: number; payload: string; corners: { north: number; east: number }[]; stale: boolean }[];
  tracksSeen(): { track: number; north: number; east: number; stale: boolean; text: string; pinned: boolean; longM: number | null; spots: number }[];
  /** Vehicles that bear the sign of another operator's control, and whether that one is heard. */
  held(): { id: number; heard: boolean }[];
  /** Zones of the fences that are drawn. */
  zones(): { name: string; kind: string; corners: number }[];
  /** Slots of the previewed formation, in metres about the swarm's origin; up counts from its anchor. */
  previewSlots(): { north: number; east: number; upM: number }[];
  /** Who would go from where to which of them, in metres about the swarm's origin. */
  previewWays(): { from: { north: number; east: number }; to: { north: number; east: number } }[];
  /** Where a place about the swarm's origin is on the canvas. */
  toCanvas(northM: number, eastM: number): { x: number; y: number };
};

declare global {
  interface Window {
    __skein?: Hook;
  }
}

export function installHook(app: Console, painter: Painter): () => void {
  const { fleet } = app.session;
  const { view } = app.map;
  window.__skein = {
    framesTaken: () => fleet.framesTaken,
    framesDrawn: () => painter.frames,
    firstVehicleMs: () => painter.firstVehicleMs,
    baseTiles: () => painter.baseTiles,
    worldLines: () => painter.worldLines,
    trailLength: (id) => fleet.trails.length(fleet.indexOf(id)),
    hitTest: (x, y) => fleet.ids[hitTest(view, fleet, x, y, 20)] ?? null,
    measured: () => painter.measured().map(({ distanceM, bearingDeg, riseM }) => ({ distanceM, bearingDeg, riseM })),
    links: () => drawnLinks(app.session, performance.now()).map(({ id, quality, text }) => ({ id, quality: QUALITY_WORDS[quality], text })),
    groundSeen: () => (app.map.layers.cameras ? painter.groundSeen().map(({ vehicle, payload, corners, stale }) => ({ vehicle, payload, corners, stale })) : []),
    tracksSeen: () => (app.map.layers.tracks ? painter.tracksSeen().map(({ track, north, east, stale, text, pinned, ellipse, trail }) => ({ track, north, east, stale, text, pinned, longM: ellipse?.longM ?? null, spots: trail.length })) : []),
    held: () => [...painter.held()].filter(([id]) => painter.locate(id) !== null).map(([id, kind]) => ({ id, heard: kind === 'heard' })),
    zones: () => painter.fences().zones.map(({ name, kind, corners }) => ({ name, kind, corners: corners.length })),
    previewSlots: () => app.formation.previewSlots(),
    previewWays: () => app.formation.previewWays(),
    toCanvas: (northM, eastM) => ({ x: view.x(eastM), y: view.y(northM) }),
    positions: () => {
      const plotted: Plotted[] = [];
      for (let i = 0; i < fleet.size; i++) {
        if (fleet.present[i] !== 1 || !fleet.has(i, FLAG.position)) continue;
        const [northM, eastM] = [fleet.northM[i] ?? 0, fleet.eastM[i] ?? 0];
        plotted.push({
          id: fleet.ids[i] ?? 0,
          x: view.x(fleet.shownEastM[i] ?? 0),
          y: view.y(fleet.shownNorthM[i] ?? 0),
          latitudeDeg: fleet.latitudeDeg[i] ?? 0,
          longitudeDeg: fleet.longitudeDeg[i] ?? 0,
          northM,
          eastM,
          altitudeM: fleet.altitudeM[i] ?? 0,
          slot: fleet.has(i, FLAG.slot) ? { northM: fleet.slotNorthM[i] ?? 0, eastM: fleet.slotEastM[i] ?? 0 } : null,
        });
      }
      return plotted;
    },
  };
  return () => {
    delete window.__skein;
  };
}
