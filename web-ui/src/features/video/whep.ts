// A stream over WebRTC: offered with WHEP, received and played by the browser itself. A socket without pictures stands beside it for the state
// of the stream and the node's clock. Must never wait for candidates longer than a second: within one network the own ones are enough.

import { ApiError, endVideo, offerVideo } from '../../protocol/rest';
import { videoSocketUrl } from '../../protocol/video';
import { t } from '../../language/language.svelte';
import { draw } from './receiver';
import type { Delays } from './pictureLog';
import type { Asked, Receiver } from './receiver';
import { VideoSocket } from './videoSocket';

const GATHERING_MS = 1000;
const STATS_EVERY_MS = 2000;

export class WhepReceiver implements Receiver {
  readonly way = 'webrtc';
  readonly #socket: VideoSocket;
  readonly #peer = new RTCPeerConnection();
  #session: URL | null = null;
  #timer: ReturnType<typeof setInterval> | undefined;
  #callback = 0;
  #closed = false;

  constructor(readonly asked: Asked) {
    const { of, quality, listener } = asked;
    this.#socket = new VideoSocket(videoSocketUrl(document.baseURI, of, 'none', quality), {
      picture: () => {},
      state: (view) => listener.state(view),
      closed: (why, refused) => this.#end(why, refused ? 'refused' : 'closed'),
    });
    this.#peer.ontrack = ({ track, receiver }) => this.#play(track, receiver);
    this.#peer.onconnectionstatechange = () => {
      if (this.#peer.connectionState === 'failed') this.#end(t('WebRTC found no way to the node'), 'fault');
    };
    void this.#offer();
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
    if (this.#closed) return;
    this.#closed = true;
    clearInterval(this.#timer);
    this.#socket.close();
    this.#peer.ontrack = this.#peer.onconnectionstatechange = null;
    this.#peer.close();
    const { canvas, video } = this.asked.screen;
    video.cancelVideoFrameCallback(this.#callback);
    // The last picture stays before the eyes: what the browser played is gone with its source.
    if (video.videoWidth > 0) draw(canvas, video, video.videoWidth, video.videoHeight);
    video.srcObject = null;
    this.#leave();
  }

  #end(why: string, how: 'closed' | 'refused' | 'fault'): void {
    if (this.#closed) return;
    this.close();
    this.asked.listener.ended(why, how);
  }

  async #offer(): Promise<void> {
    try {
      const { receiver } = this.#peer.addTransceiver('video', { direction: 'recvonly' });
      withoutDelay(receiver);
      await this.#peer.setLocalDescription();
      await gathered(this.#peer);
      const { sdp, session } = await offerVideo(this.asked.of, this.asked.quality, this.#peer.localDescription?.sdp ?? '');
      this.#session = session;
      if (this.#closed) this.#leave();
      else await this.#peer.setRemoteDescription({ type: 'answer', sdp });
    } catch (error) {
      // A node that is not heard says nothing against the way.
      const unheard = error instanceof ApiError && error.status === 0;
      this.#end(error instanceof Error ? error.message : String(error), unheard ? 'refused' : 'fault');
    }
  }

  /** Tells the node; one that does not hear it notices by itself. */
  #leave(): void {
    const session = this.#session;
    this.#session = null;
    if (session) void endVideo(session).catch(() => {});
  }

  #play(track: MediaStreamTrack, receiver: RTCRtpReceiver): void {
    const { video } = this.asked.screen;
    withoutDelay(receiver);
    video.srcObject = new MediaStream([track]);
    // It ends by itself where it is closed meanwhile.
    void video.play().catch(() => {});
    const look: VideoFrameRequestCallback = (_, { width, height }) => {
      if (this.#closed) return;
      this.asked.listener.shown({ source: video, widthPx: width, heightPx: height, takenMs: null });
      this.#callback = video.requestVideoFrameCallback(look);
    };
    this.#callback = video.requestVideoFrameCallback(look);
    this.#timer ??= setInterval(() => void this.#count(receiver), STATS_EVERY_MS);
  }

  async #count(receiver: RTCRtpReceiver): Promise<void> {
    for (const report of (await receiver.getStats()).values() as Iterable<RTCInboundRtpStreamStats>) {
      if (report.type !== 'inbound-rtp' || this.#closed) continue;
      this.asked.listener.counted(report.packetsReceived ?? 0, Math.max(0, report.packetsLost ?? 0));
    }
  }
}

/** Nothing is held back to play evenly: what counts is what is there now. */
function withoutDelay(receiver: RTCRtpReceiver): void {
  if ('jitterBufferTarget' in receiver) receiver.jitterBufferTarget = 0;
  if ('playoutDelayHint' in receiver) (receiver as { playoutDelayHint: number }).playoutDelayHint = 0;
}

/** Until the browser knows all its addresses, or a second is over. */
function gathered(peer: RTCPeerConnection): Promise<void> {
  if (peer.iceGatheringState === 'complete') return Promise.resolve();
  return new Promise((done) => {
    const timer = setTimeout(done, GATHERING_MS);
    peer.addEventListener('icegatheringstatechange', () => {
      if (peer.iceGatheringState !== 'complete') return;
      clearTimeout(timer);
      done();
    });
  });
}
