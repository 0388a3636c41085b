// A large picture cut into patches, at full size and at half of it again and again: which of them a view needs, and out of which picture of
// the file each is read. Level 0 is full size. Pure.

/** Pixels of a patch each way. */
export const PATCH_PX = 256;

export type Size = { readonly widthPx: number; readonly heightPx: number };
/** A rectangle in pixels of full size. */
export type Box = { readonly left: number; readonly top: number; readonly right: number; readonly bottom: number };
export type Place = { readonly level: number; readonly column: number; readonly row: number };

/** How many levels there are: the last is one patch. */
export function levelsOf({ widthPx, heightPx }: Size): number {
  return Math.max(0, Math.ceil(Math.log2(Math.max(widthPx, heightPx) / PATCH_PX))) + 1;
}

/** The level that is about as fine as the map is. */
export function levelFor(metresPerPixel: number, pixelM: number, levels: number): number {
  const exact = Math.log2(metresPerPixel / pixelM);
  if (Number.isNaN(exact)) return 0;
  return Math.max(0, Math.min(levels - 1, Math.round(exact)));
}

/** The picture of the file (finest first) out of which a level is read: the coarsest that is still fine enough, and how many of its pixels
 *  one of the patch is. */
export function pictureFor(level: number, pictures: readonly Size[]): { index: number; step: number } {
  const [full] = pictures;
  if (!full) throw new RangeError('a file without a picture');
  const factor = 2 ** level;
  let [index, step] = [0, factor];
  pictures.forEach((picture, k) => {
    const of = (factor * picture.widthPx) / full.widthPx;
    // Overviews are rounded to whole pixels: one that is a little too coarse is the one that was meant.
    if (of >= 0.98 && of < step) [index, step] = [k, of];
  });
  return { index, step };
}

/** The patches of a level in a box, nearest to its middle first; null: more than `most`. */
export function patchesIn(box: Box, level: number, { widthPx, heightPx }: Size, most: number): Place[] | null {
  const side = PATCH_PX * 2 ** level;
  const last = (sizePx: number) => Math.ceil(sizePx / side) - 1;
  const [c0, c1] = [Math.max(0, Math.floor(box.left / side)), Math.min(last(widthPx), Math.floor(box.right / side))];
  const [r0, r1] = [Math.max(0, Math.floor(box.top / side)), Math.min(last(heightPx), Math.floor(box.bottom / side))];
  if (!(c0 <= c1 && r0 <= r1)) return [];
  if ((c1 - c0 + 1) * (r1 - r0 + 1) > most) return null;
  const places: Place[] = [];
  for (let row = r0; row <= r1; row++) for (let column = c0; column <= c1; column++) places.push({ level, column, row });
  const middle = { x: (box.left + box.right) / 2 / side - 0.5, y: (box.top + box.bottom) / 2 / side - 0.5 };
  const distance = (p: Place) => Math.hypot(p.column - middle.x, p.row - middle.y);
  return places.sort((a, b) => distance(a) - distance(b));
}

/** What of the picture at full size a patch is. At the edge it ends with the pixel of its level that the edge goes through. */
export function boxOf({ level, column, row }: Place, { widthPx, heightPx }: Size): Box & Size {
  const factor = 2 ** level;
  const [left, top] = [column * PATCH_PX * factor, row * PATCH_PX * factor];
  const wide = Math.min(PATCH_PX, Math.ceil((widthPx - left) / factor));
  const high = Math.min(PATCH_PX, Math.ceil((heightPx - top) / factor));
  return { left, top, right: left + wide * factor, bottom: top + high * factor, widthPx: wide, heightPx: high };
}
