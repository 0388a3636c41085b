// The node's clock as a simulated camera draws it into its pictures, so that the time from glass to glass can be measured: a strip of cells, white
// or black. The reading itself is pure; the reader beside it looks at what is shown. Must never read back more of a picture than the strip.

/** A cell is so many of the picture's width. */
const CELLS_ACROSS = 80;
/** White and black to compare with, 32 bits of milliseconds, 4 bits of checksum. */
const TIME_BITS = 32;
const SUM_BITS = 4;
const LEVELS = 2;
export const STRIP_CELLS = LEVELS + TIME_BITS + SUM_BITS;
/** White and black that are nearer to each other are no strip. */
const LEAST_CONTRAST = 60;

/** So much of a picture's upper left corner holds the strip, in cells. */
const CORNER_CELLS = { width: STRIP_CELLS + 2, height: 2 };
/** The corner of a larger picture is made smaller before it is read back. */
const MOST_WIDTH_PX = 640;

/** Cells of a time, from the left: what the camera draws. */
export function cellsOf(timeMs: number): boolean[] {
  const time = timeMs >>> 0;
  const bit = (value: number, at: number): boolean => ((value >>> at) & 1) === 1;
  const time32 = Array.from({ length: TIME_BITS }, (_, k) => bit(time, TIME_BITS - 1 - k));
  const sum4 = Array.from({ length: SUM_BITS }, (_, k) => bit(checksum(time), SUM_BITS - 1 - k));
  return [true, false, ...time32, ...sum4];
}

function checksum(time: number): number {
  let sum = 0;
  for (let shift = 0; shift < TIME_BITS; shift += SUM_BITS) sum += (time >>> shift) & 15;
  return sum & 15;
}

/** The clock in a picture, or in its upper left corner: milliseconds modulo 2^32, or null where there is none to be read. */
export function readClock(pixels: Pick<ImageData, 'data' | 'width' | 'height'>, widthPx: number): number | null {
  const cell = widthPx / CELLS_ACROSS;
  if (pixels.width < cell * (STRIP_CELLS + 1) || pixels.height < cell * 1.5) return null;
  const levels = Array.from({ length: STRIP_CELLS }, (_, k) => brightness(pixels, (k + 1.5) * cell, 1.5 * cell, cell / 4));
  const [white = 0, black = 0, ...rest] = levels;
  if (white - black < LEAST_CONTRAST) return null;
  const middle = (white + black) / 2;
  const number = (bits: number[]): number => bits.reduce((value, level) => ((value << 1) | (level > middle ? 1 : 0)) >>> 0, 0);
  const time = number(rest.slice(0, TIME_BITS));
  return number(rest.slice(TIME_BITS)) === checksum(time) ? time : null;
}

/** Mean of the pixels about a place, at most `reach` away: what compression and noise do to one of them does not count. */
function brightness(pixels: Pick<ImageData, 'data' | 'width' | 'height'>, x: number, y: number, reach: number): number {
  const [left, right] = [Math.floor(x - reach), Math.max(Math.ceil(x + reach), Math.floor(x - reach) + 1)];
  const [top, bottom] = [Math.floor(y - reach), Math.max(Math.ceil(y + reach), Math.floor(y - reach) + 1)];
  let sum = 0;
  let count = 0;
  for (let row = top; row < Math.min(bottom, pixels.height); row++) {
    for (let column = left; column < Math.min(right, pixels.width); column++) {
      const at = (row * pixels.width + column) * 4;
      sum += ((pixels.data[at] ?? 0) + (pixels.data[at + 1] ?? 0) + (pixels.data[at + 2] ?? 0)) / 3;
      count++;
    }
  }
  return count === 0 ? 0 : sum / count;
}

const WRAP_MS = 2 ** 32;

/** From the moment in a picture to a moment of the node's clock, in ms; both may have gone round. */
export function sinceClock(nodeMs: number, clockMs: number): number {
  const apart = (((nodeMs - clockMs) % WRAP_MS) + WRAP_MS) % WRAP_MS;
  return apart >= WRAP_MS / 2 ? apart - WRAP_MS : apart;
}

/** After so many pictures without a strip there is probably none: to look costs. */
const LOOKS = 40;
const SELDOM = 30;

/** Reads the clock out of what is shown. */
export class ClockReader {
  #context: CanvasRenderingContext2D | null = null;
  #missed = 0;

  read(source: CanvasImageSource, widthPx: number, heightPx: number): number | null {
    if (widthPx <= 0 || heightPx <= 0) return null;
    if (this.#missed >= LOOKS && this.#missed % SELDOM !== 0) {
      this.#missed++;
      return null;
    }
    const shownPx = Math.min(widthPx, MOST_WIDTH_PX);
    const clock = readClock(this.#corner(source, widthPx, shownPx), shownPx);
    this.#missed = clock === null ? this.#missed + 1 : 0;
    return clock;
  }

  #corner(source: CanvasImageSource, widthPx: number, shownPx: number): ImageData {
    this.#context ??= document.createElement('canvas').getContext('2d', { willReadFrequently: true, alpha: false });
    const context = this.#context;
    const of = (px: number, cells: number): number => Math.ceil((px / CELLS_ACROSS) * cells);
    const [width, height] = [of(shownPx, CORNER_CELLS.width), of(shownPx, CORNER_CELLS.height)];
    if (!context) return new ImageData(width, height);
    if (context.canvas.width !== width || context.canvas.height !== height) Object.assign(context.canvas, { width, height });
    const scale = widthPx / shownPx;
    context.drawImage(source, 0, 0, width * scale, height * scale, 0, 0, width, height);
    return context.getImageData(0, 0, width, height);
  }
}
