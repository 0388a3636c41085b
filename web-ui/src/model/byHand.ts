// Flying by hand: what a gamepad, fingers and keys say, how that becomes a stick, and when one may be said. Pure.
// Must never let a stick go while the dead-man is not held, or go on with one that was held before something came between.

/** Where the sticks are, -1 to 1 each: forward, to the right, up, turning clockwise. */
export type Axes = { forward: number; right: number; up: number; turn: number };

export const CENTRED: Axes = { forward: 0, right: 0, up: 0, turn: 0 };

/** As the node is told, in metres and radians per second. */
export type Stick = { forward_m_s: number; right_m_s: number; up_m_s: number; yaw_rate_rad_s: number };

/** Sticks do not come back to the very middle: so much of their way is none. */
export const DEAD_ZONE = 0.12;

/** What is left of one stick beyond its dead zone, from 0 at its edge to 1 at the rim, in the direction it is held. */
export function shaped(x: number, y: number): { x: number; y: number } {
  const away = Math.hypot(x, y);
  if (!Number.isFinite(away) || away <= DEAD_ZONE) return { x: 0, y: 0 };
  const share = (Math.min(away, 1) - DEAD_ZONE) / (1 - DEAD_ZONE) / away;
  return { x: x * share, y: y * share };
}

/** What is read of a gamepad. */
export type PadState = { id: string; connected: boolean; mapping: string; axes: readonly number[]; buttons: readonly { pressed: boolean }[] };

export type PadReading = { name: string; axes: Axes; held: boolean };

/** The button over the right trigger in the standard layout: RB, R1. */
const DEAD_MAN_BUTTON = 5;

/** The left stick climbs and turns, the right one moves, as on a remote control of mode 2. A pad whose layout the browser does not know is
    not read: its axes could be anything. */
export function readPad(pad: PadState): PadReading | null {
  if (!pad.connected || pad.mapping !== 'standard') return null;
  const [leftX = 0, leftY = 0, rightX = 0, rightY = 0] = pad.axes;
  const left = shaped(leftX, leftY);
  const right = shaped(rightX, rightY);
  // Down counts up on a pad.
  const axes = { forward: -right.y, right: right.x, up: -left.y, turn: left.x };
  return { name: padName(pad.id), axes: tidy(axes), held: pad.buttons[DEAD_MAN_BUTTON]?.pressed ?? false };
}

/** The first pad that can be read; if there is none, the name of one that is there and cannot. */
export function firstPad(pads: Iterable<PadState | null>): { reading: PadReading | null; unread: string } {
  let unread = '';
  for (const pad of pads) {
    if (!pad?.connected) continue;
    const reading = readPad(pad);
    if (reading) return { reading, unread: '' };
    unread ||= padName(pad.id);
  }
  return { reading: null, unread };
}

/** A pad's name without the numbers that browsers add. */
export function padName(id: string): string {
  const name = id.replace(/\s*\((?:[^()]*\s)?(?:STANDARD GAMEPAD|Vendor:)[^()]*\)\s*/gi, ' ').replace(/^[0-9a-f]{4}-[0-9a-f]{4}-/i, '').trim();
  return name === '' ? id.trim() : name;
}

/** -0 is 0. */
function tidy({ forward, right, up, turn }: Axes): Axes {
  return { forward: forward + 0, right: right + 0, up: up + 0, turn: turn + 0 };
}

/** How fast whoever steers wants it at most. The vehicle's own limits hold whatever is chosen. */
export const SPEEDS = ['slow', 'medium', 'fast'] as const;
export type Speed = (typeof SPEEDS)[number];
export const LIMITS: Readonly<Record<Speed, { levelMS: number; climbMS: number; turnRadS: number }>> = {
  slow: { levelMS: 1, climbMS: 0.5, turnRadS: 0.3 },
  medium: { levelMS: 3, climbMS: 1.5, turnRadS: 0.5 },
  fast: { levelMS: 8, climbMS: 2.5, turnRadS: 0.8 },
};

export function stickOf({ forward, right, up, turn }: Axes, speed: Speed): Stick {
  const { levelMS, climbMS, turnRadS } = LIMITS[speed];
  return { forward_m_s: forward * levelMS, right_m_s: right * levelMS, up_m_s: up * climbMS, yaw_rate_rad_s: turn * turnRadS };
}

/** A dead-man's grip: it counts from when it is taken while all is well, until it is let go or something comes between. What is still held
    then has to be let go and taken anew. */
export class Grip {
  #is: 'open' | 'closed' | 'spent' = 'open';

  /** Whether it counts now. */
  take(held: boolean, well: boolean): boolean {
    if (!held) this.#is = 'open';
    else if (!well) this.#is = 'spent';
    else if (this.#is === 'open') this.#is = 'closed';
    return this.#is === 'closed';
  }

  /** Something came between, however short: a grip that counted does not any more. */
  break(): void {
    if (this.#is === 'closed') this.#is = 'spent';
  }

  /** It is held, but does not count any more. */
  get spent(): boolean {
    return this.#is === 'spent';
  }
}

/** How the command to be steered stands: not given, under way, in force, over. */
export type Order = 'none' | 'asked' | 'flown' | 'over';

/** What is known at one moment. */
export type Moment = {
  order: Order;
  /** The page is seen and has the focus. */
  attended: boolean;
  /** Frames come in, and of the vehicle they say something. */
  heard: boolean;
  /** The dead-man's grip counts. */
  gripped: boolean;
  /** It is held and does not count. */
  spent: boolean;
};

export type Shown = 'off' | 'asked' | 'away' | 'lost' | 'spent' | 'let go' | 'steering';

/** How it stands, as it is shown. A stick is said in `steering` and at no other time. */
export function shown({ order, attended, heard, gripped, spent }: Moment): Shown {
  if (order === 'none' || order === 'over') return 'off';
  if (!heard) return 'lost';
  if (!attended) return 'away';
  if (order === 'asked') return 'asked';
  if (gripped) return 'steering';
  return spent ? 'spent' : 'let go';
}

/** Whether a grip may be taken and kept. */
export function isWell({ order, attended, heard }: Pick<Moment, 'order' | 'attended' | 'heard'>): boolean {
  return order === 'flown' && attended && heard;
}

/** Keys that move sticks while the dead-man is held by the keyboard: letters the left one, arrows the right one. */
const KEYS: Readonly<Record<string, Partial<Axes>>> = {
  KeyW: { up: 1 }, KeyS: { up: -1 }, KeyA: { turn: -1 }, KeyD: { turn: 1 },
  ArrowUp: { forward: 1 }, ArrowDown: { forward: -1 }, ArrowLeft: { right: -1 }, ArrowRight: { right: 1 },
};

export const isStickKey = (code: string): boolean => Object.hasOwn(KEYS, code);

/** Where keys hold the sticks; two against each other are none. */
export function axesOfKeys(codes: Iterable<string>): Axes {
  const axes = { ...CENTRED };
  for (const code of codes) {
    for (const [axis, by] of Object.entries(isStickKey(code) ? (KEYS[code] ?? {}) : {}) as [keyof Axes, number][]) axes[axis] += by;
  }
  return axes;
}

/** Two authority at once: of each axis what is farther from the middle. */
export function merged(a: Axes, b: Axes): Axes {
  const farther = (x: number, y: number): number => (Math.abs(y) > Math.abs(x) ? y : x);
  return { forward: farther(a.forward, b.forward), right: farther(a.right, b.right), up: farther(a.up, b.up), turn: farther(a.turn, b.turn) };
}
