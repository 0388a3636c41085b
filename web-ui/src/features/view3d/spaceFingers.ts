// Fingers, mouse and keys on the view in space: a drag turns it, a drag with Shift, the right button or two fingers moves it, wheel and
// pinch zoom, a tap toggles a target and two taps follow it. Must never send anything: it changes camera and targets only.

import type { Console } from '../../app/console.svelte';
import type { Space } from './space';

const TAP_PX = 5;
const DOUBLE_TAP_MS = 400;
const REACH_PX = { mouse: 18, touch: 30 } as const;
const TURN_PER_PX = 0.006;
const TURN_KEY = Math.PI / 18;
const PAN_KEY_PX = 60;

type Finger = { x: number; y: number; startX: number; startY: number; moved: boolean; pans: boolean };

export class SpaceFingers {
  #fingers = new Map<number, Finger>();
  #tapped: { id: number; atMs: number } | null = null;

  constructor(
    readonly element: HTMLElement,
    readonly console: Console,
    readonly space: Space,
  ) {}

  pointerdown = (event: PointerEvent): void => {
    if (event.button !== 0 && event.button !== 2) return;
    this.element.setPointerCapture(event.pointerId);
    const { offsetX: x, offsetY: y } = event;
    this.#fingers.set(event.pointerId, { x, y, startX: x, startY: y, moved: false, pans: event.button === 2 || event.shiftKey });
  };

  pointermove = (event: PointerEvent): void => {
    const finger = this.#fingers.get(event.pointerId);
    if (!finger) return;
    const { offsetX: x, offsetY: y } = event;
    if (!finger.moved && Math.hypot(x - finger.startX, y - finger.startY) < TAP_PX) return;
    finger.moved = true;
    const [dx, dy] = [x - finger.x, y - finger.y];
    if (this.#fingers.size >= 2) this.#pinch(finger, x, y);
    else if (finger.pans) this.space.pan(dx, dy);
    else this.space.turn(dx * TURN_PER_PX, dy * TURN_PER_PX);
    finger.x = x;
    finger.y = y;
  };

  pointerup = (event: PointerEvent): void => {
    const finger = this.#fingers.get(event.pointerId);
    this.#fingers.delete(event.pointerId);
    if (!finger || finger.moved || finger.pans || this.#fingers.size > 0) return;
    const reach = event.pointerType === 'touch' ? REACH_PX.touch : REACH_PX.mouse;
    const index = this.space.hitTest(finger.x, finger.y, reach);
    if (index < 0) return this.#look(finger, reach);
    const id = this.console.session.fleet.ids[index] ?? 0;
    const twice = this.#tapped?.id === id && event.timeStamp - this.#tapped.atMs < DOUBLE_TAP_MS;
    this.console.targets.toggle(id);
    this.#tapped = twice ? null : { id, atMs: event.timeStamp };
    if (twice) this.console.map.follow(id);
  };

  /** A track that is tapped is looked at. */
  #look({ x, y }: Finger, reachPx: number): void {
    const { map, tracks, navigation } = this.console;
    const track = map.layers.tracks ? this.space.trackAt(x, y, reachPx) : null;
    if (track === null) return;
    tracks.selected = track;
    navigation.showPlan('tracks');
  }

  pointercancel = (event: PointerEvent): void => {
    this.#fingers.delete(event.pointerId);
  };

  wheel = (event: WheelEvent): void => {
    event.preventDefault();
    const unit = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    this.space.zoom(Math.exp(-event.deltaY * unit * 0.0015));
  };

  keydown = (event: KeyboardEvent): void => {
    const { map, shortcuts } = this.console;
    // The page's: `g f` must not turn the view.
    if (shortcuts.keys.completes(event.key, performance.now())) return;
    const move = MOVES[event.key];
    if (move && event.shiftKey) this.space.pan(-move[0] * PAN_KEY_PX, -move[1] * PAN_KEY_PX);
    else if (move) this.space.turn(move[0] * TURN_KEY, -move[1] * TURN_KEY);
    else if (event.key === '+' || event.key === '=') this.space.zoom(1.4);
    else if (event.key === '-') this.space.zoom(1 / 1.4);
    else if (event.key === 'f') {
      map.setCamera('fleet');
      this.space.fit();
    } else if (event.key === 'v') map.look = 'flat';
    else return;
    event.preventDefault();
  };

  /** One of two fingers moved to (x, y). */
  #pinch(moving: Finger, x: number, y: number): void {
    const other = [...this.#fingers.values()].find((f) => f !== moving);
    if (!other) return;
    const before = Math.hypot(moving.x - other.x, moving.y - other.y);
    const after = Math.hypot(x - other.x, y - other.y);
    this.space.pan((x - moving.x) / 2, (y - moving.y) / 2);
    if (before > 1) this.space.zoom(after / before);
  }
}

/** Right and down, by key. */
const MOVES: Record<string, readonly [number, number] | undefined> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};
