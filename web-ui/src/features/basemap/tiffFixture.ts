// Makes GeoTIFF files for tests, by the bytes. Only tests may use this.

export type MadePicture = {
  readonly widthPx: number;
  readonly heightPx: number;
  /** The values of a pixel. */
  readonly pixel: (column: number, row: number) => readonly number[];
  /** Side of a tile; without it the picture is written in strips. */
  readonly tilePx?: number;
  readonly rowsPerStrip?: number;
  readonly bits?: 8 | 16;
  readonly deflate?: boolean;
  /** Further tags of 16 bits, or others in place of those that are written anyway: number and values. */
  readonly tags?: Readonly<Record<number, readonly number[]>>;
};

export type MadePlace = {
  readonly pixelScale?: readonly number[];
  readonly tiepoint?: readonly number[];
  readonly transformation?: readonly number[];
  /** GeoKeys of 16 bits. */
  readonly keys?: Readonly<Record<number, number>>;
  readonly noData?: number;
};

type Tag = { readonly id: number; readonly type: number; readonly count: number; readonly bytes: Uint8Array };

const SHORT = 3;
const LONG = 4;
const DOUBLE = 12;
const ASCII = 2;
const HEADER_BYTES = 8;
const ENTRY_BYTES = 12;

/** Keys of a UTM zone or another projection of the EPSG. */
export const projected = (code: number): Record<number, number> => ({ 1024: 1, 1025: 1, 3072: code });
export const geographic = (code: number): Record<number, number> => ({ 1024: 2, 1025: 1, 2048: code });

/** The first picture is the one at full size and has the place. */
export async function madeTiff(pictures: readonly MadePicture[], place: MadePlace): Promise<Uint8Array<ArrayBuffer>> {
  const parts: Uint8Array[] = [];
  let length = HEADER_BYTES;
  const append = (bytes: Uint8Array): number => {
    const at = length;
    const whole = new Uint8Array(bytes.length + (bytes.length % 2));
    whole.set(bytes);
    parts.push(whole);
    length += whole.length;
    return at;
  };
  const directories: Tag[][] = [];
  for (const [k, picture] of pictures.entries()) {
    const blocks = await Promise.all(blocksOf(picture).map((block) => (picture.deflate ? deflated(block) : block)));
    directories.push(tagsOf(picture, blocks.map(append), blocks, k === 0 ? placeTags(place) : []));
  }
  const starts = directories.map((tags) => {
    const values = tags.map(({ bytes }) => (bytes.length > 4 ? append(bytes) : 0));
    return append(directory(tags, values));
  });
  const file = new Uint8Array(length);
  const view = new DataView(file.buffer);
  view.setUint32(0, 0x002a4949, true);
  view.setUint32(4, starts[0]!, true);
  let at = HEADER_BYTES;
  for (const part of parts) {
    file.set(part, at);
    at += part.length;
  }
  // Each directory ends with where the next one is.
  directories.forEach((tags, k) => view.setUint32(starts[k]! + 2 + tags.length * ENTRY_BYTES, starts[k + 1] ?? 0, true));
  return file;
}

function directory(tags: readonly Tag[], values: readonly number[]): Uint8Array {
  const bytes = new Uint8Array(2 + tags.length * ENTRY_BYTES + 4);
  const view = new DataView(bytes.buffer);
  view.setUint16(0, tags.length, true);
  tags.forEach((tag, k) => {
    const at = 2 + k * ENTRY_BYTES;
    view.setUint16(at, tag.id, true);
    view.setUint16(at + 2, tag.type, true);
    view.setUint32(at + 4, tag.count, true);
    if (tag.bytes.length > 4) view.setUint32(at + 8, values[k]!, true);
    else bytes.set(tag.bytes, at + 8);
  });
  return bytes;
}

function blocksOf({ widthPx, heightPx, pixel, tilePx, rowsPerStrip, bits }: MadePicture): Uint8Array[] {
  const [wide, high] = [tilePx ?? widthPx, tilePx ?? rowsPerStrip ?? heightPx];
  const samples = pixel(0, 0).length;
  const blocks: Uint8Array[] = [];
  for (let top = 0; top < heightPx; top += high) {
    for (let left = 0; left < widthPx; left += wide) {
      const lines = tilePx ? high : Math.min(high, heightPx - top);
      const values = new (bits === 16 ? Uint16Array : Uint8Array)(wide * lines * samples);
      for (let y = 0; y < lines && top + y < heightPx; y++) {
        for (let x = 0; x < wide && left + x < widthPx; x++) values.set(pixel(left + x, top + y), (y * wide + x) * samples);
      }
      blocks.push(new Uint8Array(values.buffer));
    }
  }
  return blocks;
}

async function deflated(block: Uint8Array): Promise<Uint8Array> {
  const packed = new Blob([block.slice()]).stream().pipeThrough(new CompressionStream('deflate'));
  return new Uint8Array(await new Response(packed).arrayBuffer());
}

const shorts = (id: number, values: readonly number[]): Tag => ({ id, type: SHORT, count: values.length, bytes: new Uint8Array(Uint16Array.from(values).buffer) });
const longs = (id: number, values: readonly number[]): Tag => ({ id, type: LONG, count: values.length, bytes: new Uint8Array(Uint32Array.from(values).buffer) });
const doubles = (id: number, values: readonly number[]): Tag => ({ id, type: DOUBLE, count: values.length, bytes: new Uint8Array(Float64Array.from(values).buffer) });

function tagsOf(picture: MadePicture, offsets: readonly number[], blocks: readonly Uint8Array[], more: readonly Tag[]): Tag[] {
  const { widthPx, heightPx, tilePx, rowsPerStrip, bits, deflate } = picture;
  const samples = picture.pixel(0, 0).length;
  const counts = blocks.map((block) => block.length);
  const own = [
    longs(256, [widthPx]), longs(257, [heightPx]), shorts(258, Array.from({ length: samples }, () => bits ?? 8)), shorts(259, [deflate ? 8 : 1]),
    shorts(262, [samples >= 3 ? 2 : 1]), shorts(277, [samples]), shorts(284, [1]),
    ...(tilePx
      ? [longs(322, [tilePx]), longs(323, [tilePx]), longs(324, offsets), longs(325, counts)]
      : [longs(273, offsets), longs(278, [rowsPerStrip ?? heightPx]), longs(279, counts)]),
    ...more,
  ];
  const others = Object.entries(picture.tags ?? {}).map(([id, values]) => shorts(Number(id), values));
  return [...own.filter(({ id }) => !others.some((other) => other.id === id)), ...others].sort((a, b) => a.id - b.id);
}

function placeTags({ pixelScale, tiepoint, transformation, keys, noData }: MadePlace): Tag[] {
  const tags: Tag[] = [];
  if (pixelScale) tags.push(doubles(33550, pixelScale));
  if (tiepoint) tags.push(doubles(33922, tiepoint));
  if (transformation) tags.push(doubles(34264, transformation));
  if (keys) {
    const entries = Object.entries(keys);
    tags.push(shorts(34735, [1, 1, 0, entries.length, ...entries.flatMap(([id, value]) => [Number(id), 0, 1, value])]));
  }
  if (noData !== undefined) {
    const text = new TextEncoder().encode(`${noData}\0`);
    tags.push({ id: 42113, type: ASCII, count: text.length, bytes: text });
  }
  return tags;
}
