// The connection's own life: greeting, wrong version, loss, silence, coming back. The browser's WebSocket is stood in for, time is
// the test's.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { WAITS_MS, waitMs } from './backoff';
import { openEarly, takeEarly } from './early';
import { Stream } from './stream';
import type { StreamState } from './stream';
import { streamUrl } from './streamUrl';

class Socket {
  static all: Socket[] = [];
  static readonly OPEN = 1;
  binaryType = '';
  readyState = 1;
  bufferedAmount = 0;
  sent: string[] = [];
  onopen: (() => void) | null = null;
  onmessage: ((message: { data: unknown }) => void) | null = null;
  onclose: (() => void) | null = null;
  constructor(readonly url: string) {
    Socket.all.push(this);
  }
  send(text: string): void {
    this.sent.push(text);
  }
  close(): void {
    this.readyState = 3;
  }
  say(message: unknown): void {
    this.onmessage?.({ data: typeof message === 'object' && !(message instanceof ArrayBuffer) ? JSON.stringify(message) : message });
  }
}

const HELLO = { type: 'hello', protocol: 1, version: '0.1.0', node: 'test' };
const newest = (): Socket => Socket.all.at(-1)!;

function started() {
  const states: StreamState[] = [];
  const heard = { frames: 0, cameAt: 0, fleets: 0, safeties: 0, controls: 0, tracks: 0, swarms: 0, replays: 0, events: 0, gaps: 0, unreadable: [] as string[], refused: [] as [number, string][] };
  const stream = new Stream('ws://test/api/v1/stream', {
    state: (state) => states.push(state),
    frame: (_, at) => {
      heard.frames++;
      heard.cameAt = at;
    },
    fleet: () => heard.fleets++,
    safety: (vehicles) => (heard.safeties += vehicles.length),
    control: (vehicles) => (heard.controls += vehicles.length),
    tracks: (list) => (heard.tracks += list.tracks.length),
    swarm: () => heard.swarms++,
    replay: () => heard.replays++,
    event: () => heard.events++,
    gap: (missed) => (heard.gaps += missed),
    unreadable: (why) => heard.unreadable.push(why),
    stickRefused: (vehicle, refusal) => heard.refused.push([vehicle, refusal.reason]),
  });
  stream.start();
  return { stream, states, heard, last: () => states.at(-1)! };
}

beforeEach(() => {
  Socket.all = [];
  vi.stubGlobal('WebSocket', Socket);
  vi.spyOn(Math, 'random').mockReturnValue(0.5);
  vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout', 'setInterval', 'clearInterval', 'performance'] });
});

afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
});

describe('Stream', () => {
  it('is live after the greeting and then hands on messages', () => {
    const { heard, last } = started();
    newest().say(new ArrayBuffer(16));
    expect(heard.frames).toBe(0);
    newest().say(HELLO);
    expect(last()).toMatchObject({ name: 'live', hello: { node: 'test' } });
    newest().say(new ArrayBuffer(16));
    newest().say({ type: 'fleet' });
    newest().say({ type: 'event' });
    newest().say({ type: 'control', vehicles: [{}, {}] });
    newest().say({ type: 'gap', missed: 4 });
    newest().say({ type: 'something new' });
    expect(heard).toMatchObject({ frames: 1, fleets: 1, events: 1, controls: 2, gaps: 4, unreadable: [] });
  });

  it('asks for its rate as soon as it may, and again after a reconnection', () => {
    const { stream } = started();
    stream.setRate(20);
    expect(newest().sent).toEqual([]);
    newest().say(HELLO);
    expect(newest().sent).toEqual(['{"type":"rate","rate_hz":20}']);
    newest().onclose?.();
    vi.advanceTimersByTime(1000);
    newest().say(HELLO);
    expect(Socket.all).toHaveLength(2);
    expect(newest().sent).toEqual(['{"type":"rate","rate_hz":20}']);
  });

  it('says a stick at once or not at all', () => {
    const { stream } = started();
    const stick = { forward_m_s: 1, right_m_s: 0, up_m_s: -0.5, yaw_rate_rad_s: 0 };
    expect(stream.stick(3, stick)).toBe(false);
    newest().say(HELLO);
    expect(stream.stick(3, stick)).toBe(true);
    newest().bufferedAmount = 5000;
    expect(stream.stick(3, stick)).toBe(false);
    newest().bufferedAmount = 0;
    newest().readyState = 2;
    expect(stream.stick(3, stick)).toBe(false);
    expect(newest().sent).toEqual(['{"type":"stick","vehicle":3,"forward_m_s":1,"right_m_s":0,"up_m_s":-0.5,"yaw_rate_rad_s":0}']);
    newest().onclose?.();
    expect(stream.stick(3, stick)).toBe(false);
    vi.advanceTimersByTime(1000);
    newest().say(HELLO);
    expect(newest().sent, 'none is kept for the next connection').toEqual([]);
  });

  it('hands on what is tracked after the greeting', () => {
    const { heard } = started();
    const tracks = { type: 'tracks', time: 5, tracks: [{ track: 1 }, { track: 2 }] };
    newest().say(tracks);
    expect(heard.tracks).toBe(0);
    newest().say(HELLO);
    newest().say(tracks);
    expect(heard.tracks).toBe(2);
  });

  it('tells of a stick that was refused', () => {
    const { heard } = started();
    newest().say(HELLO);
    const refusal = { reason: 'no_control_authority', vehicle: 3, holder: 'Ben' };
    newest().say({ type: 'error', error: { code: 'no_control_authority', message: '', detail: { stick: 3, refusal } } });
    expect([heard.refused, heard.unreadable]).toEqual([[[3, 'no_control_authority']], []]);
  });

  it('does not go on with a server of another version, nor try again', () => {
    const { last } = started();
    newest().say({ ...HELLO, protocol: 2 });
    expect(last().name).toBe('incompatible');
    vi.advanceTimersByTime(60_000);
    expect(Socket.all).toHaveLength(1);
  });

  it('comes back after a loss, and a good connection forgets the failures', () => {
    const { last, states } = started();
    newest().say(HELLO);
    newest().onclose?.();
    expect(last().name).toBe('lost');
    vi.advanceTimersByTime(300);
    expect(last().name).toBe('connecting');
    newest().say(HELLO);
    newest().onclose?.();
    vi.advanceTimersByTime(300);
    expect(states.map((s) => s.name)).toEqual(['connecting', 'live', 'lost', 'connecting', 'live', 'lost', 'connecting']);
  });

  it('takes silence for a loss, but only once data has flowed', () => {
    const { last } = started();
    newest().say(HELLO);
    vi.advanceTimersByTime(60_000);
    expect(last().name).toBe('live');
    newest().say(new ArrayBuffer(16));
    vi.advanceTimersByTime(2500);
    expect(last().name).toBe('live');
    vi.advanceTimersByTime(800);
    expect(last()).toMatchObject({ name: 'lost', reason: 'the server has gone silent' });
  });

  it('gives up a connection that never greets', () => {
    const { last } = started();
    vi.advanceTimersByTime(4300);
    expect(last()).toMatchObject({ name: 'lost', reason: 'the server does not answer' });
  });

  it('hears nothing more from a socket it has left', () => {
    const { heard } = started();
    const old = newest();
    old.say(HELLO);
    old.onclose?.();
    old.say(new ArrayBuffer(16));
    expect(heard.frames).toBe(0);
  });

  it('says what it could not read and goes on', () => {
    const { heard } = started();
    newest().say(HELLO);
    newest().say('{');
    newest().say({ type: 'error', error: { code: 'bad_message', message: 'rate_hz is out of range', detail: null } });
    newest().say({ type: 'event' });
    expect(heard.unreadable).toEqual(['a text message is not JSON', 'the server did not understand this page: rate_hz is out of range']);
    expect(heard.events).toBe(1);
  });
});

