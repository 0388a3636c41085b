// The one WebSocket: opens it, checks the server's greeting, hands on messages, notices silence, comes back with back-off.
// Must never keep vehicle state: who listens decides what a message means.

import { waitMs } from './backoff';
import { takeEarly } from './early';
import type { Said } from './early';
import type {
  ClientMessage, ErrorDetail, EventRecord, FleetInfo, Refusal, ReplayState, ServerMessage, SwarmSnapshot, TrackList, VehicleControl, VehicleSafety,
} from './types';
import { t } from '../language/language.svelte';

/** The server's greeting. */
export type Hello = Extract<ServerMessage, { type: 'hello' }>;

/** The protocol version this page speaks. */
export const PROTOCOL = 1;
/** Silence after the first binary frame that counts as a lost connection: a half-open socket says nothing. */
const SILENCE_MS = 3000;
/** A stick is not said while so many bytes wait to be sent: it would come late, and the newest one counts. */
const MOST_WAITING_BYTES = 1024;
/** A connection attempt that has not led to a greeting in this time is given up. */
const GREETING_MS = 4000;
const WATCH_EVERY_MS = 250;

/** How a vehicle that is flown by hand is to move. */
export type SaidStick = Omit<Extract<ClientMessage, { type: 'stick' }>, 'type' | 'vehicle'>;

export type StreamState =
  | { name: 'connecting' }
  | { name: 'live'; hello: Hello }
  | { name: 'lost'; retryAt: number; reason: string }
  | { name: 'incompatible'; hello: Hello };

export type StreamListener = {
  state(state: StreamState): void;
  /** `at` is when it came, on the `performance.now()` clock. */
  frame(buffer: ArrayBuffer, at: number): void;
  fleet(info: FleetInfo): void;
  /** Of all vehicles first, then of those of which it has changed. */
  safety(vehicles: readonly VehicleSafety[]): void;
  /** Who has control authority over which vehicles, whole. On a new connection nobody has any until this says so. */
  control(vehicles: readonly VehicleControl[]): void;
  /** What is tracked, whole. On a new connection there is nothing until this says so. */
  tracks(list: TrackList, at: number): void;
  swarm(swarm: SwarmSnapshot): void;
  /** What is shown is a recorded flight, and where in it. On a new connection this is said before anything of vehicles; a node that flies never says it. */
  replay(state: ReplayState): void;
  event(event: EventRecord): void;
  /** A stick was refused. */
  stickRefused(vehicle: number, refusal: Refusal): void;
  /** Events were lost on the way. */
  gap(missed: number): void;
  /** Something came that this page could not read. */
  unreadable(why: string): void;
};

export class Stream {
  #socket: WebSocket | null = null;
  #failures = 0;
  #retryTimer: ReturnType<typeof setTimeout> | undefined;
  #watchTimer: ReturnType<typeof setInterval> | undefined;
  #openedAt = 0;
  #lastFrameAt = 0;
  #greeted = false;
  #rateHz = 0;
  #stopped = false;

  constructor(
    readonly url: string,
    readonly listener: StreamListener,
  ) {}

  start(): void {
    this.#stopped = false;
    this.#watchTimer = setInterval(() => this.#watch(), WATCH_EVERY_MS);
    this.#connect();
  }

