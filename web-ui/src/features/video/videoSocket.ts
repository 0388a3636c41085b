// The socket of one stream: hands on pictures and states, keeps the estimate of the node's clock, notices silence. Must never come back by
// itself: whoever opened it decides when and on which way.

import { KEY_TEXT, pingText, readPicture, readVideoMessage, seenText } from '../../protocol/video';
import type { Picture, VideoStreamView } from '../../protocol/video';
import { t } from '../../language/language.svelte';
import { NodeClock } from './nodeClock';
import type { Delays } from './pictureLog';

const PING_EVERY_MS = 2000;
/** Unanswered pings that are remembered. */
const PINGS_KEPT = 10;
/** The node says the state about once a second: a socket that says nothing for so long is half open. */
const SILENCE_MS = 6000;
/** An attempt that has led to no word in this time is given up. */
const OPEN_MS = 8000;
const WATCH_EVERY_MS = 500;
/** At most twice a second. */
const KEY_EVERY_MS = 500;

export type SocketListener = {
  picture(picture: Picture): void;
  state(view: VideoStreamView): void;
  /** It is over; `refused` if nothing was ever heard. */
  closed(why: string, refused: boolean): void;
};

export class VideoSocket {
  readonly clock = new NodeClock();
  /** Messages that could not be read. */
  unreadable = 0;
  #socket: WebSocket | null;
  #timers: ReturnType<typeof setInterval>[];
  #pings = new Map<number, number>();
  #pingId = 0;
  #heardAt: number | null = null;
  #openedAt = performance.now();
  #askedAt = -Infinity;

  constructor(
    url: string,
    readonly listener: SocketListener,
  ) {
    const socket = new WebSocket(url);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => this.#ping();
    socket.onmessage = ({ data }: { data: string | ArrayBuffer }) => this.#hear(data);
    socket.onclose = ({ reason }) => this.#end(reason || (this.#heardAt === null ? t('the server does not give the stream') : t('the server closed the connection')));
    this.#socket = socket;
    this.#timers = [setInterval(() => this.#ping(), PING_EVERY_MS), setInterval(() => this.#watch(), WATCH_EVERY_MS)];
  }

  /** Asks for a picture that stands alone. */
  askKey(): void {
    const now = performance.now();
    if (now - this.#askedAt < KEY_EVERY_MS) return;
    this.#askedAt = now;
    this.#say(KEY_TEXT);
  }

  /** Tells the node how long it takes from glass to glass. */
  seen({ p50Ms, p99Ms }: Delays): void {
    this.#say(seenText(p50Ms, p99Ms));
  }

  /** Closes it; the listener hears nothing any more. */
  close(): void {
    const socket = this.#socket;
    this.#socket = null;
    for (const timer of this.#timers) clearInterval(timer);
    if (!socket) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
  }

  #say(text: string): void {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(text);
  }

  #ping(): void {
    if (this.#socket?.readyState !== WebSocket.OPEN) return;
    const id = ++this.#pingId;
    this.#pings.set(id, performance.now());
    this.#pings.delete(id - PINGS_KEPT);
    this.#say(pingText(id));
  }

  #hear(data: string | ArrayBuffer): void {
    const now = performance.now();
    this.#heardAt = now;
    if (typeof data !== 'string') {
      const picture = readPicture(data);
      if (picture) this.listener.picture(picture);
      else this.unreadable++;
      return;
    }
    const message = readVideoMessage(data);
    if (message?.type === 'state') this.listener.state(message.view);
    else if (message?.type === 'pong') {
      const sent = this.#pings.get(message.id);
      this.#pings.delete(message.id);
      if (sent !== undefined) this.clock.take(sent, now, message.timeUs);
    } else this.unreadable++;
  }

  #watch(): void {
    const now = performance.now();
    if (this.#heardAt === null ? now - this.#openedAt > OPEN_MS : now - this.#heardAt > SILENCE_MS) this.#end(t('the server has gone silent'));
  }

  #end(why: string): void {
    const refused = this.#heardAt === null;
    this.close();
    this.listener.closed(why, refused);
  }
}
