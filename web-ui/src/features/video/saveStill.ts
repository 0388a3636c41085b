// The picture of this moment as a file of the operator's own computer. Must never reach the node: what it records is another thing.

import type { Screen } from './receiver';

const QUALITY = 0.92;

/** What is on the screen; null if there is nothing. */
export function stillOf({ canvas, video }: Screen, played: boolean): Promise<Blob | null> {
  const source = played ? copyOf(video) : canvas;
  if (source.width === 0 || source.height === 0) return Promise.resolve(null);
  return new Promise((done) => source.toBlob(done, 'image/jpeg', QUALITY));
}

function copyOf(video: HTMLVideoElement): HTMLCanvasElement {
  const copy = document.createElement('canvas');
  Object.assign(copy, { width: video.videoWidth, height: video.videoHeight });
  copy.getContext('2d', { alpha: false })?.drawImage(video, 0, 0);
  return copy;
}

/** Hands a file to the browser, to be kept where it keeps what it is given. */
export function save(file: Blob, name: string): void {
  const url = URL.createObjectURL(file);
  const link = document.createElement('a');
  link.href = url;
  link.download = name;
  link.click();
  // The browser has begun to read it by then.
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
