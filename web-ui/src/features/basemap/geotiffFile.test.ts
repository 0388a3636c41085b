import { describe, expect, it } from 'vitest';
import { FaultyFile, GeotiffFile } from './geotiffFile';
import type { Fault } from './geotiffFile';
import { BlockCache } from './geotiffRaster';
import { madeTiff, projected } from './tiffFixture';
import type { MadePicture, MadePlace } from './tiffFixture';

const PLACE: MadePlace = { pixelScale: [0.5, 0.5, 0], tiepoint: [0, 0, 0, 465_000, 5_249_000, 0], keys: projected(32632) };
/** Column and row can be read out of a pixel. */
const coordinates = (column: number, row: number) => [column % 256, row % 256, 7];
const picture = (more: Partial<MadePicture> = {}): MadePicture => ({ widthPx: 600, heightPx: 400, pixel: coordinates, ...more });

const opened = async (pictures: readonly MadePicture[], place = PLACE) => GeotiffFile.open(new Blob([await madeTiff(pictures, place)]));
const rgba = (patch: Awaited<ReturnType<GeotiffFile['patch']>>, x: number, y: number) =>
  patch ? [...patch.pixels.slice((y * patch.size.widthPx + x) * 4, (y * patch.size.widthPx + x) * 4 + 4)] : null;
const at = (level: number, column: number, row: number) => ({ level, column, row });

async function faultOf(file: Promise<GeotiffFile>): Promise<Fault | null> {
  return file.then(() => null, (error: unknown) => (error instanceof FaultyFile ? error.fault : null));
}

describe('a patch', () => {
  it.each<[string, Partial<MadePicture>]>([
    ['in one strip', {}],
    ['in strips', { rowsPerStrip: 7 }],
    ['in tiles', { tilePx: 64 }],
    ['in packed tiles', { tilePx: 128, deflate: true }],
  ])('of a picture %s has the pixels of its place', async (_, more) => {
    const file = await opened([picture(more)]);
    const patch = await file.patch(at(0, 1, 1));
    expect(patch?.size).toEqual({ widthPx: 256, heightPx: 144 });
    expect(rgba(patch, 0, 0)).toEqual([0, 0, 7, 255]);
    expect(rgba(patch, 200, 100)).toEqual([200, 100, 7, 255]);
    expect(rgba(await file.patch(at(0, 2, 0)), 87, 255)).toEqual([599 % 256, 255, 7, 255]);
  });

  it('is read out of the overview', async () => {
    const file = await opened([picture(), picture({ widthPx: 300, heightPx: 200, pixel: () => [1, 2, 3], tags: { 254: [1] } })]);
    expect(file.facts.pictures).toEqual([{ widthPx: 600, heightPx: 400 }, { widthPx: 300, heightPx: 200 }]);
    expect(rgba(await file.patch(at(1, 0, 0)), 9, 9)).toEqual([1, 2, 3, 255]);
    expect(rgba(await file.patch(at(0, 0, 0)), 9, 9)).toEqual([9, 9, 7, 255]);
  });

  it('without an overview is every fourth pixel', async () => {
    const patch = await (await opened([picture({ tilePx: 64 })])).patch(at(2, 0, 0));
    expect(patch?.size).toEqual({ widthPx: 150, heightPx: 100 });
    expect(rgba(patch, 10, 20)).toEqual([42, 82, 7, 255]);
  });

  it('takes no page and no mask for an overview', async () => {
    const file = await opened([picture(), picture({ widthPx: 300, heightPx: 200 }), picture({ widthPx: 150, heightPx: 100, pixel: () => [1], tags: { 254: [5] } })]);
    expect(file.facts.pictures).toHaveLength(1);
  });
});

describe('what is not to be seen', () => {
  const half = (seen: number[], unseen: number[]) => (column: number) => (column < 300 ? seen : unseen);

  it.each<[string, Partial<MadePicture>, MadePlace]>([
    ['is opacity 0', { pixel: half([5, 6, 7, 255], [5, 6, 7, 0]), tags: { 338: [2] } }, PLACE],
    ['is the value for nothing', { pixel: half([5, 6, 7], [0, 0, 0]) }, { ...PLACE, noData: 0 }],
  ])('%s', async (_, more, place) => {
    const file = await opened([picture(more)], place);
    expect(rgba(await file.patch(at(0, 0, 0)), 9, 9)).toEqual([5, 6, 7, 255]);
    expect(rgba(await file.patch(at(0, 1, 0)), 100, 9)![3]).toBe(0);
    expect(await file.patch(at(0, 2, 0))).toBeNull();
  });

  it('a single black value is no such thing', async () => {
    expect(rgba(await (await opened([picture({ pixel: () => [0, 6, 0] })], { ...PLACE, noData: 0 })).patch(at(0, 0, 0)), 0, 0)).toEqual([0, 6, 0, 255]);
  });

  it('is where the mask is 0', async () => {
    const file = await opened([picture({ pixel: () => [5, 6, 7] }), picture({ pixel: (column) => [column < 300 ? 255 : 0], tags: { 254: [4] } })]);
    expect(rgba(await file.patch(at(0, 0, 0)), 9, 9)).toEqual([5, 6, 7, 255]);
    expect(rgba(await file.patch(at(0, 1, 0)), 100, 9)![3]).toBe(0);
  });
});

