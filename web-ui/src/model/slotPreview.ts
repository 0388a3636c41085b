// Where the slots of a formation would be, for pictures only: the same outlines as the server lays out, leader first.
// What is flown, who gets which slot and whether it is safe is the server's to say. Pure.

import type { Shape } from '../protocol/types';

/** Metres forward, right and up of the leader. */
export type SlotOffset = { forward: number; right: number; up: number };

export const SHAPES: readonly Shape[] = ['line', 'column', 'wedge', 'circle', 'grid'];

export function slotOffsets(shape: Shape, count: number, spacing: number, altitudeStep: number): SlotOffset[] {
  return Array.from({ length: count }, (_, k) => ({ ...planar(shape, k, count, spacing), up: k * altitudeStep }));
}

function planar(shape: Shape, k: number, count: number, spacing: number): { forward: number; right: number } {
  switch (shape) {
    case 'line':
      return { forward: 0, right: alternating(k) * spacing };
    case 'column':
      return { forward: -k * spacing, right: 0 };
    case 'wedge': {
      const right = alternating(k) * spacing * Math.SQRT1_2;
      return { forward: -Math.abs(right), right };
    }
    case 'circle': {
      if (count === 1) return { forward: 0, right: 0 };
      const radius = spacing / (2 * Math.sin(Math.PI / count));
      const angle = (2 * Math.PI * k) / count;
      return { forward: radius * (Math.cos(angle) - 1), right: radius * Math.sin(angle) };
    }
    case 'grid': {
      const columns = Math.ceil(Math.sqrt(count));
      return { forward: -Math.floor(k / columns) * spacing, right: alternating(k % columns) * spacing };
    }
  }
}

/** 0, 1, -1, 2, -2, …: a row filled from its middle outwards, right side first. */
function alternating(k: number): number {
  const step = Math.ceil(k / 2);
  return k % 2 === 1 ? step : -step;
}

/** An offset turned to a heading (radians clockwise from north): metres north and east. */
export function turned(offset: SlotOffset, heading: number): { north: number; east: number } {
  const sin = Math.sin(heading);
  const cos = Math.cos(heading);
  return { north: offset.forward * cos - offset.right * sin, east: offset.forward * sin + offset.right * cos };
}
