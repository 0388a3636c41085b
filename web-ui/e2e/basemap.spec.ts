// The operator's own base map: pictures out of a PMTiles file or a GeoTIFF of this computer, under everything else, where they belong.

import { deflateSync } from 'node:zlib';
import { zxyToTileId } from 'pmtiles';
import type { Page } from '@playwright/test';
import { Georeference, definitionOf } from '../src/features/basemap/georeference';
import { geographic, madeTiff, projected } from '../src/features/basemap/tiffFixture';
import type { MadePicture } from '../src/features/basemap/tiffFixture';
import { cornerOf, tileAt } from '../src/features/basemap/tileMath';
import { SwarmProjection } from '../src/telemetry/geodesy';
import { findings } from './accessibility';
import { button, expect, open, plotted, test } from './console';
import { Program } from './program';

const VEHICLES = 2;
const LEVEL = 18;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

function crc32(bytes: Buffer): number {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let k = 0; k < 8; k++) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

/** A picture of one colour, 256 pixels each way. */
function png(red: number, green: number, blue: number): Buffer {
  const chunk = (type: string, data: Buffer): Buffer => {
    const body = Buffer.concat([Buffer.from(type), data]);
    const [length, crc] = [Buffer.alloc(4), Buffer.alloc(4)];
    length.writeUInt32BE(data.length);
    crc.writeUInt32BE(crc32(body));
    return Buffer.concat([length, body, crc]);
  };
  const header = Buffer.from([0, 0, 1, 0, 0, 0, 1, 0, 8, 2, 0, 0, 0]);
  const row = Buffer.from([0, ...Array.from({ length: 256 }, () => [red, green, blue]).flat()]);
  const pixels = deflateSync(Buffer.concat(Array.from({ length: 256 }, () => row)));
  return Buffer.concat([Buffer.from('89504e470d0a1a0a', 'hex'), chunk('IHDR', header), chunk('IDAT', pixels), chunk('IEND', Buffer.alloc(0))]);
}

function varint(value: number): number[] {
  const bytes: number[] = [];
  for (let rest = value; ; rest = Math.floor(rest / 128)) {
    if (rest < 128) return [...bytes, rest];
    bytes.push((rest % 128) + 128);
  }
}

/** A PMTiles file (version 3) with these pictures of one level. */
function pmtiles(tiles: readonly { x: number; y: number; picture: Buffer }[], type: number): Buffer {
  const entries = tiles.map((t) => ({ ...t, id: zxyToTileId(LEVEL, t.x, t.y) })).sort((a, b) => a.id - b.id);
  const directory = Buffer.from([
    ...varint(entries.length),
    ...entries.flatMap((e, k) => varint(e.id - (entries[k - 1]?.id ?? 0))),
    ...entries.flatMap(() => varint(1)),
    ...entries.flatMap((e) => varint(e.picture.length)),
    ...entries.flatMap((_, k) => varint(k === 0 ? 1 : 0)),
  ]);
  const metadata = Buffer.from('{}');
  const header = Buffer.alloc(127);
  header.write('PMTiles');
  header.writeUInt8(3, 7);
  const data = 127 + directory.length + metadata.length;
  const total = entries.reduce((sum, e) => sum + e.picture.length, 0);
  [127, directory.length, 127 + directory.length, metadata.length, 0, 0, data, total, entries.length, entries.length, entries.length].forEach(
    (value, k) => header.writeBigUInt64LE(BigInt(value), 8 + k * 8),
  );
  for (const [at, value] of [[96, 1], [97, 1], [98, 1], [99, type], [100, LEVEL], [101, LEVEL]] as const) header.writeUInt8(value, at);
  [-1800000000, -850000000, 1800000000, 850000000].forEach((value, k) => header.writeInt32LE(value, 102 + k * 4));
  return Buffer.concat([header, directory, metadata, ...entries.map((e) => e.picture)]);
}

/** Colour of the canvas a little beside a place, where no sign is. */
const colourAt = (page: Page, at: { x: number; y: number }) =>
  page.locator('canvas').evaluate((canvas: HTMLCanvasElement, { x, y }) => {
    const ratio = canvas.width / canvas.clientWidth;
    return [...canvas.getContext('2d')!.getImageData(Math.round(x * ratio), Math.round(y * ratio), 1, 1).data.slice(0, 3)];
  }, at);

