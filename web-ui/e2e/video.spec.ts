// Live video of simulated cameras that draw the node's clock into their pictures: it moves before the eyes on each of the three ways, a picture that
// is not renewed says so, and what is out of sight is not received.

import type { ChildProcess } from 'node:child_process';
import { readFileSync } from 'node:fs';
import type { Locator, Page } from '@playwright/test';
import type { StreamTruth } from '../src/features/video/hook';
import { findings } from './accessibility';
import { button, expect, test } from './console';
import { Program, freePort } from './program';

const CAMERAS = 2;
/** A camera, an encoder and a browser that draws on the processor share two cores. */
const SLOW_MS = 90_000;
/** What no picture takes from one glass to the other on a machine that is not standing still. */
const LATEST_MS = 5000;
/** The estimate of the clock is right to half of a way there and back. */
const CLOCK_OFF_MS = 100;
const WIDTHS = [[1440, 900], [1024, 768], [390, 844]] as const;

let program: Program;
let vehicles: ChildProcess;
test.beforeEach(async ({ page }) => {
  const sendTo = `127.0.0.1:${await freePort()}`;
  program = await Program.node([
    '[[endpoints]]', 'name = "sitl"', `address = "udp-listen://${sendTo}"`,
    '[[adopt]]', 'name = "uav-{system_id}"', 'model = "generic-uav"',
    '[[adopt.payloads]]', 'name = "camera"', 'plugin = "camera"',
    'config = { source = "synthetic", width_px = 640, height_px = 480, rate_hz = 30.0, clock = true }',
  ]);
  vehicles = Program.vehicles(CAMERAS, 1, sendTo);
  await page.goto(`${program.url}/#video`);
  await expect(tile(page, 1)).toBeVisible({ timeout: SLOW_MS });
  await expect(tile(page, 2)).toBeVisible({ timeout: SLOW_MS });
});
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
  vehicles.kill('SIGKILL');
  await program.stop();
});

const tile = (page: Page, vehicle: number): Locator => page.locator(`[data-stream="${vehicle}/camera"]`);
const large = (page: Page, vehicle: number): Locator => page.locator(`[data-large="${vehicle}/camera"]`);
const figure = (place: Locator, name: string): Locator => place.locator(`[data-figure="${name}"]`);
const streams = (page: Page): Promise<StreamTruth[]> => page.evaluate(() => window.__skeinVideo?.streams() ?? []);
const truth = async (page: Page, vehicle: number): Promise<StreamTruth | undefined> => (await streams(page)).find((one) => one.vehicle === vehicle);

async function takeWay(page: Page, way: StreamTruth['way']): Promise<void> {
  await page.getByRole('combobox', { name: 'Way' }).selectOption(way);
  const taken = async (): Promise<boolean> => {
    const all = await streams(page);
    return all.length > 0 && all.every((one) => one.way === way);
  };
  await expect.poll(taken, { timeout: SLOW_MS }).toBe(true);
}

/** Waits until the clock in the picture of a vehicle has gone on by more than a second before the eyes. */
async function clockMoves(page: Page, vehicle: number): Promise<void> {
  const clock = async (): Promise<number> => (await truth(page, vehicle))?.lastClockMs ?? NaN;
  await expect.poll(clock, { timeout: SLOW_MS }).toBeGreaterThanOrEqual(0);
  const [begun, shown] = [await clock(), (await truth(page, vehicle))!.shown];
  await expect.poll(clock, { timeout: SLOW_MS }).toBeGreaterThan(begun + 1000);
  const shownNow = async (): Promise<number> => (await truth(page, vehicle))?.shown ?? 0;
  await expect.poll(shownNow, { timeout: SLOW_MS }).toBeGreaterThan(shown + 1);
}

