// Reads a GeoTIFF beside the page, which stands still for none of it. One patch after the other, so that what it takes is bounded.

import { FaultyFile, GeotiffFile } from './geotiffFile';
import type { Facts, Fault } from './geotiffFile';
import type { Place } from './pixelPyramid';

export type Asked = { readonly open: Blob } | { readonly id: number; readonly place: Place };
export type Answered = { readonly facts: Facts } | { readonly fault: Fault } | { readonly id: number; readonly picture: ImageBitmap | null };

let file: GeotiffFile | null = null;
let last: Promise<void> = Promise.resolve();

function answer(answered: Answered, handedOver: Transferable[] = []): void {
  self.postMessage(answered, { transfer: handedOver });
}

async function open(blob: Blob): Promise<void> {
  try {
    file = await GeotiffFile.open(blob);
    answer({ facts: file.facts });
  } catch (error) {
    answer({ fault: error instanceof FaultyFile ? error.fault : { kind: 'damaged' } });
  }
}

async function picture(place: Place): Promise<ImageBitmap | null> {
  const patch = await file?.patch(place).catch(() => null);
  return patch ? createImageBitmap(new ImageData(patch.pixels, patch.size.widthPx, patch.size.heightPx)) : null;
}

async function take(asked: Asked): Promise<void> {
  if ('open' in asked) return open(asked.open);
  const found = await picture(asked.place).catch(() => null);
  answer({ id: asked.id, picture: found }, found ? [found] : []);
}

self.addEventListener('message', ({ data }: MessageEvent<Asked>) => {
  last = last.then(() => take(data));
});
