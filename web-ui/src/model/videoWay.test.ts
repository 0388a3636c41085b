// Which way is taken: by what the browser has, by choice, after failures.

import { describe, expect, it } from 'vitest';
import { WayPicker, abilities, isSilent } from './videoWay';

const ALL = { webcodecs: true, webrtc: true, jpeg: true };
const PLAIN = { webcodecs: false, webrtc: true, jpeg: true };
const OLD = { webcodecs: false, webrtc: false, jpeg: true };

describe('what a browser has', () => {
  const video = { HTMLVideoElement: { prototype: { requestVideoFrameCallback: null } } };

  it('is found on it', () => {
    expect(abilities({ VideoDecoder: null, EncodedVideoChunk: null, RTCPeerConnection: null, ...video })).toEqual(ALL);
    expect(abilities({ RTCPeerConnection: null, ...video })).toEqual(PLAIN);
    expect(abilities({})).toEqual(OLD);
  });

  it('is not WebRTC where a picture cannot be told from the one before', () => {
    expect(abilities({ RTCPeerConnection: null }).webrtc).toBe(false);
  });
});

describe('the way', () => {
  it('is the best that there is', () => {
    expect([ALL, PLAIN, OLD].map((able) => new WayPicker('automatic', able).way(0))).toEqual(['webcodecs', 'webrtc', 'jpeg']);
  });

  it('is the next one after a failure, and the first again when that is long ago', () => {
    const picker = new WayPicker('automatic', ALL);
    picker.failed('webcodecs', 1000);
    expect([picker.way(1000), picker.isSound(1000)]).toEqual(['webrtc', true]);
    picker.failed('webrtc', 7000);
    expect(picker.way(7000)).toBe('jpeg');
    expect(picker.way(120_999)).toBe('jpeg');
    expect(picker.way(121_000)).toBe('webcodecs');
  });

  it('is the one that failed first, when all have', () => {
    const picker = new WayPicker('automatic', ALL);
    for (const [k, way] of (['webcodecs', 'webrtc', 'jpeg'] as const).entries()) picker.failed(way, 1000 * (k + 1));
    expect([picker.way(4000), picker.isSound(4000)]).toEqual(['webcodecs', false]);
    picker.failed('webcodecs', 4000);
    expect(picker.way(4000)).toBe('webrtc');
    const only = new WayPicker('automatic', OLD);
    only.failed('jpeg', 0);
    expect(only.way(1)).toBe('jpeg');
  });

  it('is what was chosen, whatever becomes of it, or none', () => {
    const picker = new WayPicker('webrtc', ALL);
    picker.failed('webrtc', 0);
    expect(picker.way(1)).toBe('webrtc');
    picker.choose('jpeg');
    expect(picker.way(1)).toBe('jpeg');
    picker.choose('automatic');
    expect(picker.way(1)).toBe('webcodecs');
    const without = new WayPicker('webcodecs', PLAIN);
    expect([without.way(0), without.isSound(0)]).toEqual([null, false]);
  });
});

describe('a decoder', () => {
  it('may fail once in ten seconds', () => {
    const picker = new WayPicker('automatic', ALL);
    expect([0, 10_000, 19_999].map((at) => picker.decoderFailed(at))).toEqual([false, false, true]);
  });

  it('that took the way with it begins with none', () => {
    const picker = new WayPicker('automatic', ALL);
    picker.decoderFailed(0);
    expect(picker.decoderFailed(5000)).toBe(true);
    picker.failed('webcodecs', 5000);
    expect(picker.decoderFailed(6000)).toBe(false);
  });
});

describe('a way without pictures', () => {
  it('has five seconds from the latest of all that counts', () => {
    expect(isSilent(6000, 0, 1000, null, 30)).toBe(false);
    expect(isSilent(6001, 0, 1000, null, 30)).toBe(true);
    expect(isSilent(8000, 4000, 1000, null, 30)).toBe(false);
    expect(isSilent(9001, 0, 1000, 4000, 30)).toBe(true);
    expect(isSilent(8999, 0, 1000, 4000, 30)).toBe(false);
  });

  it('does not fail while the stream is not live, nor between two pictures of a slow one', () => {
    expect(isSilent(1e6, 0, null, null, 30)).toBe(false);
    expect(isSilent(40_000, 0, 0, 1000, 0.1)).toBe(false);
    expect(isSilent(60_000, 0, 0, 1000, 0.1)).toBe(true);
    expect(isSilent(6000, 0, 0, null, 0)).toBe(true);
  });
});