async function load(page: Page, file: Buffer, name: string): Promise<void> {
  await page.getByLabel(/^Base map from a file/).setInputFiles({ name, mimeType: 'application/octet-stream', buffer: file });
}

test('pictures of a file lie under the vehicles, where they belong', { tag: '@long' }, async ({ page, watch }) => {
  // This test reads pixels again and again; the page never does.
  watch.expected.push(/willReadFrequently/);
  await open(page, program.url, VEHICLES);
  const [vehicle] = await plotted(page);
  const { x, y } = tileAt(vehicle!.latitudeDeg, vehicle!.longitudeDeg, LEVEL);
  // Green where the vehicle is, red around it.
  const tiles = [-2, -1, 0, 1, 2].flatMap((dx) =>
    [-2, -1, 0, 1, 2].map((dy) => ({ x: Math.floor(x) + dx, y: Math.floor(y) + dy, picture: dx === 0 && dy === 0 ? png(0, 200, 0) : png(200, 0, 0) })),
  );
  await button(page, 'Layers').click();
  await page.getByRole('checkbox', { name: 'Grid', exact: true }).uncheck();
  await load(page, pmtiles(tiles, 2), 'field.pmtiles');
  await expect(page.getByText('field.pmtiles')).toBeVisible();
  expect(await findings(page)).toEqual([]);
  await expect.poll(() => page.evaluate(() => window.__skein!.baseTiles())).toBeGreaterThan(0);
  const own = () => page.evaluate(async () => window.__skein!.positions()[0]!);
  await expect.poll(async () => {
    const { x: px, y: py } = await own();
    const [red, green] = await colourAt(page, { x: px - 34, y: py + 34 });
    return green! > red! + 50;
  }).toBe(true);
  // The tile beside it is another picture.
  for (let k = 0; k < 5; k++) await button(page, 'Zoom out').click();
  const middle = cornerOf(LEVEL, Math.floor(x) - 0.5, Math.floor(y) + 0.5);
  const { north, east } = new SwarmProjection({ latitude_deg: vehicle!.latitudeDeg, longitude_deg: vehicle!.longitudeDeg, altitude_amsl_m: 0 })
    .project(middle.latitudeDeg, middle.longitudeDeg);
  const beside = [vehicle!.northM + north, vehicle!.eastM + east];
  await expect.poll(async () => {
    const [red, green] = await colourAt(page, await page.evaluate(([n, e]) => window.__skein!.toCanvas(n!, e!), beside));
    return red! > green! + 50;
  }).toBe(true);
  await button(page, 'Remove base map').click();
  await expect.poll(() => page.evaluate(() => window.__skein!.baseTiles())).toBe(0);
});

const FIELD_PX = 1024;
const PIXEL_M = 0.25;
/** Green within this of the middle, red around it. */
const GREEN_M = 20;

/** A field in the UTM zone of a place, which is its middle; with an overview of half its size. */
async function field(utm: number, place: { latitudeDeg: number; longitudeDeg: number }): Promise<Buffer> {
  const { column: east, row: north } = new Georeference([1, 0, 0, 0, 1, 0], definitionOf(utm)!).toPixel(place);
  const picture = (sizePx: number, tags: MadePicture['tags']): MadePicture => ({
    widthPx: sizePx, heightPx: sizePx, tilePx: 256, deflate: true, tags: tags ?? {},
    pixel: (column, row) => {
      const [x, y] = [column, row].map((k) => ((k + 0.5) / sizePx - 0.5) * FIELD_PX * PIXEL_M) as [number, number];
      return Math.max(Math.abs(x), Math.abs(y)) < GREEN_M ? [0, 200, 0] : [200, 0, 0];
    },
  });
  const half = (FIELD_PX / 2) * PIXEL_M;
  return Buffer.from(await madeTiff([picture(FIELD_PX, {}), picture(FIELD_PX / 2, { 254: [1] })], {
    pixelScale: [PIXEL_M, PIXEL_M, 0], tiepoint: [0, 0, 0, east - half, north + half, 0], keys: projected(utm),
  }));
}