describe('a socket that was opened early', () => {
  const URL = 'ws://test/api/v1/stream';
  afterEach(() => void takeEarly(URL));

  it('is taken over with what was said on it, of frames the newest, at the time at which it came', async () => {
    openEarly(URL);
    const socket = newest();
    socket.onopen?.();
    expect(socket.sent).toEqual(['{"type":"rate","rate_hz":1}']);
    socket.say(HELLO);
    socket.say(new ArrayBuffer(16));
    socket.say({ type: 'fleet' });
    vi.advanceTimersByTime(1000);
    socket.say(new ArrayBuffer(16));
    const cameAt = performance.now();
    vi.advanceTimersByTime(700);
    const { stream, heard, last } = started();
    stream.setRate(20);
    expect(heard.frames).toBe(0);
    await Promise.resolve();
    expect(Socket.all).toHaveLength(1);
    expect(last()).toMatchObject({ name: 'live' });
    expect(heard).toMatchObject({ frames: 1, fleets: 1, cameAt });
    expect(socket.sent.at(-1)).toBe('{"type":"rate","rate_hz":20}');
    socket.say(new ArrayBuffer(16));
    expect(heard).toMatchObject({ frames: 2, cameAt: cameAt + 700 });
    socket.onclose?.();
    vi.advanceTimersByTime(1000);
    expect(Socket.all).toHaveLength(2);
  });

  it('is not taken where it was closed meanwhile, or leads elsewhere', () => {
    openEarly(URL);
    newest().close();
    started();
    expect(Socket.all).toHaveLength(2);
    openEarly('ws://elsewhere/');
    started();
    expect(Socket.all).toHaveLength(4);
  });

  it('is closed where no page comes up', () => {
    openEarly(URL);
    vi.advanceTimersByTime(30_000);
    expect(newest().readyState).toBe(3);
  });
});

describe('waitMs', () => {
  it('grows to a limit and is spread by a tenth to each side', () => {
    expect([0, 1, 2, 3, 4, 5, 99].map((n) => waitMs(n, 0.5))).toEqual([...WAITS_MS, 4000, 4000]);
    expect(waitMs(2, 0)).toBe(900);
    expect(waitMs(2, 1)).toBe(1100);
  });
});

describe('streamUrl', () => {
  it('stands beside the page, with its own scheme, and says which console listens', () => {
    expect(streamUrl('http://127.0.0.1:8080/', '3f2a')).toBe('ws://127.0.0.1:8080/api/v1/stream?console=3f2a');
    expect(streamUrl('https://gcs.local/skein/', '3f2a')).toBe('wss://gcs.local/skein/api/v1/stream?console=3f2a');
  });
});
