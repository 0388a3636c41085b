// What the list knows of a vehicle, as the map and the view in space draw it.

import type { Session } from '../../model/session.svelte';
import type { Marking } from './paintFleet';

const CALM: Marking = { level: 0, problem: '', height: '', stopped: false };

export function markingOf(session: Session, index: number): Marking {
  const row = session.rowAt(index);
  if (!row) return CALM;
  const { level } = row;
  // Only what is written is worked out: this is asked for every vehicle of every picture.
  return { level, problem: level >= 2 ? (row.problems.split(' · ', 1)[0] ?? '') : '', height: row.height, stopped: row.stopped };
}
