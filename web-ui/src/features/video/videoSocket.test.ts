// The socket of a stream: pictures, states, pings and their answers, silence, the end. The browser's WebSocket is stood in for, time is the test's.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { PICTURE_HEADER_BYTES } from '../../protocol/video';
import type { Picture, VideoStreamView } from '../../protocol/video';
import { VideoSocket } from './videoSocket';

class Socket {
  static newest: Socket;
  static readonly OPEN = 1;
  readyState = 0;
  sent: string[] = [];
  onopen: (() => void) | null = null;
  onmessage: ((message: { data: unknown }) => void) | null = null;
  onclose: ((event: { reason: string }) => void) | null = null;
  constructor(readonly url: string) {
    Socket.newest = this;
  }
  send(text: string): void {
    this.sent.push(text);
  }
  close(): void {
    this.readyState = 3;
  }
  open(): void {
    this.readyState = 1;
    this.onopen?.();
  }
  say(message: object): void {
    this.onmessage?.({ data: message instanceof ArrayBuffer ? message : JSON.stringify(message) });
  }
}

function opened() {
  const heard = { pictures: [] as Picture[], states: [] as VideoStreamView[], closed: [] as [string, boolean][] };
  const socket = new VideoSocket('ws://test/', {
    picture: (picture) => heard.pictures.push(picture),
    state: (view) => heard.states.push(view),
    closed: (...how) => heard.closed.push(how),
  });
  return { socket, heard, wire: Socket.newest };
}

const PICTURE = new Uint8Array(PICTURE_HEADER_BYTES + 1);
PICTURE.set([1, 2]);

beforeEach(() => {
  vi.stubGlobal('WebSocket', Socket);
  vi.useFakeTimers({ toFake: ['setInterval', 'clearInterval', 'performance'] });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe('the socket of a stream', () => {
  it('hands on pictures and states, and counts what it cannot read', () => {
    const { socket, heard, wire } = opened();
    wire.open();
    wire.say({ type: 'state', state: 'live', vehicle: 2 });
    wire.say(PICTURE.buffer);
    wire.say(new ArrayBuffer(3));
    wire.say({ type: 'news' });
    expect(heard.states).toMatchObject([{ state: 'live', vehicle: 2 }]);
    expect(heard.pictures).toMatchObject([{ kind: 'jpeg' }]);
    expect(socket.unreadable).toBe(2);
  });

  it('pings when it is open and every two seconds, and learns the clock from the answers', () => {
    const { socket, wire } = opened();
    expect(wire.sent).toEqual([]);
    wire.open();
    expect(wire.sent).toEqual(['{"type":"ping","id":1}']);
    const sent = performance.now();
    vi.advanceTimersByTime(40);
    wire.say({ type: 'pong', id: 1, time_us: 9_000_000 });
    expect(socket.clock.nodeMs(sent + 20)).toBe(9000);
    vi.advanceTimersByTime(2000);
    expect(wire.sent).toHaveLength(2);
    // An answer to nothing that was asked says nothing.
    wire.say({ type: 'pong', id: 77, time_us: 1 });
    wire.say({ type: 'pong', id: 1, time_us: 1 });
    expect(socket.clock.nodeMs(sent + 20)).toBe(9000);
  });

  it('asks for a key picture at most twice a second', () => {
    const { socket, wire } = opened();
    wire.open();
    wire.sent = [];
    for (let k = 0; k < 10; k++) {
      socket.askKey();
      vi.advanceTimersByTime(100);
    }
    expect(wire.sent).toEqual(['{"type":"key"}', '{"type":"key"}']);
  });

  it('says why it is over, and whether anything was ever heard', () => {
    const first = opened();
    first.wire.onclose?.({ reason: '' });
    expect(first.heard.closed).toEqual([['the server does not give the stream', true]]);
    const second = opened();
    second.wire.open();
    second.wire.say({ type: 'state', state: 'starting' });
    second.wire.onclose?.({ reason: 'the camera is gone' });
    expect(second.heard.closed).toEqual([['the camera is gone', false]]);
  });

  it('is given up when it says nothing', () => {
    const { heard, wire } = opened();
    wire.open();
    vi.advanceTimersByTime(3000);
    wire.say({ type: 'state', state: 'live' });
    vi.advanceTimersByTime(6000);
    expect(heard.closed).toEqual([]);
    vi.advanceTimersByTime(1000);
    expect(heard.closed).toEqual([['the server has gone silent', false]]);
    expect(wire.readyState).toBe(3);
    const never = opened();
    vi.advanceTimersByTime(8500);
    expect(never.heard.closed).toEqual([['the server has gone silent', true]]);
  });

  it('that is closed says nothing any more', () => {
    const { socket, heard, wire } = opened();
    wire.open();
    const { onmessage } = wire;
    socket.close();
    vi.advanceTimersByTime(60_000);
    expect([wire.onmessage, wire.onclose, onmessage === null]).toEqual([null, null, false]);
    expect(heard.closed).toEqual([]);
    expect(wire.sent).toHaveLength(1);
  });
});
