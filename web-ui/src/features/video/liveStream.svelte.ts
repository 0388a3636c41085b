// One stream before the eyes: opened on the way that works, opened again after a loss, on another way after a failure; and what there is to say of
// it, four times a second. Must never make the framework see a picture: pictures go from the way to the screen.

import { waitMs } from '../../protocol/backoff';
import type { VideoAddress, VideoQuality, VideoStreamView } from '../../protocol/video';
import { t } from '../../language/language.svelte';
import { WayPicker, isSilent } from '../../model/videoWay';
import type { Abilities, VideoWay, WayChoice } from '../../model/videoWay';
import { ClockReader, sinceClock } from './clockStrip';
import { publish } from './hook';
import type { StreamTruth } from './hook';
import { DelayLog, LossLog, PictureLog, together } from './pictureLog';
import type { Delays } from './pictureLog';
import type { Receiver, ReceiverListener, Screen, ShownPicture } from './receiver';
import { stillOf } from './saveStill';
import { openWay } from './ways';
import type { OpenWay } from './ways';

const TICK_MS = 250;
/** Refused so often in a row by a node that is heard: it does not give the stream on this way. */
const REFUSALS = 3;

/** What is said of a stream. */
export type StreamFacts = {
  /** As the node says it; null as long as it says nothing. */
  view: VideoStreamView | null;
  way: VideoWay | null;
  /** The browser itself plays it, instead of the page drawing it. */
  played: boolean;
  /** Pictures have come since it was opened. */
  seen: boolean;
  widthPx: number;
  heightPx: number;
  rateHz: number;
  lossShare: number;
  /** Since the picture before the eyes was taken; null before the first. */
  ageS: number | null;
  frozen: boolean;
  delays: Delays | null;
  /** Why it is not there; empty if all is well. */
  problem: string;
  /** The way that failed before, and why. */
  fellBack: { way: VideoWay; why: string } | null;
};

const NO_FACTS: StreamFacts = {
  view: null, way: null, played: false, seen: false, widthPx: 0, heightPx: 0, rateHz: 0, lossShare: 0, ageS: null, frozen: false, delays: null, problem: '',
  fellBack: null,
};

export class LiveStream {
  facts = $state.raw<StreamFacts>(NO_FACTS);
  readonly #picker: WayPicker;
  readonly #log = new PictureLog();
  readonly #delays = new DelayLog();
  readonly #losses = new LossLog();
  readonly #clock = new ClockReader();
  #screen: Screen | null = null;
  #receiver: Receiver | null = null;
  #view: VideoStreamView | null = null;
  #beat: ReturnType<typeof setInterval> | undefined;
  #retry: ReturnType<typeof setTimeout> | undefined;
  #unpublish: (() => void) | null = null;
  #failures = 0;
  #refusals = 0;
  #openedMs = 0;
  #liveMs: number | null = null;
  #picturesAtOpening = 0;
  #takenMs: number | null = null;
  #size = { widthPx: 0, heightPx: 0 };
  #lastClockMs: number | null = null;
  #problem = '';
  #fellBack: StreamFacts['fellBack'] = null;

  constructor(
    readonly of: VideoAddress,
    readonly quality: VideoQuality,
    choice: WayChoice,
    able: Abilities,
    /** Whether the node is heard at all: while it is not, no way is to blame. */
    readonly heard: () => boolean,
    readonly openOn: OpenWay = openWay,
  ) {
    this.#picker = new WayPicker(choice, able);
  }