test('the wall shows every camera, live, with its figures', async ({ page }) => {
  for (const vehicle of [1, 2]) await clockMoves(page, vehicle);
  await expect(page.getByTestId('video-sum')).toHaveText(`${CAMERAS} of ${CAMERAS} live`);
  for (const vehicle of [1, 2]) {
    await expect(tile(page, vehicle).getByTestId('stream-state')).toHaveText('live', { timeout: SLOW_MS });
    await expect(tile(page, vehicle)).toContainText(`uav-${vehicle}`);
    await expect(tile(page, vehicle).getByRole('img', { name: `What camera of uav-${vehicle} sees` })).toBeVisible();
    await expect(figure(tile(page, vehicle), 'age')).toHaveText(/^\d+\.\d s$/);
    await expect(figure(tile(page, vehicle), 'rate')).toHaveText(/^\d+(\.\d)?\/s$/);
    await expect(figure(tile(page, vehicle), 'loss')).toHaveText(/^\d+(\.\d)? %$/);
    await expect(figure(tile(page, vehicle), 'size')).toHaveText(/^\d+×\d+$/);
    await expect(figure(tile(page, vehicle), 'delay')).toHaveText(/^-?\d+ ms$/, { timeout: SLOW_MS });
  }
  const all = await streams(page);
  expect(all.map(({ quality }) => quality)).toEqual(['sub', 'sub']);
  expect(all.map(({ unreadable }) => unreadable)).toEqual([0, 0]);
  expect(await findings(page)).toEqual([]);
});

test('the clock moves on each of the three ways, and the way is remembered', { tag: '@long' }, async ({ page }) => {
  await button(page, 'One large').click();
  await expect(large(page, 1)).toBeVisible();
  for (const [way, words] of [['webcodecs', 'WebCodecs'], ['webrtc', 'WebRTC'], ['jpeg', 'JPEG']] as const) {
    await test.step(words, async () => {
      await takeWay(page, way);
      const main = async (): Promise<StreamTruth> => (await streams(page)).find(({ quality }) => quality === 'main')!;
      await expect.poll(async () => (await main()).lastClockMs ?? -1, { timeout: SLOW_MS }).toBeGreaterThanOrEqual(0);
      const { lastClockMs, shown } = await main();
      await expect.poll(async () => (await main()).lastClockMs, { timeout: SLOW_MS }).toBeGreaterThan(lastClockMs! + 1000);
      const after = await main();
      expect(after.shown).toBeGreaterThan(shown + 1);
      expect([after.way, after.widthPx, after.heightPx]).toEqual([way, 640, 480]);
      await expect.poll(async () => (await main()).glassToGlassMs.length, { timeout: SLOW_MS }).toBeGreaterThan(2);
      const delays = (await main()).glassToGlassMs;
      expect(Math.min(...delays)).toBeGreaterThan(-CLOCK_OFF_MS);
      expect(Math.min(...delays)).toBeLessThan(LATEST_MS);
      await expect(figure(large(page, 1), 'way')).toHaveText(words);
      await expect(figure(large(page, 1), 'delay')).toHaveText(/^-?\d+ ms, -?\d+ ms$/);
    });
  }
  await page.reload();
  await expect(page.getByRole('combobox', { name: 'Way' })).toHaveValue('jpeg');
  await expect.poll(async () => (await truth(page, 1))?.way, { timeout: SLOW_MS }).toBe('jpeg');
});

test('a picture that is not renewed is grey and says how old it is, until the next one', { tag: '@long' }, async ({ page, watch }) => {
  // The page gives up connections that say nothing.
  watch.expected.push(/WebSocket/, /Failed to load resource/);
  for (const vehicle of [1, 2]) await clockMoves(page, vehicle);
  program.pause();
  for (const vehicle of [1, 2]) {
    await expect(tile(page, vehicle).getByTestId('frozen')).toHaveText(/^last picture \d+\.\d s ago$/);
    const filter = await tile(page, vehicle).getByRole('img').evaluate((picture) => getComputedStyle(picture).filter);
    expect(filter).toContain('grayscale(1)');
  }
  const seconds = async (): Promise<number> => parseFloat((await tile(page, 1).getByTestId('frozen').textContent())!.replace('last picture ', ''));
  const before = await seconds();
  await expect.poll(seconds).toBeGreaterThan(before + 1);
  expect((await streams(page)).every(({ frozen }) => frozen)).toBe(true);
  program.goOn();
  for (const vehicle of [1, 2]) {
    await expect(tile(page, vehicle).getByTestId('frozen')).toHaveCount(0, { timeout: SLOW_MS });
    await clockMoves(page, vehicle);
  }
});