test('an orthophoto in a UTM zone lies under the vehicles, where it belongs', { tag: '@long' }, async ({ page, watch }) => {
  watch.expected.push(/willReadFrequently/);
  await open(page, program.url, VEHICLES);
  const [vehicle] = await plotted(page);
  const utm = (vehicle!.latitudeDeg < 0 ? 32701 : 32601) + Math.floor((vehicle!.longitudeDeg + 180) / 6);
  await button(page, 'Layers').click();
  for (const layer of ['Grid', 'Labels']) await page.getByRole('checkbox', { name: layer, exact: true }).uncheck();
  await load(page, await field(utm, vehicle!), 'orthophoto.tif');
  await expect(page.getByText('orthophoto.tif')).toBeVisible();
  expect(await findings(page)).toEqual([]);
  const green = (at: { x: number; y: number }) => async () => {
    const [red, green] = await colourAt(page, at);
    return green! - red! > 50 ? 'green' : red! - green! > 50 ? 'red' : 'neither';
  };
  const canvas = (north: number, east: number) => page.evaluate(([n, e]) => window.__skein!.toCanvas(n!, e!), [vehicle!.northM + north, vehicle!.eastM + east]);
  const { x, y } = await page.evaluate(async () => window.__skein!.positions()[0]!);
  await expect.poll(green({ x: x - 34, y: y + 34 })).toBe('green');
  for (let k = 0; k < 5; k++) await button(page, 'Zoom out').click();
  // Inside and outside of the corners of the green; the swarm's metres are those of the field to a part in a few hundred.
  for (const [north, east] of [[GREEN_M, GREEN_M], [GREEN_M, -GREEN_M], [-GREEN_M, GREEN_M], [-GREEN_M, -GREEN_M]] as const) {
    await expect.poll(green(await canvas(north * 0.9, east * 0.9))).toBe('green');
    await expect.poll(green(await canvas(north * 1.1, east * 1.1))).toBe('red');
  }
  await button(page, 'Remove base map').click();
  await expect.poll(() => page.evaluate(() => window.__skein!.baseTiles())).toBe(0);
});

test('a GeoTIFF that cannot be shown is refused in words', { tag: '@long' }, async ({ page }) => {
  await open(page, program.url, VEHICLES);
  await button(page, 'Layers').click();
  const one: MadePicture = { widthPx: 64, heightPx: 64, pixel: () => [1, 2, 3] };
  const there = { pixelScale: [1e-5, 1e-5, 0], tiepoint: [0, 0, 0, 8, 47, 0], keys: geographic(4326) };
  const made = async (picture: MadePicture, place: Parameters<typeof madeTiff>[1]) => Buffer.from(await madeTiff([picture], place));
  for (const [name, file, words] of [
    ['notes.tif', Buffer.from('no picture at all'.repeat(20)), 'is no GeoTIFF file'],
    ['broken.tif', (await made(one, there)).subarray(0, 2000), 'is no GeoTIFF file'],
    ['notes.txt', Buffer.from('no picture at all'.repeat(20)), 'is neither a PMTiles nor a GeoTIFF file'],
    ['scan.tif', await made(one, {}), 'does not say where on Earth it lies'],
    ['britain.tif', await made(one, { ...there, keys: projected(27700) }), 'is in a projection that is not known here: EPSG:27700'],
    ['own.tif', await made(one, { ...there, keys: projected(32767) }), 'is in a projection without an EPSG code'],
    ['heights.tif', await made({ ...one, bits: 16, pixel: () => [430] }, there), 'holds values of 16 bits, such as heights: only pictures of 8 bits are shown'],
  ] as const) {
    await load(page, file, name);
    await expect(page.getByRole('alert')).toHaveText(`${name} ${words}`);
  }
  await load(page, await made(one, there), 'field.tif');
  await expect(page.getByText('field.tif')).toBeVisible();
  await expect(page.getByRole('alert')).toHaveCount(0);
});

test('a file that is no base map is refused in words', { tag: '@long' }, async ({ page }) => {
  await open(page, program.url, VEHICLES);
  await button(page, 'Layers').click();
  await load(page, Buffer.from('no tiles at all'.repeat(20)), 'notes.pmtiles');
  await expect(page.getByRole('alert')).toHaveText('notes.pmtiles is no PMTiles file');
  await load(page, pmtiles([{ x: 0, y: 0, picture: Buffer.from([0]) }], 1), 'streets.pmtiles');
  await expect(page.getByRole('alert')).toHaveText('streets.pmtiles holds no pictures (PNG, JPEG, WebP or AVIF)');
});
