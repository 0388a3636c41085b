// One stream through its life: the way that is taken, back-off, failures, what is said of it. The ways are stood in for, time is the test's.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { VideoState, VideoStreamView } from '../../protocol/video';
import { LiveStream } from './liveStream.svelte';
import type { Asked, Receiver, Screen } from './receiver';
import type { VideoWay, WayChoice } from '../../model/videoWay';
import { stateWords } from './videoWords';

type Opened = Asked & { way: VideoWay; closed: boolean };

/** What a test leaves open is closed after it. */
const streams: LiveStream[] = [];

const ALL = { webcodecs: true, webrtc: true, jpeg: true };
const SCREEN = {} as Screen;

function view(state: VideoState, over: Partial<VideoStreamView> = {}): VideoStreamView {
  return { vehicle: 2, payload: 'camera', state, reason: '', codec: '', width_px: 640, height_px: 480, rate_hz: 30, bytes_per_s: 0, lost: 0, age_s: 0, viewers: 1, ...over };
}

function begun(choice: WayChoice = 'automatic', able = ALL) {
  const opened: Opened[] = [];
  const node = { heard: true };
  const stream = new LiveStream({ vehicle: 2, payload: 'camera' }, 'sub', choice, able, () => node.heard, (way, asked): Receiver => {
    const one = { ...asked, way, closed: false };
    opened.push(one);
    return { way, unreadable: 0, nodeMs: (pageMs) => pageMs + 1000, seen: () => {}, close: () => (one.closed = true) };
  });
  streams.push(stream);
  stream.open(SCREEN);
  const last = (): Opened => opened.at(-1)!;
  const show = (takenMs: number | null = null): void => last().listener.shown({ source: {} as CanvasImageSource, widthPx: 0, heightPx: 0, takenMs });
  const play = (seconds: number): void => {
    for (let k = 0; k < seconds * 20; k++) {
      vi.advanceTimersByTime(50);
      show();
    }
  };
  return { stream, opened, node, last, show, play, ways: () => opened.map(({ way }) => way) };
}

beforeEach(() => {
  vi.stubGlobal('window', {});
  vi.spyOn(Math, 'random').mockReturnValue(0.5);
  vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout', 'setInterval', 'clearInterval', 'performance'] });
});
afterEach(() => {
  for (const stream of streams.splice(0)) stream.close();
  vi.useRealTimers();
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
});

describe('a stream', () => {
  it('is starting, live, and frozen in words when nothing new comes', () => {
    const { stream, last, play } = begun();
    expect(stateWords(stream.facts)).toMatchObject({ word: 'connecting', mark: 'delayed' });
    last().listener.state(view('live', { lost: 0.1 }));
    vi.advanceTimersByTime(250);
    expect(stateWords(stream.facts).word).toBe('starting');
    play(4);
    vi.advanceTimersByTime(250);
    expect(stateWords(stream.facts)).toMatchObject({ word: 'live', mark: 'live' });
    expect(stream.facts).toMatchObject({ way: 'webcodecs', played: false, frozen: false });
    expect(stream.facts.rateHz).toBeGreaterThan(15);
    expect(stream.facts.lossShare).toBeCloseTo(0.1);
    vi.advanceTimersByTime(1000);
    expect(stream.facts).toMatchObject({ frozen: true });
    expect(stream.facts.ageS).toBeCloseTo(1.25, 1);
    expect(stateWords(stream.facts)).toMatchObject({ word: 'stalled', mark: 'stale' });
  });

  it('says what the node says is wrong', () => {
    const { stream, last } = begun();
    last().listener.state(view('failed', { reason: 'H.265 is not understood' }));
    vi.advanceTimersByTime(250);
    expect(stateWords(stream.facts)).toEqual({ mark: 'lost', word: 'failed', why: 'H.265 is not understood' });
    last().listener.state(view('no_key_picture'));
    vi.advanceTimersByTime(250);
    expect(stateWords(stream.facts).word).toBe('no key picture');
  });

  it('knows the age of a picture by when it was taken', () => {
    const { stream, show } = begun();
    show(performance.now() - 400);
    vi.advanceTimersByTime(250);
    expect(stream.facts.ageS).toBeCloseTo(0.65, 2);
  });

  it('is published as long as it is open', () => {
    const { stream, show } = begun();
    show();
    expect(window.__skeinVideo?.streams()).toMatchObject([{ vehicle: 2, payload: 'camera', quality: 'sub', way: 'webcodecs', shown: 1, state: 'connecting', lastClockMs: null }]);
    stream.close();
    expect(window.__skeinVideo).toBeUndefined();
  });

  it('that is closed asks for nothing, and is opened again', () => {
    const { stream, opened, last } = begun();
    stream.close();
    expect(last().closed).toBe(true);
    vi.advanceTimersByTime(60_000);
    expect(opened).toHaveLength(1);
    stream.open(SCREEN);
    expect(opened).toHaveLength(2);
  });
});

