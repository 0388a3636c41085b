// What the page knows when a recorded flight is shown: nothing of it can be commanded, and another moment of it is neither news nor another run of the server.
// Socket, requests and time are the test's.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { FLAG, HEADER_BYTES, RECORD, RECORD_BYTES } from '../protocol/frame';
import { FRAME_MAGIC, HEADER } from '../protocol/generated/frame';
import type { ReplayState } from '../protocol/types';
import { Commander } from './commander.svelte';
import { Journal } from './journal.svelte';
import { Session } from './session.svelte';

class Socket {
  static all: Socket[] = [];
  static readonly OPEN = 1;
  binaryType = '';
  readyState = 1;
  bufferedAmount = 0;
  onmessage: ((message: { data: unknown }) => void) | null = null;
  onclose: (() => void) | null = null;
  constructor() {
    Socket.all.push(this);
  }
  send(): void {}
  close(): void {
    this.readyState = 3;
  }
}

const BEGIN_MS = 10_000;
const FLEET = {
  type: 'fleet', frame: { origin: { latitude_deg: 47.4, longitude_deg: 8.5, altitude_amsl_m: 400 } }, vehicles: [], unadopted: [], formation: null, actors: [],
  faults_enabled: false, dead_man: { state: 'off', warns_after_s: null }, resume: null,
  recorder: { state: 'off', file: null, in_flight: false, why: null, last_flight: null },
};
const replaying = (over: Partial<ReplayState> = {}) => ({
  type: 'replay', file: 'a.mcap', node: 'alpha', begun_unix_s: 1_700_000_000, begin: BEGIN_MS * 1000, duration_s: 100, position_s: 0, rate: 1, playing: false,
  jumps: 1, indexed: false, ...over,
});

/** A frame of one vehicle, so many seconds into the recording, so many metres north of the origin. */
function frame(afterS: number, id: number, north: number): ArrayBuffer {
  const v = new DataView(new ArrayBuffer(HEADER_BYTES + RECORD_BYTES));
  v.setUint32(HEADER.magic, FRAME_MAGIC, true);
  v.setUint32(HEADER.count, 1, true);
  v.setUint32(HEADER.server_time_ms, BEGIN_MS + afterS * 1000, true);
  v.setUint16(HEADER_BYTES + RECORD.id, id, true);
  v.setUint8(HEADER_BYTES + RECORD.flags, FLAG.connected | FLAG.position);
  v.setInt32(HEADER_BYTES + RECORD.latitude_e7, 47.4e7 + Math.round(north / 0.0111), true);
  v.setInt32(HEADER_BYTES + RECORD.longitude_e7, 8.5e7, true);
  v.setInt32(HEADER_BYTES + RECORD.altitude_amsl_mm, 400_000, true);
  return v.buffer;
}

const event = (seq: number, afterS: number, text: string) => ({ seq, time: (BEGIN_MS + afterS * 1000) * 1000, vehicle: null, severity: 'warning', text, kind: { kind: 'note' } });

let events: ReturnType<typeof event>[] = [];
let asked: string[] = [];

function started() {
  const journal = new Journal();
  const session = new Session(new Commander(), journal, 'console');
  const restarts: boolean[] = [];
  session.onRestart((sameVehicles) => restarts.push(sameVehicles));
  session.start();
  const say = async (...messages: unknown[]): Promise<void> => {
    for (const message of messages) Socket.all.at(-1)!.onmessage?.({ data: message instanceof ArrayBuffer ? message : JSON.stringify(message) });
    await vi.advanceTimersByTimeAsync(0);
  };
  const hello = { type: 'hello', protocol: 1, version: '0.1.0', node: 'alpha' };
  const reconnect = async (): Promise<void> => {
    const before = Socket.all.length;
    Socket.all.at(-1)!.onclose?.();
    while (Socket.all.length === before) await vi.advanceTimersByTimeAsync(100);
  };
  const texts = (): string[] => journal.log.entries.map((entry) => entry.text);
  return { session, journal, restarts, say, hello, reconnect, texts };
}