test('what is out of sight is not received', { tag: '@long' }, async ({ page }) => {
  // So low that there is room for less than one.
  await page.setViewportSize({ width: 390, height: 700 });
  await page.evaluate(() => document.querySelector('.video-page')?.scrollTo(0, 0));
  await expect.poll(async () => (await streams(page)).map(({ vehicle }) => vehicle), { timeout: SLOW_MS }).toEqual([1]);
  await clockMoves(page, 1);
  await page.evaluate(() => document.querySelector('.video-page')?.scrollTo(0, 100_000));
  await expect.poll(async () => (await streams(page)).map(({ vehicle }) => vehicle), { timeout: SLOW_MS }).toEqual([2]);
  await clockMoves(page, 2);
  await page.goto(`${program.url}/#fleet`);
  await expect.poll(async () => (await streams(page)).length).toBe(0);
});

test('one large, beside the map, and in a corner of it', { tag: '@long' }, async ({ page }) => {
  await tile(page, 2).getByRole('button', { name: /Show large/ }).click();
  await expect(large(page, 2)).toBeVisible();
  await clockMoves(page, 2);
  await button(page, 'Beside the map').click();
  await expect(page.getByRole('region', { name: 'Map' })).toBeVisible();
  await expect.poll(() => page.evaluate(() => window.__skein?.positions().length)).toBe(CAMERAS);
  await page.getByRole('group', { name: 'All streams' }).getByRole('button', { name: /1 camera/ }).click();
  await expect(large(page, 1)).toBeVisible();
  for (const [width, height] of WIDTHS) {
    await page.setViewportSize({ width, height });
    for (const layout of ['Wall', 'One large', 'Beside the map']) {
      await button(page, layout).click();
      expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), `${layout}, ${width} px`).toBeLessThanOrEqual(0);
      expect(await findings(page), `${layout}, ${width} px`).toEqual([]);
    }
  }
  await page.setViewportSize({ width: 1440, height: 900 });

  await large(page, 1).getByRole('button', { name: 'Picture in picture on the map' }).click();
  await page.getByRole('navigation', { name: 'Pages' }).getByRole('link', { name: 'Map' }).click();
  const inset = page.locator('[data-inset="1/camera"]');
  await clockMoves(page, 1);
  await expect(inset).toHaveClass(/bottom-right/);
  const [bar, map] = [(await inset.boundingBox())!, (await page.getByRole('region', { name: 'Map' }).boundingBox())!];
  await page.mouse.move(bar.x + bar.width / 2, bar.y + 20);
  await page.mouse.down();
  await page.mouse.move(map.x + 120, map.y + 60, { steps: 6 });
  await page.mouse.up();
  await expect(inset).toHaveClass(/top-left/);
  await inset.getByRole('button', { name: 'Put it into the next corner' }).press('Enter');
  await expect(inset).toHaveClass(/top-right/);
  expect(page.url()).toContain('#map');
  expect(await findings(page)).toEqual([]);
  await page.reload();
  await expect(inset).toHaveClass(/top-right/);
  await clockMoves(page, 1);
  await inset.getByRole('button', { name: 'Close the picture' }).click();
  await page.reload();
  await expect(page.getByRole('region', { name: 'Map' })).toBeVisible();
  await expect(inset).toHaveCount(0);
});

test('a still is a file of the browser, a recording one of the node', { tag: '@long' }, async ({ page }) => {
  await button(page, 'One large').click();
  await clockMoves(page, 1);
  const still = page.waitForEvent('download');
  await large(page, 1).getByRole('button', { name: 'Still' }).click();
  const file = await still;
  expect(file.suggestedFilename()).toMatch(/^uav-1_camera_\d{8}-\d{6}\.jpg$/);
  const bytes = readFileSync((await file.path())!);
  expect([bytes[0], bytes[1]]).toEqual([0xff, 0xd8]);

  await large(page, 1).getByRole('button', { name: 'Record video' }).click();
  const stop = large(page, 1).getByRole('button', { name: /^Stop, \d+:\d\d$/ });
  await expect(stop).toBeVisible();
  await expect(stop).toHaveText(/0:(0[3-9]|[1-5]\d)/, { timeout: SLOW_MS });
  await stop.click();
  await expect(large(page, 1).getByRole('button', { name: 'Record video' })).toBeVisible();
  await button(page, 'Wall').click();
  const recordings = page.getByTestId('recordings');
  await recordings.locator('summary').click();
  const address = await recordings.getByRole('link').first().getAttribute('href');
  const recorded = await page.request.get(address!);
  expect(recorded.ok()).toBe(true);
  expect((await recorded.body()).length).toBeGreaterThan(1000);
});
