// A stream as H.264 over the socket, decoded with WebCodecs and drawn at once: the least delay. Only over HTTPS or on the node's own computer.
// Must never keep a decoded picture: the decoder has few of them.

import { videoSocketUrl } from '../../protocol/video';
import type { Picture } from '../../protocol/video';
import { DecoderGate, codecOf } from './h264';
import { draw, takenAt } from './receiver';
import type { Delays } from './pictureLog';
import type { Asked, Receiver } from './receiver';
import { VideoSocket } from './videoSocket';

/** Pictures in the decoder of which it is still known when they were taken. */
const KEPT = 64;

export class WebcodecsReceiver implements Receiver {
  readonly way = 'webcodecs';
  readonly #socket: VideoSocket;
  readonly #gate = new DecoderGate();
  #decoder: VideoDecoder | null = null;
  /** What the decoder is set up for. */
  #setUp = '';
  /** As the node says it; what a picture says itself is always right. */
  #saidCodec = '';
  /** When pictures in the decoder were taken, by their stamp. */
  #taken = new Map<number, number>();
  #came = 0;
  #closed = false;

  constructor(readonly asked: Asked) {
    const { of, quality, listener } = asked;
    this.#socket = new VideoSocket(videoSocketUrl(document.baseURI, of, 'h264', quality), {
      picture: (picture) => this.#take(picture),
      state: (view) => {
        this.#saidCodec = view.codec;
        listener.state(view);
      },
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
    this.#socket.close();
    this.#drop();
  }

  #take(picture: Picture): void {
    if (picture.kind !== 'h264') return;
    this.asked.listener.counted(++this.#came, picture.leftOut);
    if (picture.key) this.#configure(picture);
    if (this.#gate.take(picture, this.#decoder?.decodeQueueSize ?? 0) === 'ask' || !this.#decoder) {
      this.#socket.askKey();
      return;
    }
    const now = performance.now();
    const nodeNow = this.nodeMs(now);
    const stamp = Math.round(picture.timeUs);
    this.#taken.set(stamp, takenAt(nodeNow === null ? null : nodeNow - now, picture.timeUs, picture.ageUs, now));
    if (this.#taken.size > KEPT) this.#taken.delete(this.#taken.keys().next().value ?? 0);
    try {
      this.#decoder.decode(new EncodedVideoChunk({ type: picture.key ? 'key' : 'delta', timestamp: stamp, data: picture.data }));
    } catch (error) {
      this.#failed(error);
    }
  }

  /** Sets the decoder up for a picture that stands alone, if it is another than before. */
  #configure(picture: Picture): void {
    const codec = codecOf(picture.data) ?? this.#saidCodec;
    const wanted = `${codec} ${picture.widthPx} ${picture.heightPx}`;
    if (codec === '' || (this.#decoder && wanted === this.#setUp)) return;
    this.#drop();
    const decoder = new VideoDecoder({
      output: (frame) => this.#show(decoder, frame),
      error: (error) => {
        if (decoder === this.#decoder) this.#failed(error);
      },
    });
    this.#decoder = decoder;
    this.#setUp = wanted;
    try {
      // Without a description: the parameter sets come with the pictures.
      decoder.configure({ codec, codedWidth: picture.widthPx, codedHeight: picture.heightPx, optimizeForLatency: true });
    } catch (error) {
      this.#failed(error);
    }
  }

  #show(decoder: VideoDecoder, frame: VideoFrame): void {
    try {
      if (decoder !== this.#decoder || this.#closed) return;
      const [widthPx, heightPx] = [frame.displayWidth, frame.displayHeight];
      draw(this.asked.screen.canvas, frame, widthPx, heightPx);
      const takenMs = this.#taken.get(frame.timestamp) ?? null;
      this.#taken.delete(frame.timestamp);
      this.asked.listener.shown({ source: frame, widthPx, heightPx, takenMs });
    } finally {
      frame.close();
    }
  }

  /** The decoder is given up; the next picture that stands alone gets a new one. */
  #failed(error: unknown): void {
    this.#drop();
    if (this.#closed) return;
    this.#socket.askKey();
    this.asked.listener.decoderFailed(error instanceof Error ? error.message : String(error));
  }

  #drop(): void {
    const decoder = this.#decoder;
    this.#decoder = null;
    this.#setUp = '';
    this.#taken.clear();
    this.#gate.close();
    if (decoder && decoder.state !== 'closed') decoder.close();
  }
}
