// On which way a stream is received: the best that the browser has, the next one when that fails, or the one that was chosen by hand. Pure:
// the time comes in. Must never leave a way that was chosen by hand.

/** WebCodecs over the socket, WebRTC, JPEG over the socket: the best one first. */
export const VIDEO_WAYS = ['webcodecs', 'webrtc', 'jpeg'] as const;
export type VideoWay = (typeof VIDEO_WAYS)[number];

export const WAY_CHOICES = ['automatic', 'webrtc', 'webcodecs', 'jpeg'] as const;
export type WayChoice = (typeof WAY_CHOICES)[number];

/** What a browser can do; JPEG it always can. */
export type Abilities = Readonly<Record<VideoWay, boolean>>;

/** What this browser can do for this page: WebCodecs is there only over HTTPS and on the node's own computer. */
export function abilities(browser: object): Abilities {
  const video = (browser as { HTMLVideoElement?: { prototype: object } }).HTMLVideoElement?.prototype ?? {};
  return {
    webcodecs: 'VideoDecoder' in browser && 'EncodedVideoChunk' in browser,
    webrtc: 'RTCPeerConnection' in browser && 'requestVideoFrameCallback' in video,
    jpeg: true,
  };
}

/** A way that failed is left alone for so long, if there is another. */
const FORGET_MS = 120_000;
/** A decoder may fail once in this time, and goes on. */
const DECODER_MS = 10_000;

export class WayPicker {
  #choice: WayChoice;
  #failedAt = new Map<VideoWay, number>();
  #faultAt = -Infinity;

  constructor(
    choice: WayChoice,
    readonly able: Abilities,
  ) {
    this.#choice = choice;
  }

  /** What was known of failures is forgotten: whoever chooses wants to see it tried. */
  choose(choice: WayChoice): void {
    this.#choice = choice;
    this.#failedAt.clear();
    this.#faultAt = -Infinity;
  }

  /** Whether the way to open now is one that has not failed lately. */
  isSound(nowMs: number): boolean {
    const way = this.way(nowMs);
    return way !== null && nowMs - (this.#failedAt.get(way) ?? -Infinity) >= FORGET_MS;
  }

  /** The way to open now; null if the browser does not have the one that was chosen. */
  way(nowMs: number): VideoWay | null {
    const chosen = this.#choice;
    if (chosen !== 'automatic') return this.able[chosen] ? chosen : null;
    const had = VIDEO_WAYS.filter((way) => this.able[way]);
    const sound = had.find((way) => nowMs - (this.#failedAt.get(way) ?? -Infinity) >= FORGET_MS);
    if (sound !== undefined) return sound;
    // All have failed: the one whose failure is longest ago.
    return had.reduce((a, b) => ((this.#failedAt.get(b) ?? 0) < (this.#failedAt.get(a) ?? 0) ? b : a));
  }

  /** The way has failed. */
  failed(way: VideoWay, nowMs: number): void {
    this.#failedAt.set(way, nowMs);
    this.#faultAt = -Infinity;
  }

  /** The decoder of the way has failed; whether that is the second time in ten seconds, and so the way itself. */
  decoderFailed(nowMs: number): boolean {
    const again = nowMs - this.#faultAt < DECODER_MS;
    this.#faultAt = nowMs;
    return again;
  }
}

/** No picture for so long of a stream that the node calls live: the way does not work. */
const SILENT_MS = 5000;
const SILENT_PERIODS = 5;

/** Whether a way has had its time: since it was opened, since the node said that the stream is live, and since the last picture. */
export function isSilent(nowMs: number, openedMs: number, liveMs: number | null, pictureMs: number | null, rateHz: number): boolean {
  if (liveMs === null) return false;
  const since = nowMs - Math.max(openedMs, liveMs, pictureMs ?? -Infinity);
  // A picture every ten seconds is live too.
  return since > Math.max(SILENT_MS, rateHz > 0 ? (SILENT_PERIODS * 1000) / rateHz : 0);
}
