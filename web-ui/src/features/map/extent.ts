// What there is to be kept in view: vehicles, slots, plans. For the map and for the view in space alike.

import type { Console } from '../../app/console.svelte';
import { FLAG } from '../../protocol/frame';
import type { Route } from '../../protocol/types';
import { include, noBounds } from './view';
import type { Bounds } from './view';

/** The leader's route, or the path that a formation without a leader goes along. */
export function flownRoute(console: Console): Route | null {
  const flown = console.session.info.formation;
  if (!flown) return null;
  return flown.route ?? (flown.request.anchor.kind === 'path' ? flown.request.anchor.route : null);
}

/** What the following camera looks at: the one followed, the selected vehicles, the leader, or all. */
export function followedBounds(console: Console): Bounds {
  const { session, targets, map } = console;
  const { fleet, info } = session;
  const bounds = noBounds();
  const leader = info.formation?.leader ?? null;
  const chosen = targets.selected.size > 0 ? [...targets.selected] : leader !== null ? [leader] : targets.everyone;
  for (const id of map.followed === null ? chosen : [map.followed]) {
    const index = fleet.indexOf(id);
    if (index >= 0 && fleet.has(index, FLAG.position)) include(bounds, fleet.shownNorthM[index] ?? 0, fleet.shownEastM[index] ?? 0);
  }
  return bounds;
}

export function everything(console: Console): Bounds {
  const { session, formation } = console;
  const { fleet, info } = session;
  const bounds = noBounds();
  for (let i = 0; i < fleet.size; i++) {
    if (fleet.present[i] !== 1 || !fleet.has(i, FLAG.position)) continue;
    include(bounds, fleet.shownNorthM[i] ?? 0, fleet.shownEastM[i] ?? 0);
    if (fleet.has(i, FLAG.slot)) include(bounds, fleet.slotNorthM[i] ?? 0, fleet.slotEastM[i] ?? 0);
  }
  if (info.formation && !info.formation.route_finished) {
    for (const w of flownRoute(console)?.waypoints ?? []) include(bounds, w.north_m, w.east_m);
  }
  for (const w of formation.route.waypoints) include(bounds, w.north, w.east);
  for (const slot of formation.previewSlots()) include(bounds, slot.north, slot.east);
  return bounds;
}
