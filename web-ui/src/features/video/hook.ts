// `window.__skeinVideo`: what is shown of every open stream, for tests that judge pictures. Read-only; nothing of the page depends on it.

import type { VideoQuality } from '../../protocol/video';
import type { VideoWay } from '../../model/videoWay';

export type StreamTruth = {
  vehicle: number;
  payload: string;
  quality: VideoQuality;
  way: VideoWay | null;
  /** As the node says it, or what the connection is while it says nothing. */
  state: string;
  frozen: boolean;
  /** Pictures that came before the eyes. */
  shown: number;
  widthPx: number;
  heightPx: number;
  /** The last clock read from a picture, in ms of the node's clock modulo 2^32; null if none was. */
  lastClockMs: number | null;
  /** Of the last ten seconds. */
  glassToGlassMs: number[];
  rateHz: number;
  /** Messages that could not be read. */
  unreadable: number;
};

export type VideoHook = { streams(): StreamTruth[] };

declare global {
  interface Window {
    __skeinVideo?: VideoHook;
  }
}

const open = new Set<() => StreamTruth>();

/** Shows a stream until the returned function is called. */
export function publish(truth: () => StreamTruth): () => void {
  open.add(truth);
  window.__skeinVideo ??= { streams: () => [...open].map((one) => one()) };
  return () => {
    open.delete(truth);
    if (open.size === 0) delete window.__skeinVideo;
  };
}
