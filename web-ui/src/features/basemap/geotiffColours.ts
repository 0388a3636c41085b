// Values of a TIFF into red, green, blue and opacity. Pure.

/** How the values of a pixel are meant. `alpha` is the place of the opacity among them, or null. */
export type Colouring =
  | { readonly kind: 'grey'; readonly most: number; readonly inverted: boolean; readonly alpha: number | null; readonly noData: number | null }
  | { readonly kind: 'rgb' | 'ycbcr'; readonly alpha: number | null; readonly premultiplied: boolean; readonly noData: number | null }
  | { readonly kind: 'palette'; readonly map: ArrayLike<number>; readonly noData: number | null };

/** Values that are colours, without the opacity. */
const coloursOf = (kind: Colouring['kind']): number => (kind === 'rgb' || kind === 'ycbcr' ? 3 : 1);

/** Which values of a pixel are read, in this order. */
export function samplesOf(colouring: Colouring): number[] {
  const samples = Array.from({ length: coloursOf(colouring.kind) }, (_, k) => k);
  return colouring.kind !== 'palette' && colouring.alpha !== null ? [...samples, colouring.alpha] : samples;
}

/** Paints what `samplesOf` has asked for. Returns whether anything is to be seen. */
export function paint(values: Uint8Array, colouring: Colouring, out: Uint8ClampedArray): boolean {
  const colours = coloursOf(colouring.kind);
  const step = samplesOf(colouring).length;
  let seen = false;
  for (let from = 0, to = 0; from < values.length; from += step, to += 4) {
    if (isNoData(values, from, colours, colouring.noData)) continue;
    const alpha = step > colours ? values[from + colours]! : 255;
    if (alpha === 0) continue;
    seen = true;
    colour(values, from, colouring, out, to);
    out[to + 3] = alpha;
    if (alpha < 255 && 'premultiplied' in colouring && colouring.premultiplied) {
      for (let k = to; k < to + 3; k++) out[k] = (out[k]! * 255) / alpha;
    }
  }
  return seen;
}

/** All colours have to be the value that means nothing: black alone is also a shadow's. */
function isNoData(values: Uint8Array, from: number, colours: number, noData: number | null): boolean {
  if (noData === null) return false;
  for (let k = 0; k < colours; k++) if (values[from + k] !== noData) return false;
  return true;
}

function colour(values: Uint8Array, from: number, colouring: Colouring, out: Uint8ClampedArray, to: number): void {
  const [first, second, third] = [values[from]!, values[from + 1]!, values[from + 2]!];
  switch (colouring.kind) {
    case 'grey': {
      const grey = (first * 255) / colouring.most;
      out.fill(colouring.inverted ? 255 - grey : grey, to, to + 3);
      return;
    }
    case 'palette': {
      // All reds, then all greens, then all blues, with 16 bits.
      const length = colouring.map.length / 3;
      for (let k = 0; k < 3; k++) out[to + k] = (colouring.map[k * length + first] ?? 0) >> 8;
      return;
    }
    case 'rgb':
      out[to] = first;
      out[to + 1] = second;
      out[to + 2] = third;
      return;
    case 'ycbcr':
      out[to] = first + 1.402 * (third - 128);
      out[to + 1] = first - 0.344136 * (second - 128) - 0.714136 * (third - 128);
      out[to + 2] = first + 1.772 * (second - 128);
  }
}