describe('after a loss', () => {
  it('it comes back on the same way, later and later until a picture comes', () => {
    const { opened, last, show, ways } = begun();
    const waits: number[] = [];
    for (let k = 0; k < 6; k++) {
      const count = opened.length;
      last().listener.ended('gone', 'closed');
      let waited = 0;
      for (; opened.length === count; waited += 50) vi.advanceTimersByTime(50);
      waits.push(waited);
    }
    expect(waits).toEqual([250, 500, 1000, 2000, 4000, 4000]);
    show();
    const count = opened.length;
    last().listener.ended('gone', 'closed');
    vi.advanceTimersByTime(250);
    expect(opened).toHaveLength(count + 1);
    expect(new Set(ways())).toEqual(new Set(['webcodecs']));
  });

  it('says why it is not there meanwhile', () => {
    const { stream, last } = begun();
    last().listener.state(view('live'));
    last().listener.ended('the server closed the connection', 'closed');
    expect(stateWords(stream.facts)).toEqual({ mark: 'delayed', word: 'connecting', why: 'the server closed the connection' });
  });

  it('of the node no way is to blame', () => {
    const { last, node, ways } = begun();
    node.heard = false;
    for (let k = 0; k < 8; k++) {
      last().listener.ended('the server does not give the stream', 'refused');
      vi.advanceTimersByTime(5000);
    }
    expect(new Set(ways())).toEqual(new Set(['webcodecs']));
  });
});

describe('the next way', () => {
  it('is taken at once after a fault, and says which one failed', () => {
    const { stream, last, show, ways } = begun();
    last().listener.ended('no H.264', 'fault');
    last().listener.ended('no way to the node', 'fault');
    expect(ways()).toEqual(['webcodecs', 'webrtc', 'jpeg']);
    last().listener.state(view('live'));
    show();
    vi.advanceTimersByTime(250);
    expect(stream.facts).toMatchObject({ way: 'jpeg', problem: '', fellBack: { way: 'webrtc', why: 'no way to the node' } });
    // All have failed now: there is a pause before the first is tried again.
    last().listener.ended('broken pictures', 'fault');
    expect(ways()).toHaveLength(3);
    vi.advanceTimersByTime(300);
    expect(ways()).toEqual(['webcodecs', 'webrtc', 'jpeg', 'webcodecs']);
  });

  it('is taken when the decoder fails twice within ten seconds', () => {
    const { last, ways } = begun();
    last().listener.decoderFailed('bad data');
    vi.advanceTimersByTime(11_000);
    last().listener.decoderFailed('bad data');
    expect(ways()).toEqual(['webcodecs']);
    vi.advanceTimersByTime(4000);
    last().listener.decoderFailed('bad data');
    expect(ways()).toEqual(['webcodecs', 'webrtc']);
  });

  it('is taken when no picture comes of a stream that is live, and not of one that is not', () => {
    const { opened, last, ways } = begun();
    last().listener.state(view('no_pictures'));
    vi.advanceTimersByTime(20_000);
    expect(ways()).toEqual(['webcodecs']);
    last().listener.state(view('live'));
    vi.advanceTimersByTime(5000);
    expect(ways()).toEqual(['webcodecs']);
    vi.advanceTimersByTime(500);
    expect(ways()).toEqual(['webcodecs', 'webrtc']);
    expect(opened[0]?.closed).toBe(true);
  });

  it('is taken when a node that is heard refuses three times', () => {
    const { last, ways } = begun();
    for (let k = 0; k < 3; k++) {
      last().listener.ended('the server does not give the stream', 'refused');
      vi.advanceTimersByTime(k < 2 ? 5000 : 0);
    }
    expect(ways()).toEqual(['webcodecs', 'webcodecs', 'webcodecs', 'webrtc']);
  });

  it('is not taken from a way that was chosen by hand', () => {
    const { stream, last, show, ways } = begun('webrtc');
    last().listener.ended('no way to the node', 'fault');
    vi.advanceTimersByTime(10_000);
    expect(ways()).toEqual(['webrtc', 'webrtc']);
    expect(stream.facts.fellBack).toMatchObject({ way: 'webrtc' });
    show();
    vi.advanceTimersByTime(250);
    expect(stream.facts.fellBack).toBeNull();
    stream.choose('jpeg');
    expect(ways()).toEqual(['webrtc', 'webrtc', 'jpeg']);
    stream.choose('automatic');
    expect(ways().at(-1)).toBe('webcodecs');
  });

  it('that the browser does not have is not opened, and that is said', () => {
    const { stream, opened } = begun('webcodecs', { ...ALL, webcodecs: false });
    expect(opened).toEqual([]);
    expect(stateWords(stream.facts).why).toBe('this browser does not have this way');
  });
});
