// The links of all vehicles as they are now, from the live arrays and from what the nodes know of each other.

import type { Session } from '../../model/session.svelte';
import { FLAG } from '../../protocol/frame';
import { classify } from '../../telemetry/staleness';
import { faultText, qualityOf } from './links';
import type { DrawnLink } from './paintLinks';

export function drawnLinks(session: Session, now: number): (DrawnLink & { id: number; altitudeM: number })[] {
  const { fleet, swarm } = session;
  const roundTripOf = new Map(swarm?.nodes.map((node) => [node.node, (node.round_trip_s ?? NaN) * 1000]));
  const links: (DrawnLink & { id: number; altitudeM: number })[] = [];
  for (let i = 0; i < fleet.size; i++) {
    if (fleet.present[i] !== 1 || !fleet.has(i, FLAG.position)) continue;
    const id = fleet.ids[i] ?? 0;
    const node = session.infoOf(id)?.node ?? null;
    const condition = {
      staleness: classify(fleet.ageMs(i, now), fleet.has(i, FLAG.connected)),
      lossPercent: fleet.lossPercent[i] ?? 0,
      roundTripMs: fleet.roundTripMs[i] ?? NaN,
      nodeRoundTripMs: node === null ? NaN : (roundTripOf.get(node) ?? NaN),
    };
    links.push({
      id, north: fleet.shownNorthM[i] ?? 0, east: fleet.shownEastM[i] ?? 0, altitudeM: fleet.shownAltitudeM[i] ?? 0,
      quality: qualityOf(condition), text: faultText(condition),
    });
  }
  return links;
}
