// What every way of receiving a stream has in common: where it shows the pictures, and what it says of them. Must never decide whether another
// way is taken.

import type { VideoAddress, VideoQuality, VideoStreamView } from '../../protocol/video';
import type { VideoWay } from '../../model/videoWay';
import type { Delays } from './pictureLog';

/** What pictures are shown on: drawn, or played by the browser itself. */
export type Screen = { canvas: HTMLCanvasElement; video: HTMLVideoElement };

/** A picture that has just come before the eyes. */
export type ShownPicture = {
  /** Good only until the listener returns. */
  source: CanvasImageSource;
  widthPx: number;
  heightPx: number;
  /** When it was taken, on the `performance.now()` clock; null where nothing says it. */
  takenMs: number | null;
};

export type ReceiverListener = {
  shown(picture: ShownPicture): void;
  state(view: VideoStreamView): void;
  /** Pictures that came and pictures that did not, so far. */
  counted(came: number, lost: number): void;
  /** A picture could not be decoded; it goes on. */
  decoderFailed(why: string): void;
  /** It is over. `refused` if it never began; `fault` if the way itself does not work here. */
  ended(why: string, how: 'closed' | 'refused' | 'fault'): void;
};

export interface Receiver {
  readonly way: VideoWay;
  /** What the node's clock says at a moment of the page's, in ms; null as long as it is not known. */
  nodeMs(pageMs: number): number | null;
  /** Messages that could not be read. */
  readonly unreadable: number;
  /** Tells the node how long it takes from glass to glass. */
  seen(delays: Delays): void;
  /** Ends it; the listener hears nothing any more. */
  close(): void;
}

export type Asked = { of: VideoAddress; quality: VideoQuality; screen: Screen; listener: ReceiverListener };

/** Draws a picture, in its own size. */
export function draw(canvas: HTMLCanvasElement, source: CanvasImageSource, widthPx: number, heightPx: number): void {
  if (canvas.width !== widthPx || canvas.height !== heightPx) Object.assign(canvas, { width: widthPx, height: heightPx });
  canvas.getContext('2d', { alpha: false })?.drawImage(source, 0, 0, widthPx, heightPx);
}

/** When a picture was taken, on the page's clock: by the node's clock, else by how old it was when it was sent. */
export function takenAt(clockOffsetMs: number | null, timeUs: number, ageUs: number, heardMs: number): number {
  return clockOffsetMs === null ? heardMs - ageUs / 1000 : timeUs / 1000 - clockOffsetMs;
}
