// The clock in the picture: drawn here as the camera draws it, read back, blurred, noisy and wrong.

import { describe, expect, it } from 'vitest';
import { STRIP_CELLS, cellsOf, readClock, sinceClock } from './clockStrip';

type Pixels = { data: Uint8ClampedArray<ArrayBuffer>; width: number; height: number };

/** Numbers that look drawn by chance and are the same every time. */
function chance(seed: number): () => number {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/** A picture of this width with the cells of a strip, white and black as given. */
function drawn(widthPx: number, cells: boolean[], { white = 235, black = 20, noise = 0, height = Math.ceil(widthPx / 20) } = {}): Pixels {
  const data = new Uint8ClampedArray(widthPx * height * 4).fill(120);
  const cell = widthPx / 80;
  const random = chance(1);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < widthPx; x++) {
      const k = Math.floor(x / cell) - 1;
      const inside = y >= cell && y < 2 * cell && k >= 0 && k < cells.length;
      const level = inside ? (cells[k] ? white : black) : 120;
      for (let part = 0; part < 3; part++) data[(y * widthPx + x) * 4 + part] = level + (random() - 0.5) * noise;
    }
  }
  return { data, width: widthPx, height };
}

const TIMES = [0, 1, 15, 16, 1_234_567, 0x7fffffff, 0x80000000, 0xdeadbeef, 0xffffffff];

describe('the strip', () => {
  it('is two levels, 32 bits and a checksum', () => {
    const cells = cellsOf(0x00000012);
    expect(cells).toHaveLength(STRIP_CELLS);
    expect(cells.slice(0, 2)).toEqual([true, false]);
    expect(cells.slice(2, 34).map(Number).join('')).toBe('00000000000000000000000000010010');
    expect(cells.slice(34).map(Number).join('')).toBe('0011');
  });

  it.each([160, 320, 424, 640, 1000, 1920])('is read in a picture %i wide', (width) => {
    for (const time of TIMES) expect(readClock(drawn(width, cellsOf(time)), width), `${time}`).toBe(time);
  });

  it('goes round after 2^32 milliseconds', () => {
    expect(readClock(drawn(640, cellsOf(2 ** 32 + 5)), 640)).toBe(5);
  });

  it('is read through noise, and in weak contrast', () => {
    for (const time of TIMES) {
      expect(readClock(drawn(640, cellsOf(time), { noise: 120 }), 640), `${time}`).toBe(time);
      expect(readClock(drawn(640, cellsOf(time), { white: 150, black: 85, noise: 10 }), 640), `${time}`).toBe(time);
    }
  });

  it('is read out of the corner that holds it', () => {
    const whole = drawn(640, cellsOf(99_000), { height: 480 });
    const corner: Pixels = { data: new Uint8ClampedArray(320 * 16 * 4), width: 320, height: 16 };
    for (let y = 0; y < 16; y++) corner.data.set(whole.data.subarray(y * 640 * 4, y * 640 * 4 + 320 * 4), y * 320 * 4);
    expect(readClock(corner, 640)).toBe(99_000);
  });
});

describe('no strip', () => {
  it('is where the checksum is wrong', () => {
    for (let k = 2; k < STRIP_CELLS; k++) {
      const cells = cellsOf(1_234_567);
      cells[k] = !cells[k];
      expect(readClock(drawn(640, cells), 640), `cell ${k}`).toBeNull();
    }
  });

  it('is where white and black are much the same, or the other way round', () => {
    expect(readClock(drawn(640, cellsOf(5), { white: 120, black: 61 }), 640)).toBeNull();
    expect(readClock(drawn(640, cellsOf(5), { white: 20, black: 235 }), 640)).toBeNull();
    expect(readClock(drawn(640, []), 640)).toBeNull();
  });

  it('is in a piece that is too small', () => {
    expect(readClock({ data: new Uint8ClampedArray(300 * 16 * 4), width: 300, height: 16 }, 640)).toBeNull();
    expect(readClock({ data: new Uint8ClampedArray(320 * 4 * 4), width: 320, height: 4 }, 640)).toBeNull();
    expect(readClock({ data: new Uint8ClampedArray(0), width: 0, height: 0 }, 640)).toBeNull();
  });
});

describe('from glass to glass', () => {
  it('is the time between, also around the end of the clock', () => {
    expect(sinceClock(5120, 5000)).toBe(120);
    expect(sinceClock(2 ** 32 + 20, 2 ** 32 - 100)).toBe(120);
    expect(sinceClock(2 ** 33 + 20, 20)).toBe(0);
    expect(sinceClock(20, 2 ** 32 - 100)).toBe(120);
    // A clock that is estimated a little wrong.
    expect(sinceClock(5000, 5003)).toBe(-3);
  });
});
