// The video streams that there are, asked for while somebody looks, and what this browser shows of them: on which way, which one large, which one
// in a corner of the map. The choices are kept in the browser. Must never receive a picture.

import { remember, remembered, rememberedText } from '../app/remembered';
import { getRecordings, getVideo, recordVideo } from '../protocol/rest';
import { addressOf, keyOf } from '../protocol/video';
import type { Recording, VideoAddress, VideoStreamView } from '../protocol/video';
import { Pulse } from './pulse';
import { WAY_CHOICES, abilities } from './videoWay';
import type { WayChoice } from './videoWay';

const EVERY_MS = 1000;
const RECORDINGS_EVERY_MS = 3000;

/** All in a grid; one large, with the others in a strip; the same beside the map. */
export const LAYOUTS = ['wall', 'large', 'map'] as const;
export type Layout = (typeof LAYOUTS)[number];

export const CORNERS = ['top-left', 'top-right', 'bottom-right', 'bottom-left'] as const;
export type Corner = (typeof CORNERS)[number];

const BOXES = ['shown', 'hidden'] as const;

const KEYS = { way: 'skein-video-way', layout: 'skein-video-layout', large: 'skein-video-large', corner: 'skein-video-corner', inset: 'skein-video-inset', boxes: 'skein-video-boxes' };

export class Video {
  streams = $state.raw<readonly VideoStreamView[]>([]);
  recordings = $state.raw<readonly Recording[]>([]);
  /** The list was answered once. */
  heard = $state(false);
  problem = $state('');
  way = $state<WayChoice>(remembered(KEYS.way, WAY_CHOICES) ?? 'automatic');
  layout = $state<Layout>(remembered(KEYS.layout, LAYOUTS) ?? 'wall');
  corner = $state<Corner>(remembered(KEYS.corner, CORNERS) ?? 'bottom-right');
  /** What detectors find is drawn over it. */
  boxes = $state(remembered(KEYS.boxes, BOXES) !== 'hidden');
  #large = $state.raw<VideoAddress | null>(addressOf(rememberedText(KEYS.large)));
  #inset = $state.raw<VideoAddress | null>(addressOf(rememberedText(KEYS.inset)));
  readonly able = abilities(globalThis);
  #watchers = 0;
  #recorders = 0;
  readonly #list = new Pulse(() => this.#ask(), () => EVERY_MS, () => true);
  readonly #records = new Pulse(async () => void (this.recordings = await getRecordings()), () => RECORDINGS_EVERY_MS, () => true);

  /** The one that is shown large: the chosen one while it is there, else the first. */
  get large(): VideoAddress | null {
    const chosen = this.#large;
    if (chosen && (this.of(chosen) || !this.heard)) return chosen;
    return this.streams[0] ?? chosen;
  }

  /** The one in a corner of the map. */
  get inset(): VideoAddress | null {
    return this.#inset;
  }

  of(address: VideoAddress): VideoStreamView | undefined {
    const key = keyOf(address);
    return this.streams.find((one) => keyOf(one) === key);
  }

  recordingOf(address: VideoAddress): Recording | undefined {
    const key = keyOf(address);
    return this.recordings.find((one) => one.running && keyOf(one) === key);
  }

  chooseWay(way: WayChoice): void {
    this.way = way;
    remember(KEYS.way, way);
  }

  showBoxes(shown: boolean): void {
    this.boxes = shown;
    remember(KEYS.boxes, shown ? 'shown' : 'hidden');
  }

  chooseLayout(layout: Layout): void {
    this.layout = layout;
    remember(KEYS.layout, layout);
  }

  showLarge(address: VideoAddress): void {
    this.#large = address;
    remember(KEYS.large, keyOf(address));
    if (this.layout === 'wall') this.chooseLayout('large');
  }

  /** Puts one into a corner of the map, or takes it away with null. */
  setInset(address: VideoAddress | null): void {
    this.#inset = address;
    remember(KEYS.inset, address === null ? '' : keyOf(address));
  }

  setCorner(corner: Corner): void {
    this.corner = corner;
    remember(KEYS.corner, corner);
  }

  /** Begins a recording on the node or ends it. */
  async record(address: VideoAddress, on: boolean): Promise<void> {
    await recordVideo(address, on);
    this.#records.soon(0);
  }

  /** Asks which streams there are until the returned function is called. */
  watch(): () => void {
    if (this.#watchers++ === 0) this.#list.start();
    return () => {
      if (--this.#watchers === 0) this.#list.stop();
    };
  }

  /** The same for recordings. */
  watchRecordings(): () => void {
    if (this.#recorders++ === 0) this.#records.start();
    return () => {
      if (--this.#recorders === 0) this.#records.stop();
    };
  }

  async #ask(): Promise<void> {
    try {
      const streams = await getVideo();
      this.streams = streams.sort((a, b) => a.vehicle - b.vehicle || a.payload.localeCompare(b.payload));
      this.heard = true;
      this.problem = '';
    } catch (error) {
      this.problem = error instanceof Error ? error.message : String(error);
    }
  }
}