  stop(): void {
    this.#stopped = true;
    clearInterval(this.#watchTimer);
    clearTimeout(this.#retryTimer);
    this.#drop();
  }

  /** Frames per second this page wants; kept over reconnections. */
  setRate(rateHz: number): void {
    if (this.#rateHz === rateHz) return;
    this.#rateHz = rateHz;
    this.#sendRate();
  }

  /** Says a stick; whether it went out. None is kept for later. */
  stick(vehicle: number, stick: SaidStick): boolean {
    const socket = this.#socket;
    if (!this.#greeted || socket?.readyState !== WebSocket.OPEN || socket.bufferedAmount > MOST_WAITING_BYTES) return false;
    socket.send(JSON.stringify({ type: 'stick', vehicle, ...stick }));
    return true;
  }

  /** Tries at once instead of waiting for the back-off. */
  retryNow(): void {
    if (this.#socket || this.#stopped) return;
    clearTimeout(this.#retryTimer);
    this.#connect();
  }

  #connect(): void {
    this.listener.state({ name: 'connecting' });
    this.#greeted = false;
    this.#openedAt = performance.now();
    this.#lastFrameAt = 0;
    const early = takeEarly(this.url);
    const socket = early?.socket ?? new WebSocket(this.url);
    socket.binaryType = 'arraybuffer';
    this.#socket = socket;
    const hear = ({ data, at }: Said): void => {
      if (socket === this.#socket) this.#message(data, at);
    };
    socket.onmessage = (message) => hear({ data: message.data as string | ArrayBuffer, at: performance.now() });
    // After who starts the stream is ready to listen, and before anything new is said.
    if (early) queueMicrotask(() => early.said.forEach(hear));
    socket.onclose = () => {
      if (socket === this.#socket) this.#lost(this.#greeted ? t('the server closed the connection') : t('the server does not answer'));
    };
  }

  #message(data: string | ArrayBuffer, at: number): void {
    if (typeof data !== 'string') {
      if (!this.#greeted) return;
      this.#lastFrameAt = at;
      this.listener.frame(data, at);
      return;
    }
    let message: ServerMessage;
    try {
      message = JSON.parse(data) as ServerMessage;
    } catch {
      this.listener.unreadable(t('a text message is not JSON'));
      return;
    }
    switch (message.type) {
      case 'hello':
        this.#hello(message);
        break;
      case 'fleet':
        if (this.#greeted) this.listener.fleet(message);
        break;
      case 'swarm':
        if (this.#greeted) this.listener.swarm(message);
        break;
      case 'replay':
        if (this.#greeted) this.listener.replay(message);
        break;
      case 'safety':
        if (this.#greeted) this.listener.safety(message.vehicles);
        break;
      case 'control':
        if (this.#greeted) this.listener.control(message.vehicles);
        break;
      case 'tracks':
        if (this.#greeted) this.listener.tracks(message, at);
        break;
      case 'event':
        if (this.#greeted) this.listener.event(message);
        break;
      case 'gap':
        this.listener.gap(message.missed);
        break;
      case 'error': {
        const refused = refusedStick(message.error);
        if (refused) this.listener.stickRefused(refused.vehicle, refused.refusal);
        else this.listener.unreadable(t('the server did not understand this page: {why}', { why: message.error.message }));
        break;
      }
      default:
        // A newer server may say more than this page knows; what it does not know does not concern it.
        break;
    }
  }

  #hello(hello: Hello): void {
    if (hello.protocol !== PROTOCOL) {
      this.#stopped = true;
      this.#drop();
      this.listener.state({ name: 'incompatible', hello });
      return;
    }
    this.#greeted = true;
    this.#failures = 0;
    this.#sendRate();
    this.listener.state({ name: 'live', hello });
  }

  #sendRate(): void {
    if (this.#greeted && this.#rateHz > 0 && this.#socket?.readyState === WebSocket.OPEN) {
      this.#socket.send(JSON.stringify({ type: 'rate', rate_hz: this.#rateHz }));
    }
  }

  #watch(): void {
    if (!this.#socket) return;
    const now = performance.now();
    if (!this.#greeted) {
      if (now - this.#openedAt > GREETING_MS) this.#lost('the server does not answer');
    } else if (this.#lastFrameAt > 0 && now - this.#lastFrameAt > SILENCE_MS) {
      this.#lost('the server has gone silent');
    }
  }

  #drop(): void {
    const socket = this.#socket;
    this.#socket = null;
    this.#greeted = false;
    socket?.close();
  }

  #lost(reason: string): void {
    this.#drop();
    if (this.#stopped) return;
    const wait = waitMs(this.#failures++, Math.random());
    this.#retryTimer = setTimeout(() => this.#connect(), wait);
    this.listener.state({ name: 'lost', retryAt: performance.now() + wait, reason });
  }
}

/** What an error says of a stick; null if it is about something else. */
function refusedStick({ detail }: ErrorDetail): { vehicle: number; refusal: Refusal } | null {
  if (typeof detail !== 'object' || detail === null || !('stick' in detail) || !('refusal' in detail)) return null;
  return { vehicle: Number(detail.stick), refusal: detail.refusal as Refusal };
}
