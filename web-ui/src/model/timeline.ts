// What happened in a recording, as a timeline shows it: marks that would lie over each other put together, and the next one from a moment on. Pure.

import type { Severity, TimelineMark } from '../protocol/types';
import { SEVERITY_RANK } from './eventLog';

/** Marks that are shown as one. */
export type Cluster = {
  /** Where its first is, in pixels from the beginning. */
  at: number;
  /** By their time. */
  marks: readonly TimelineMark[];
  worst: Severity;
};

/** Somebody did it: an operator or a program. */
export const isDone = (mark: TimelineMark): boolean => mark.who !== null;

/** The marks, by their time, on a line of `width` pixels; those nearer than `apart` to the first of a cluster are in it. */
export function clustersOf(marks: readonly TimelineMark[], durationS: number, width: number, apart: number): Cluster[] {
  const clusters: { at: number; marks: TimelineMark[]; worst: Severity }[] = [];
  for (const mark of marks) {
    const at = durationS > 0 ? Math.min(1, Math.max(0, mark.position_s / durationS)) * width : 0;
    const last = clusters.at(-1);
    if (!last || at - last.at >= apart) {
      clusters.push({ at, marks: [mark], worst: mark.severity });
      continue;
    }
    last.marks.push(mark);
    if (SEVERITY_RANK[mark.severity] > SEVERITY_RANK[last.worst]) last.worst = mark.severity;
  }
  return clusters;
}

/** A mark this near is the one that is stood at. */
const HERE_S = 0.3;

/** The first mark after a moment. */
export function markAfter(marks: readonly TimelineMark[], positionS: number): TimelineMark | undefined {
  return marks.find((mark) => mark.position_s > positionS + HERE_S);
}

/** The last mark before a moment; `slackS` of those just before it do not count, so that one gets past a mark while the recording goes on. */
export function markBefore(marks: readonly TimelineMark[], positionS: number, slackS = HERE_S): TimelineMark | undefined {
  return marks.findLast((mark) => mark.position_s < positionS - Math.max(HERE_S, slackS));
}

/** The last mark up to a moment, if it is not longer ago than `withinS`: what has just happened. */
export function markAt(marks: readonly TimelineMark[], positionS: number, withinS: number): TimelineMark | undefined {
  const last = marks.findLast((mark) => mark.position_s <= positionS);
  return last && positionS - last.position_s <= withinS ? last : undefined;
}