beforeEach(() => {
  vi.useFakeTimers();
  Socket.all = [];
  events = [];
  asked = [];
  vi.stubGlobal('WebSocket', Socket);
  vi.stubGlobal('document', { baseURI: 'http://127.0.0.1/', hidden: false, addEventListener: () => {} });
  vi.stubGlobal('matchMedia', () => ({ matches: false }));
  vi.stubGlobal('fetch', async (url: URL) => {
    asked.push(url.pathname + url.search);
    const body = url.pathname.endsWith('/timeline') ? { complete: true, marks: [], left_out: 0 } : { events };
    return { ok: true, json: async () => body };
  });
});
afterEach(() => {
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

describe('a recorded flight', () => {
  it('is heard, and nothing of it can be commanded', async () => {
    const { session, say, hello } = started();
    await say(hello, replaying(), FLEET, frame(5, 1, 0));
    expect([session.hears, session.canCommand, session.replay.positionS]).toEqual([true, false, 5]);
    expect(session.rows.map((row) => row.id)).toEqual([1]);
  });

  it('a node that flies says nothing of that', async () => {
    const { session, say, hello } = started();
    await say(hello, FLEET, frame(5, 1, 0));
    expect([session.hears, session.canCommand, session.replay.on]).toEqual([true, true, false]);
  });

  it('its events have the time of day at which they happened', async () => {
    events = [event(1, 2, 'low battery')];
    const { journal, say, hello } = started();
    await say(hello, replaying(), FLEET, frame(5, 1, 0));
    expect(journal.log.entries.map((entry) => [entry.text, entry.lastAt])).toEqual([['low battery', 1_700_000_002_000]]);
  });

  it('at another moment what was known is forgotten, without a word', async () => {
    events = [event(1, 2, 'at two'), event(2, 40, 'at forty')];
    const { session, say, hello, texts, restarts } = started();
    const news: string[] = [];
    session.onEvent(({ text }) => news.push(text));
    await say(hello, replaying(), FLEET, frame(40, 1, 0), frame(41, 1, 50), frame(42, 1, 100));
    expect([texts(), session.fleet.trails.length(0)]).toEqual([['at forty', 'at two'], 3]);

    events = [event(1, 2, 'at two')];
    asked = [];
    await say(replaying({ jumps: 2, position_s: 3 }));
    // Until its first frame the vehicles stay where they were: the page does not blink.
    expect([session.rows.map((row) => row.id), session.replay.positionS]).toEqual([[1], 3]);
    await say(FLEET, frame(3, 7, 0));
    expect(session.rows.map((row) => row.id)).toEqual([7]);
    expect([session.fleet.size, session.fleet.trails.length(0), session.replay.positionS]).toEqual([1, 1, 3]);
    expect([texts(), news, restarts]).toEqual([['at two'], [], [true]]);
    expect(asked.filter((path) => path.includes('events'))).toEqual(['/api/v1/events?after=0']);
  });

  it('what happens as it goes on is news', async () => {
    const { session, say, hello, texts } = started();
    const news: string[] = [];
    session.onEvent(({ text }) => news.push(text));
    await say(hello, replaying({ playing: true }), FLEET, frame(5, 1, 0), { type: 'event', ...event(3, 5, 'now') });
    expect([texts(), news]).toEqual([['now'], ['now']]);
  });

  it('two jumps close to each other leave the events of the second', async () => {
    const { say, hello, texts } = started();
    await say(hello, replaying(), FLEET, frame(5, 1, 0));
    const answers: ((events: unknown) => void)[] = [];
    vi.stubGlobal('fetch', () => new Promise((resolve) => answers.push((found) => resolve({ ok: true, json: async () => ({ events: found }) }))));
    await say(replaying({ jumps: 2 }), frame(6, 1, 0), replaying({ jumps: 3 }), frame(1, 1, 0));
    answers[1]?.([event(1, 0.5, 'second')]);
    await vi.advanceTimersByTimeAsync(0);
    answers[0]?.([event(1, 0.5, 'first'), event(2, 5.5, 'first too')]);
    await vi.advanceTimersByTimeAsync(0);
    expect(texts()).toEqual(['second']);
  });

  it('a connection that comes back to another moment of it is no restart of the server', async () => {
    const { session, say, hello, reconnect, texts, restarts } = started();
    await say(hello, replaying({ playing: true, rate: 20 }), FLEET, frame(90, 1, 0));
    await reconnect();
    await say(hello, replaying({ jumps: 2 }), FLEET, frame(2, 1, 0));
    expect([restarts, session.canCommand, texts().some((text) => text.includes('restarted'))]).toEqual([[true], false, false]);
  });

  it('a node that flies at the same address is one, and can be commanded', async () => {
    const { session, say, hello, reconnect, restarts } = started();
    await say(hello, replaying(), FLEET, frame(50, 1, 0));
    await reconnect();
    await say(hello, FLEET, frame(2, 5, 0));
    expect([session.replay.on, session.canCommand, restarts]).toEqual([false, true, [false]]);
    expect(session.rows.map((row) => row.id)).toEqual([5]);
  });

  it('in the place of a node that flew is of other vehicles, and nothing can be commanded from its first word on', async () => {
    const { session, say, hello, reconnect, restarts } = started();
    await say(hello, FLEET, frame(50, 1, 0));
    await reconnect();
    await say(hello, replaying());
    expect(session.canCommand).toBe(false);
    await say(FLEET, frame(2, 5, 0));
    expect([session.canCommand, restarts]).toEqual([false, [false]]);
  });
});

describe('a node that flies', () => {
  it('whose clock is behind where it should be is another run of it', async () => {
    const { say, hello, reconnect, texts, restarts } = started();
    await say(hello, FLEET, frame(60, 1, 0));
    await reconnect();
    await say(hello, FLEET, frame(2, 1, 0));
    expect([restarts, texts().some((text) => text === 'the server was restarted')]).toEqual([[false], true]);
  });
});
