// Fingers, mouse and keys on the map: drag pans, wheel and pinch zoom, a tap toggles a target, two taps follow it, a box adds many, and in
// route mode a tap sets a waypoint and a drag moves one; the place tool takes one tap, the measuring tool as many as one likes. A tap of the go-to tool,
// or a finger that rests, says where to go. Must never send anything: it changes view, targets and drafts only.

import type { Console } from '../../app/console.svelte';
import type { FenceDraft } from '../../model/fenceDraft.svelte';
import type { RouteDraft } from '../../model/routeDraft.svelte';
import { placeText } from '../../language/units.svelte';
import { toggleMeasuring } from '../measure/measuring';
import { trackAt } from '../observed/paintTracks';
import { hitTest, within } from './paintFleet';
import { waypointAt } from './paintPlan';
import type { Painter } from './painter';

/** A finger that rests for so long on open ground means that place. */
const LONG_PRESS_MS = 550;
/** A pointer that moved less than this has tapped. */
const TAP_PX = 5;
const REACH_MOUSE_PX = 18;
const REACH_TOUCH_PX = 30;
const PAN_KEY_PX = 60;
const DOUBLE_TAP_MS = 400;

type Finger = { x: number; y: number; startX: number; startY: number; moved: boolean };

export class Interaction {
  #fingers = new Map<number, Finger>();
  #mode: 'none' | 'pan' | 'box' | 'waypoint' = 'none';
  #waypoint = -1;
  #resting: ReturnType<typeof setTimeout> | undefined;
  #tapped: { id: number; atMs: number } | null = null;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly console: Console,
    readonly painter: Painter,
  ) {}

  pointerdown = (event: PointerEvent): void => {
    if (event.button !== 0) return;
    this.canvas.setPointerCapture(event.pointerId);
    const { x, y } = this.#place(event);
    this.#fingers.set(event.pointerId, { x, y, startX: x, startY: y, moved: false });
    clearTimeout(this.#resting);
    if (this.#fingers.size > 1) {
      this.#mode = 'pan';
      this.painter.box = null;
      return;
    }
    const { map } = this.console;
    const drawn = this.#drawn();
    this.#waypoint = drawn ? waypointAt(map.view, drawn.waypoints, x, y, this.#reach(event)) : -1;
    if (this.#waypoint >= 0) this.#mode = 'waypoint';
    else this.#mode = map.tool === 'box' || event.shiftKey ? 'box' : 'pan';
    if (event.pointerType === 'touch' && map.tool === 'pan' && !this.console.session.replay.on) this.#resting = setTimeout(() => this.#rest(event.pointerId), LONG_PRESS_MS);
  };

  /** A finger has rested on a place: it means that place and nothing else. */
  #rest(pointer: number): void {
    const finger = this.#fingers.get(pointer);
    const { map, session } = this.console;
    if (!finger || finger.moved || hitTest(map.view, session.fleet, finger.x, finger.y, REACH_TOUCH_PX) >= 0) return;
    this.#fingers.delete(pointer);
    map.tool = 'goto';
    this.#goTo(finger.x, finger.y);
    this.#end();
  }

  #goTo(x: number, y: number): void {
    const { map, goTo } = this.console;
    // A map that moved by itself now would take the next place somewhere else.
    map.camera = 'free';
    goTo.put(this.#ground(x, y));
  }

  pointermove = (event: PointerEvent): void => {
    const { x, y } = this.#place(event);
    this.#showCursor(x, y);
    const finger = this.#fingers.get(event.pointerId);
    if (!finger) return;
    if (!finger.moved && Math.hypot(x - finger.startX, y - finger.startY) < TAP_PX) return;
    finger.moved = true;
    clearTimeout(this.#resting);
    if (this.#fingers.size >= 2) this.#pinch(finger, x, y);
    else if (this.#mode === 'pan') this.#pan(x - finger.x, y - finger.y);
    else if (this.#mode === 'box') this.painter.box = { x0: finger.startX, y0: finger.startY, x1: x, y1: y };
    else if (this.#mode === 'waypoint') this.#drawn()?.move(this.#waypoint, this.#ground(x, y));
    finger.x = x;
    finger.y = y;
    this.painter.wake();
  };

  pointerup = (event: PointerEvent): void => {
    const finger = this.#fingers.get(event.pointerId);
    this.#fingers.delete(event.pointerId);
    clearTimeout(this.#resting);
    if (!finger || this.#fingers.size > 0) return;
    const { map, session, targets, formation } = this.console;
    if (this.#mode === 'box' && finger.moved) {
      targets.add(within(map.view, session.fleet, finger.startX, finger.startY, finger.x, finger.y));
    } else if (!finger.moved && (map.tool === 'route' || map.tool === 'path' || map.tool === 'fence')) {
      // A map that moved by itself now would take the next point somewhere else.
      map.camera = 'free';
      if (this.#mode !== 'waypoint') this.#drawn()?.add(this.#ground(finger.x, finger.y));
      if (map.tool === 'path') formation.preview = true;
    } else if (!finger.moved && map.tool === 'goto') {
      this.#goTo(finger.x, finger.y);
    } else if (!finger.moved && map.tool === 'place') {
      formation.place = this.#ground(finger.x, finger.y);
      formation.preview = true;
      map.tool = 'pan';
    } else if (!finger.moved) {
      const index = hitTest(map.view, session.fleet, finger.x, finger.y, this.#reach(event));
      const id = index >= 0 ? (session.fleet.ids[index] ?? 0) : null;
      if (map.tool === 'measure') this.#measure(id, finger.x, finger.y);
      else if (id !== null) this.#tap(id, event.timeStamp);
      else this.#look(finger.x, finger.y, this.#reach(event));
    }
    this.#end();
  };

  #measure(id: number | null, x: number, y: number): void {
    const { map } = this.console;
    if (map.camera === 'fleet') map.camera = 'free';
    map.measure.add(id === null ? { kind: 'place', ...this.#ground(x, y) } : { kind: 'vehicle', id });
  }

  /** One tap makes a target of a vehicle or takes it away; two follow it, and leave the targets as they were. */
  #tap(id: number, atMs: number): void {
    const twice = this.#tapped?.id === id && atMs - this.#tapped.atMs < DOUBLE_TAP_MS;
    this.console.targets.toggle(id);
    this.#tapped = twice ? null : { id, atMs };
    if (twice) this.console.map.follow(id);
  }

  /** A track that is tapped is looked at. */
  #look(x: number, y: number, reachPx: number): void {
    const { map, tracks, navigation } = this.console;
    const track = map.layers.tracks ? trackAt(map.view, this.painter.tracksSeen(), x, y, reachPx) : null;
    if (track === null) return;
    tracks.selected = track;
    navigation.showPlan('tracks');
  }

  pointercancel = (event: PointerEvent): void => {
    clearTimeout(this.#resting);
    this.#fingers.delete(event.pointerId);
    this.#end();
  };

  pointerleave = (): void => {
    this.console.map.cursor = '';
  };

  wheel = (event: WheelEvent): void => {
    event.preventDefault();
    const { map } = this.console;
    const { x, y } = this.#place(event);
    const unit = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    map.view.zoomAt(x, y, Math.exp(-event.deltaY * unit * 0.0015));
    if (map.camera === 'fleet') map.camera = 'free';
    this.painter.wake();
  };

  keydown = (event: KeyboardEvent): void => {
    const { map, shortcuts } = this.console;
    // The page's: `g m` must not measure.
    if (shortcuts.keys.completes(event.key, performance.now())) return;
    switch (event.key) {
      case 'ArrowLeft':
        this.#pan(PAN_KEY_PX, 0);
        break;
      case 'ArrowRight':
        this.#pan(-PAN_KEY_PX, 0);
        break;
      case 'ArrowUp':
        this.#pan(0, PAN_KEY_PX);
        break;
      case 'ArrowDown':
        this.#pan(0, -PAN_KEY_PX);
        break;
      case '+':
      case '=':
        map.zoom(1.4);
        break;
      case '-':
        map.zoom(1 / 1.4);
        break;
      case 'f':
        map.setCamera('fleet');
        this.painter.fit();
        break;
      case 'm':
        toggleMeasuring(this.console);
        break;
      case 'v':
        map.look = 'space';
        break;
      case 'Backspace':
      case 'Delete': {
        const drawn = this.#drawn();
        if (map.tool === 'measure') map.measure.undo();
        else drawn?.remove(drawn.waypoints.length - 1);
        break;
      }
      default:
        return;
    }
    event.preventDefault();
    this.painter.wake();
  };

  /** The route or outline that the chosen tool draws. */
  #drawn(): RouteDraft | FenceDraft | null {
    const { map, formation, fence } = this.console;
    if (map.tool === 'fence') return fence;
    return map.tool === 'route' ? formation.route : map.tool === 'path' ? formation.path : null;
  }

  #end(): void {
    this.#mode = 'none';
    this.painter.box = null;
    this.painter.wake();
  }

  #pan(dx: number, dy: number): void {
    if (this.console.map.camera !== 'free') this.console.map.setCamera('free');
    this.console.map.view.panBy(dx, dy);
  }

  /** One of two fingers moved to (x, y): the ground under both stays under both. */
  #pinch(moving: Finger, x: number, y: number): void {
    const other = [...this.#fingers.values()].find((f) => f !== moving);
    if (!other) return;
    const before = Math.hypot(moving.x - other.x, moving.y - other.y);
    const after = Math.hypot(x - other.x, y - other.y);
    this.#pan((x - moving.x) / 2, (y - moving.y) / 2);
    if (before > 1) this.console.map.view.zoomAt((x + other.x) / 2, (y + other.y) / 2, after / before);
  }

  #place(event: { offsetX: number; offsetY: number }): { x: number; y: number } {
    return { x: event.offsetX, y: event.offsetY };
  }

  #ground(x: number, y: number): { north: number; east: number } {
    const { view } = this.console.map;
    const tenth = (metres: number) => Math.round(metres * 10) / 10;
    return { north: tenth(view.north(y)), east: tenth(view.east(x)) };
  }

  #reach(event: PointerEvent): number {
    return event.pointerType === 'touch' ? REACH_TOUCH_PX : REACH_MOUSE_PX;
  }

  #showCursor(x: number, y: number): void {
    const { view } = this.console.map;
    const part = (metres: number, positive: string, negative: string) =>
      `${placeText(metres)} ${metres >= 0 ? positive : negative}`;
    this.console.map.cursor = `${part(view.north(y), 'N', 'S')}  ${part(view.east(x), 'E', 'W')}`;
  }
}