describe('colours', () => {
  it.each<[string, Partial<MadePicture>, number[]]>([
    ['grey', { pixel: () => [99] }, [99, 99, 99, 255]],
    ['grey, white being 0', { pixel: () => [99], tags: { 262: [0] } }, [156, 156, 156, 255]],
    ['grey with opacity', { pixel: () => [99, 128], tags: { 338: [2] } }, [99, 99, 99, 128]],
    ['a palette', { pixel: () => [2], tags: { 262: [3], 320: [0x0000, 0x1000, 0xaa00, 0, 0, 0, 0xbb00, 0, 0, 0, 0xcc00, 0] } }, [0xaa, 0xbb, 0xcc, 255]],
    ['colours multiplied by the opacity', { pixel: () => [50, 100, 25, 128], tags: { 338: [1] } }, [100, 199, 50, 128]],
    ['a fourth value of another kind', { pixel: () => [50, 100, 25, 0], tags: { 338: [0] } }, [50, 100, 25, 255]],
  ])('%s', async (_, more, expected) => {
    expect(rgba(await (await opened([picture(more)])).patch(at(0, 0, 0)), 3, 3)).toEqual(expected);
  });
});

describe('a file that cannot be shown', () => {
  it.each<[string, () => Promise<BlobPart>, Fault]>([
    ['no TIFF', async () => 'II*\0 and then nothing of the kind', { kind: 'no-tiff' }],
    ['nothing', async () => '', { kind: 'no-tiff' }],
    ['heights', () => madeTiff([picture({ bits: 16, pixel: () => [430] })], PLACE), { kind: 'depth', bits: 16 }],
    ['inks', () => madeTiff([picture({ pixel: () => [1, 2, 3, 4], tags: { 262: [5] } })], PLACE), { kind: 'colours' }],
    ['ZSTD', () => madeTiff([picture({ tags: { 259: [50000] } })], PLACE), { kind: 'compression', method: 'ZSTD' }],
    ['JPEG that is none', () => madeTiff([picture({ tags: { 259: [7] } })], PLACE), { kind: 'damaged' }],
  ])('%s', async (_, made, fault) => expect(await faultOf(GeotiffFile.open(new Blob([await made()])))).toEqual(fault));

  it('one whose end is missing', async () => {
    const whole = await madeTiff([picture({ tilePx: 64 })], PLACE);
    // The pixels of the last block are gone, the directory is there.
    const view = new DataView(whole.buffer);
    const cut = new Uint8Array([...whole.slice(0, 8), ...whole.slice(view.getUint32(4, true))]);
    expect(await faultOf(GeotiffFile.open(new Blob([cut])))).not.toBeNull();
  });

  it('one in a single part of 400 million values', async () => {
    const file = await madeTiff([picture()], PLACE);
    const view = new DataView(file.buffer);
    const start = view.getUint32(4, true) + 2;
    for (let k = 0; k < view.getUint16(start - 2, true); k++) {
      if ([256, 257, 278].includes(view.getUint16(start + k * 12, true))) view.setUint32(start + k * 12 + 8, 20_000, true);
    }
    expect(await faultOf(GeotiffFile.open(new Blob([file])))).toEqual({ kind: 'large-blocks' });
  });
});

describe('BlockCache', () => {
  it('keeps what was used last, and no more than it may but for one', async () => {
    const cache = new BlockCache(10);
    const read: string[] = [];
    const get = (key: string, bytes: number) => cache.get(key, async () => (read.push(key), new Uint8Array(bytes)));
    await get('a', 4);
    await get('b', 4);
    await get('a', 4);
    await get('c', 4);
    await get('a', 4);
    await get('b', 4);
    expect(read).toEqual(['a', 'b', 'c', 'b']);
    await get('large', 20);
    await get('large', 20);
    expect(read).toEqual(['a', 'b', 'c', 'b', 'large']);
  });
});
