// Which decoder a picture wants, and which pictures a decoder is given.

import { describe, expect, it } from 'vitest';
import { DecoderGate, codecOf } from './h264';

const unit = (...bytes: number[]): number[] => [0, 0, 0, 1, ...bytes];
const IDR = unit(0x65, 0x88, 0x84, 0x00);
const PPS = unit(0x68, 0xce, 0x3c, 0x80);

describe('the decoder that a picture wants', () => {
  it('stands in its sequence parameter set', () => {
    const baseline = new Uint8Array([...unit(0x67, 0x42, 0xc0, 0x1f, 0xda), ...PPS, ...IDR]);
    expect(codecOf(baseline)).toBe('avc1.42c01f');
    const high = new Uint8Array([...unit(0x09, 0xf0), ...unit(0x67, 0x64, 0x00, 0x0a, 0xac), ...PPS, ...IDR]);
    expect(codecOf(high)).toBe('avc1.64000a');
  });

  it('is found after a short start code, and with other importance of the unit', () => {
    expect(codecOf(new Uint8Array([0, 0, 1, 0x27, 0x4d, 0x40, 0x28, 0xec]))).toBe('avc1.4d4028');
  });

  it('is not known where there is none, or it is cut off', () => {
    for (const bytes of [[], [0, 0, 1], IDR, [...PPS, ...IDR], [0, 0, 0, 1, 0x67, 0x42, 0xc0], [0x67, 0x42, 0xc0, 0x1f, 0, 0, 0]]) {
      expect(codecOf(new Uint8Array(bytes))).toBeNull();
    }
  });
});

describe('a decoder', () => {
  const key = { key: true, gap: false };
  const between = { key: false, gap: false };
  const after = { key: false, gap: true };

  it('is given pictures from one that stands alone on', () => {
    const gate = new DecoderGate();
    expect([between, between, key, between, key, between].map((one) => gate.take(one, 0))).toEqual(['ask', 'ask', 'feed', 'feed', 'feed', 'feed']);
  });

  it('is given none whose forerunner was left out', () => {
    const gate = new DecoderGate();
    expect([key, after, between, { key: true, gap: true }, between].map((one) => gate.take(one, 0))).toEqual(['feed', 'ask', 'ask', 'feed', 'feed']);
  });

  it('that cannot follow catches up with the next that stands alone, not before its queue is short', () => {
    const gate = new DecoderGate();
    gate.take(key, 0);
    expect(gate.take(between, 5)).toBe('feed');
    expect(gate.take(between, 6)).toBe('ask');
    expect(gate.take(between, 0)).toBe('ask');
    expect(gate.take(key, 6)).toBe('ask');
    expect(gate.take(key, 2)).toBe('feed');
  });

  it('that was made anew begins anew', () => {
    const gate = new DecoderGate();
    gate.take(key, 0);
    gate.close();
    expect([gate.take(between, 0), gate.take(key, 0)]).toEqual(['ask', 'feed']);
  });
});
