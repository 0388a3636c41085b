// A stream for as long as a component lives, on the way that is chosen on the page. Called while the component is made, as every `use…` is.

import { untrack } from 'svelte';
import { useConsole } from '../../app/console.svelte';
import type { VideoAddress, VideoQuality } from '../../protocol/video';
import { LiveStream } from './liveStream.svelte';

/** It is opened by the screen that shows it. Another stream wants another component (`{#key}`). */
export function useStream(of: () => VideoAddress, quality: VideoQuality): LiveStream {
  const { video, session } = useConsole();
  let way = video.way;
  const { vehicle, payload } = of();
  const stream = new LiveStream({ vehicle, payload }, quality, way, video.able, () => session.canCommand);
  $effect(() => {
    if (video.way === way) return;
    way = video.way;
    untrack(() => stream.choose(way));
  });
  return stream;
}