  /** Receives it from now on, and shows it on this screen. */
  open(screen: Screen): void {
    if (this.#screen) return;
    this.#screen = screen;
    this.#unpublish = publish(() => this.#truth());
    this.#beat = setInterval(() => this.#tick(), TICK_MS);
    this.#failures = 0;
    this.#begin();
  }

  /** What was shown stays before the eyes, and gets older. */
  close(): void {
    clearInterval(this.#beat);
    clearTimeout(this.#retry);
    this.#stop();
    this.#screen = null;
    this.#unpublish?.();
    this.#unpublish = null;
    this.#refresh();
  }

  /** Another way was chosen. */
  choose(choice: WayChoice): void {
    this.#picker.choose(choice);
    this.#problem = '';
    this.#fellBack = null;
    if (this.#screen) this.#begin();
  }

  /** The picture of this moment; null if there is none. */
  still(): Promise<Blob | null> {
    return this.#screen ? stillOf(this.#screen, this.facts.played) : Promise.resolve(null);
  }

  #stop(): void {
    const receiver = this.#receiver;
    this.#receiver = null;
    receiver?.close();
    this.#view = null;
    this.#liveMs = null;
    this.#losses.clear();
    this.#delays.clear();
  }

  #begin(): void {
    clearTimeout(this.#retry);
    this.#stop();
    const screen = this.#screen;
    if (!screen) return;
    const now = performance.now();
    const way = this.#picker.way(now);
    this.#openedMs = now;
    this.#picturesAtOpening = this.#log.shown;
    if (way === null) this.#problem = t('this browser does not have this way');
    else this.#receiver = this.openOn(way, { of: this.of, quality: this.quality, screen, listener: this.#listener(way) });
    this.#refresh();
  }

  #listener(way: VideoWay): ReceiverListener {
    return {
      shown: (picture) => this.#shown(picture),
      state: (view) => this.#state(view),
      counted: (came, lost) => this.#losses.note(performance.now(), came, lost),
      decoderFailed: (why) => {
        if (this.#picker.decoderFailed(performance.now())) this.#another(way, why);
      },
      ended: (why, how) => {
        this.#receiver = null;
        this.#refusals = how === 'refused' && this.heard() ? this.#refusals + 1 : 0;
        if (how === 'fault' || this.#refusals >= REFUSALS) this.#another(way, why);
        else this.#later(why);
      },
    };
  }

  #state(view: VideoStreamView): void {
    this.#refusals = 0;
    if (view.state !== 'live') this.#liveMs = null;
    else this.#liveMs ??= performance.now();
    this.#view = view;
    const delays = this.#delays.of(performance.now());
    if (delays) this.#receiver?.seen(delays);
  }

  #shown({ source, widthPx, heightPx, takenMs }: ShownPicture): void {
    const now = performance.now();
    this.#log.note(now);
    this.#failures = 0;
    if (this.#fellBack?.way === this.#receiver?.way) this.#fellBack = null;
    this.#size = { widthPx, heightPx };
    this.#problem = '';
    const clock = this.#clock.read(source, widthPx, heightPx);
    const nodeMs = this.#receiver?.nodeMs(now) ?? null;
    const delayMs = clock === null || nodeMs === null ? null : sinceClock(nodeMs, clock);
    if (clock !== null) this.#lastClockMs = clock;
    if (delayMs !== null) this.#delays.note(now, delayMs);
    this.#takenMs = takenMs ?? now - Math.max(0, delayMs ?? 0);
  }

  /** The way has failed: the next one, at once if there is one that has not. */
  #another(way: VideoWay, why: string): void {
    const now = performance.now();
    this.#refusals = 0;
    this.#picker.failed(way, now);
    this.#problem = why;
    this.#fellBack = { way, why };
    if (this.#picker.isSound(now)) this.#begin();
    else this.#later(why);
  }

  #later(why: string): void {
    this.#stop();
    this.#problem = why;
    clearTimeout(this.#retry);
    this.#retry = setTimeout(() => this.#begin(), waitMs(this.#failures++, Math.random()));
    this.#refresh();
  }

  #tick(): void {
    const way = this.#receiver?.way;
    const silent = isSilent(performance.now(), this.#openedMs, this.#liveMs, this.#log.lastMs, this.#view?.rate_hz ?? 0);
    if (way && silent && this.heard()) this.#another(way, t('no picture came'));
    this.#refresh();
  }

  /** Brings what is said up to date. */
  #refresh(): void {
    const now = performance.now();
    const seen = this.#log.shown > this.#picturesAtOpening;
    this.facts = {
      view: this.#view,
      way: this.#receiver?.way ?? null,
      played: this.#receiver?.way === 'webrtc' && seen,
      seen,
      ...this.#size,
      rateHz: this.#log.rateHz(now),
      lossShare: together(this.#view?.lost ?? 0, this.#losses.share),
      ageS: this.#takenMs === null ? null : Math.max(0, now - this.#takenMs) / 1000,
      frozen: this.#log.frozen(now),
      delays: this.#delays.of(now),
      problem: this.#problem,
      fellBack: this.#fellBack,
    };
  }

  #truth(): StreamTruth {
    const now = performance.now();
    return {
      ...this.of,
      ...this.#size,
      quality: this.quality,
      way: this.#receiver?.way ?? null,
      state: this.#view?.state ?? 'connecting',
      frozen: this.#log.frozen(now),
      shown: this.#log.shown,
      lastClockMs: this.#lastClockMs,
      glassToGlassMs: this.#delays.list(now),
      rateHz: this.#log.rateHz(now),
      unreadable: this.#receiver?.unreadable ?? 0,
    };
  }
}
