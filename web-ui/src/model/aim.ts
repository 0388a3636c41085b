// Where a gimbal is to point for what a finger does: on the pad, and in the picture of its camera. Pure.

export type Aim = { pitchRad: number; yawRad: number };

/** What the pad covers. The device has limits of its own and keeps to them. */
export const PITCH_RANGE_RAD = [-Math.PI / 2, Math.PI / 6] as const;
export const YAW_RANGE_RAD = [-Math.PI, Math.PI] as const;

const clamp = (value: number, [low, high]: readonly [number, number]): number => Math.min(high, Math.max(low, value));
const bounded = (aim: Aim): Aim => ({ pitchRad: clamp(aim.pitchRad, PITCH_RANGE_RAD), yawRad: clamp(aim.yawRad, YAW_RANGE_RAD) });

/** The place on the pad, 0..1 from its left and from its top. */
export function toPad(aim: Aim): { x: number; y: number } {
  const within = bounded(aim);
  return {
    x: (within.yawRad - YAW_RANGE_RAD[0]) / (YAW_RANGE_RAD[1] - YAW_RANGE_RAD[0]),
    y: (PITCH_RANGE_RAD[1] - within.pitchRad) / (PITCH_RANGE_RAD[1] - PITCH_RANGE_RAD[0]),
  };
}

export function fromPad(x: number, y: number): Aim {
  return bounded({
    pitchRad: PITCH_RANGE_RAD[1] - y * (PITCH_RANGE_RAD[1] - PITCH_RANGE_RAD[0]),
    yawRad: YAW_RANGE_RAD[0] + x * (YAW_RANGE_RAD[1] - YAW_RANGE_RAD[0]),
  });
}

/** An aim moved by so much. */
export function moved(from: Aim, pitchRad: number, yawRad: number): Aim {
  return bounded({ pitchRad: from.pitchRad + pitchRad, yawRad: from.yawRad + yawRad });
}

const KEY_STEP_RAD = (5 * Math.PI) / 180;

/** What the arrow keys turn, up and to the right. */
export const AIM_KEYS: Readonly<Record<string, readonly [pitchRad: number, yawRad: number]>> = {
  ArrowUp: [KEY_STEP_RAD, 0], ArrowDown: [-KEY_STEP_RAD, 0], ArrowLeft: [0, -KEY_STEP_RAD], ArrowRight: [0, KEY_STEP_RAD],
};

export type Picture = { widthPx: number; heightPx: number; fieldOfViewRad: number };

/** The angle at so many pixels from the middle of a picture whose whole width spans the field of view. */
function angleAt(px: number, picture: Picture): number {
  return Math.atan2(px * Math.tan(picture.fieldOfViewRad / 2), picture.widthPx / 2);
}

/** The picture taken hold of at one place and drawn to another: the scene follows the finger. Pixels from the picture's middle. */
export function dragged(from: Aim, grabbed: { x: number; y: number }, now: { x: number; y: number }, picture: Picture): Aim {
  return moved(from, angleAt(now.y, picture) - angleAt(grabbed.y, picture), angleAt(grabbed.x, picture) - angleAt(now.x, picture));
}

/** A place in the picture is to come to its middle. */
export function centred(from: Aim, place: { x: number; y: number }, picture: Picture): Aim {
  return moved(from, -angleAt(place.y, picture), angleAt(place.x, picture));
}

/** Lets through one call in `everyMs`, and always the last. */
export class Throttle {
  #at = -Infinity;
  constructor(readonly everyMs: number) {}

  passes(nowMs: number, last: boolean): boolean {
    if (!last && nowMs - this.#at < this.everyMs) return false;
    this.#at = nowMs;
    return true;
  }
}

/** The command of a gimbal for an aim. */
export function anglesCommand({ pitchRad, yawRad }: Aim): object {
  return { command: 'angles', pitch_rad: pitchRad, yaw_rad: yawRad, yaw_frame: 'vehicle' };
}

const ZOOM_STEP = 1.5;

/** The command of a camera for one step nearer or farther. */
export function zoomCommand(zoom: number, way: 'in' | 'out'): object {
  return { command: 'zoom', factor: way === 'in' ? zoom * ZOOM_STEP : Math.max(1, zoom / ZOOM_STEP) };
}
