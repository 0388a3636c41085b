// A stream as JPEG over the socket, drawn picture by picture: works in every browser and over plain HTTP, and takes several times as many bytes.
// Must never let pictures pile up: while one is decoded only the newest waits.

import { videoSocketUrl } from '../../protocol/video';
import type { Picture } from '../../protocol/video';
import { draw, takenAt } from './receiver';
import type { Delays } from './pictureLog';
import type { Asked, Receiver } from './receiver';
import { VideoSocket } from './videoSocket';

export class JpegReceiver implements Receiver {
  readonly way = 'jpeg';
  readonly #socket: VideoSocket;
  #waiting: Picture | null = null;
  #busy = false;
  #came = 0;
  #closed = false;

  constructor(readonly asked: Asked) {
    const { of, quality, listener } = asked;
    this.#socket = new VideoSocket(videoSocketUrl(document.baseURI, of, 'jpeg', quality), {
      picture: (picture) => this.#take(picture),
      state: (view) => listener.state(view),
      closed: (why, refused) => {
        this.close();
        listener.ended(why, refused ? 'refused' : 'closed');
      },
    });
  }

  get unreadable(): number {
    return this.#socket.unreadable;
  }

  seen(delays: Delays): void {
    this.#socket.seen(delays);
  }

  nodeMs(pageMs: number): number | null {
    return this.#socket.clock.nodeMs(pageMs);
  }

  close(): void {
    this.#closed = true;
    this.#waiting = null;
    this.#socket.close();
  }

  #take(picture: Picture): void {
    if (picture.kind !== 'jpeg') return;
    this.asked.listener.counted(++this.#came, picture.leftOut);
    this.#waiting = picture;
    if (!this.#busy) void this.#work();
  }

  async #work(): Promise<void> {
    this.#busy = true;
    for (let picture = this.#next(); picture; picture = this.#next()) await this.#show(picture);
    this.#busy = false;
  }

  #next(): Picture | null {
    const picture = this.#waiting;
    this.#waiting = null;
    return picture;
  }

  async #show(picture: Picture): Promise<void> {
    const now = performance.now();
    const nodeNow = this.nodeMs(now);
    const takenMs = takenAt(nodeNow === null ? null : nodeNow - now, picture.timeUs, picture.ageUs, now);
    let bitmap: ImageBitmap;
    try {
      bitmap = await createImageBitmap(new Blob([picture.data], { type: 'image/jpeg' }));
    } catch (error) {
      if (!this.#closed) this.asked.listener.decoderFailed(error instanceof Error ? error.message : String(error));
      return;
    }
    if (!this.#closed) {
      draw(this.asked.screen.canvas, bitmap, bitmap.width, bitmap.height);
      this.asked.listener.shown({ source: bitmap, widthPx: bitmap.width, heightPx: bitmap.height, takenMs });
    }
    bitmap.close();
  }
}
