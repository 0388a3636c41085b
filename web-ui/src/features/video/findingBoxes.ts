// Where the boxes of what a detector has found lie over a picture as it is shown, and what stands at them. Pure. Must never place a box by a size that the
// detector has not said.

import type { DetectorState, Finding, PayloadSnapshot } from '../../protocol/types';
import { spoken } from '../../protocol/words';

/** What was found longer ago is not drawn: the picture has gone on. */
export const OLDEST_MS = 1000;

export type Room = { width: number; height: number };
export type Box = { x: number; y: number; w: number; h: number; text: string; coasted: boolean };

/** A picture in its own proportions in the middle of the room it is shown in: pixels of the room per pixel of the picture, and where it begins. */
export function fitted(picture: Room, room: Room): { scale: number; x: number; y: number } {
  const scale = Math.min(room.width / picture.width, room.height / picture.height);
  return { scale, x: (room.width - picture.width * scale) / 2, y: (room.height - picture.height * scale) / 2 };
}

/** What detectors of a vehicle say of a camera's picture now; a detector that names no camera means the only one. */
export function statesOf(payloads: readonly PayloadSnapshot[], camera: string, nowMs: number): DetectorState[] {
  const cameras = payloads.filter((one) => one.kind === 'camera').length;
  return payloads
    .filter((one) => one.kind === 'detector' && isState(one.state))
    .map((one) => one.state as DetectorState)
    .filter((state) => (state.camera === camera || (state.camera === '' && cameras === 1)) && nowMs - state.time / 1000 <= OLDEST_MS);
}

function isState(state: unknown): boolean {
  return typeof state === 'object' && state !== null && 'findings' in state && Array.isArray(state.findings) && 'time' in state;
}

/** `bird 87 % 12`: class, how sure, and the name by which it is followed. */
export function findingText({ class: word, score, id }: Finding): string {
  return [spoken(word), `${Math.round(score * 100)} %`, id].filter((part) => part !== '').join(' ');
}

/** The boxes of one detector in a room that shows the picture; one that is followed beyond its edge is not in it. */
export function boxesIn(state: DetectorState, room: Room): Box[] {
  if (!(state.width_px > 0 && state.height_px > 0 && room.width > 0 && room.height > 0)) return [];
  const { scale, x, y } = fitted({ width: state.width_px, height: state.height_px }, room);
  const isInside = (middle: number, size: number, whole: number): boolean => middle + size / 2 > 0 && middle - size / 2 < whole;
  const inside = state.findings.filter(
    ({ center_x_px, center_y_px, width_px, height_px }) => isInside(center_x_px, width_px, state.width_px) && isInside(center_y_px, height_px, state.height_px),
  );
  return inside.map((finding) => ({
    x: x + (finding.center_x_px - finding.width_px / 2) * scale,
    y: y + (finding.center_y_px - finding.height_px / 2) * scale,
    w: finding.width_px * scale,
    h: finding.height_px * scale,
    text: findingText(finding),
    coasted: finding.coasted_s > 0,
  }));
}
