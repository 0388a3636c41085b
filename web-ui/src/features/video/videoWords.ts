// What is said of a stream, as an operator reads it. Pure. Must never call a picture live that is not renewed.

import { said, t } from '../../language/language.svelte';
import { spoken } from '../../protocol/words';
import type { VideoState } from '../../protocol/video';
import type { Staleness } from '../../telemetry/staleness';
import type { VideoWay, WayChoice } from '../../model/videoWay';
import type { StreamFacts } from './liveStream.svelte';

/** Names of techniques are the same in every language. */
const WAY_NAMES: Record<VideoWay, string> = { webrtc: 'WebRTC', webcodecs: 'WebCodecs', jpeg: 'JPEG' };

export function wayText(way: WayChoice | null): string {
  if (way === null) return '–';
  return way === 'automatic' ? t('automatic') : WAY_NAMES[way];
}

const MARKS: Record<VideoState, Staleness> = {
  live: 'live', starting: 'delayed', stalled: 'stale', no_key_picture: 'stale', no_pictures: 'stale', failed: 'lost',
};

/** The shape for what the node says. */
export const markOf = (state: VideoState): Staleness => MARKS[state];

/** How a stream is: the shape beside the word, the word, and why. */
export function stateWords({ view, frozen, seen, problem }: StreamFacts): { mark: Staleness; word: string; why: string } {
  if (view === null) return { mark: 'delayed', word: said('connecting'), why: problem };
  const state = view.state !== 'live' ? view.state : !seen ? 'starting' : frozen ? 'stalled' : 'live';
  return { mark: markOf(state), word: spoken(state), why: view.reason || problem };
}

export function ageText(seconds: number | null): string {
  return seconds === null ? '–' : `${seconds.toFixed(1)} s`;
}

/** Over a picture that is not renewed. */
export function frozenText(seconds: number): string {
  return t('last picture {seconds} s ago', { seconds: seconds.toFixed(1) });
}

export const rateText = (hz: number): string => `${hz < 9.95 ? hz.toFixed(1) : hz.toFixed(0)}/s`;

export const shareText = (share: number): string => `${(share * 100).toFixed(share > 0 && share < 0.0995 ? 1 : 0)} %`;

export const sizeText = (widthPx: number, heightPx: number): string => (widthPx > 0 ? `${widthPx}×${heightPx}` : '–');

export const msText = (ms: number): string => `${ms.toFixed(0)} ms`;

/** A size on the disk. */
export function bytesText(bytes: number): string {
  return bytes < 1e6 ? `${(bytes / 1e3).toFixed(0)} kB` : bytes < 1e9 ? `${(bytes / 1e6).toFixed(1)} MB` : `${(bytes / 1e9).toFixed(2)} GB`;
}

/** `1:05`, `1:02:05`. */
export function lengthText(seconds: number): string {
  const whole = Math.floor(seconds);
  const two = (value: number): string => String(value).padStart(2, '0');
  const [h, min, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return h > 0 ? `${h}:${two(min)}:${two(s)}` : `${min}:${two(s)}`;
}

/** The name of a file for the picture of this moment: nothing in it that a disk does not take. */
export function stillName(vehicle: string, payload: string, when: Date): string {
  const two = (value: number): string => String(value).padStart(2, '0');
  const day = `${when.getFullYear()}${two(when.getMonth() + 1)}${two(when.getDate())}`;
  const time = `${two(when.getHours())}${two(when.getMinutes())}${two(when.getSeconds())}`;
  const sound = (text: string): string => text.replace(/[^\p{L}\p{N}_-]+/gu, '-').replace(/^-+|-+$/g, '');
  return `${sound(vehicle)}_${sound(payload)}_${day}-${time}.jpg`;
}
