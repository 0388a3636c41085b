// The map's own tools, beside those every page test uses: layers, measuring, following one vehicle, links; and what it costs to load.

import { gzipSync } from 'node:zlib';
import type { Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, card, expect, hold, open, plotted, selectAll, summary, test } from './console';
import { Program } from './program';

const VEHICLES = 3;
/** What the page may weigh before anybody looks at it in space, compressed. */
const LIMIT_BYTES = 115_000;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

const vehicle = async (page: Page, id: number) => (await plotted(page)).find((v) => v.id === id)!;
const measured = (page: Page) => page.evaluate(() => window.__skein!.measured());
/** A place of the map in the page. */
const onPage = async (page: Page, at: { x: number; y: number }): Promise<[number, number]> => {
  const box = (await page.locator('canvas').boundingBox())!;
  return [box.x + at.x, box.y + at.y];
};

test('layers are hidden and shown, and the choice stays', { tag: '@long' }, async ({ page }) => {
  await open(page, program.url, VEHICLES);
  const layers = button(page, 'Layers');
  const links = page.getByRole('checkbox', { name: 'Links', exact: true });
  await layers.click();
  await expect(links).not.toBeChecked();
  await expect(page.getByRole('checkbox', { name: 'Fences', exact: true })).toBeChecked();
  await links.check();
  await page.getByRole('checkbox', { name: 'Grid', exact: true }).uncheck();
  expect(await findings(page)).toEqual([]);
  const drawn = () => page.evaluate(() => window.__skein!.links());
  await expect.poll(async () => (await drawn()).map((l) => l.id).sort()).toEqual([1, 2, 3]);
  // All on one machine: nothing is lost on the way.
  await expect.poll(async () => (await drawn()).map((l) => `${l.quality} ${l.text}`)).toEqual(['good ', 'good ', 'good ']);
  await links.focus();
  await page.keyboard.press('Escape');
  await expect(links).toBeHidden();
  await page.reload();
  await layers.click();
  await expect(links).toBeChecked();
  await expect(page.getByRole('checkbox', { name: 'Grid', exact: true })).not.toBeChecked();
});

test('distance and bearing are measured between places and vehicles', { tag: '@long' }, async ({ page }) => {
  await open(page, program.url, VEHICLES);
  await button(page, 'Measure distance and bearing').click();
  const said = page.getByTestId('measured');
  const [from, to] = [await vehicle(page, 1), await vehicle(page, 2)];
  await page.mouse.click(...(await onPage(page, from)));
  await expect(said).toHaveText('Click the next place or vehicle.');
  await page.mouse.click(...(await onPage(page, to)));
  await expect.poll(async () => (await measured(page)).length).toBe(1);
  const distance = Math.hypot(to.northM - from.northM, to.eastM - from.eastM);
  const [leg] = await measured(page);
  expect(Math.abs(leg!.distanceM - distance)).toBeLessThan(0.3);
  const bearing = ((Math.atan2(to.eastM - from.eastM, to.northM - from.northM) * 180) / Math.PI + 360) % 360;
  expect(Math.abs(((leg!.bearingDeg! - bearing + 540) % 360) - 180)).toBeLessThan(10);
  expect(Math.abs(leg!.riseM!)).toBeLessThan(2);
  await expect(said).toHaveText(/^\d+\.\d\d m, \d{3}°, [+−]\d\.\d m up$/);
  await expect(page.getByTestId('targets')).toContainText('nothing selected');
  // A place: its height is not known and not said.
  await page.mouse.click(...(await onPage(page, await page.evaluate(() => window.__skein!.toCanvas(-6, -4)))));
  await expect.poll(async () => (await measured(page))[1]?.riseM).toBeNull();
  await expect(said).toContainText('; together ');
  await page.getByRole('application').focus();
  await page.keyboard.press('Backspace');
  await expect.poll(async () => (await measured(page)).length).toBe(1);
  await page.keyboard.press('Escape');
  expect(await measured(page)).toEqual([]);

  // Without a pointer: between the targets.
  for (const id of [1, 3]) await button(page, new RegExp(`^Target ${id},`)).click();
  await page.getByRole('application').focus();
  await page.keyboard.press('m');
  await expect.poll(async () => (await measured(page)).length).toBe(1);
  expect(await findings(page)).toEqual([]);
});

test('a first vehicle is on the map before anything but the page itself was loaded', { tag: '@long' }, async ({ page }) => {
  // The bundler may cut what the page itself needs into several files; it names all of them in the page.
  const html = await (await page.request.get(program.url)).text();
  const named = [...html.matchAll(/="\.(\/[^"]+\.(?:js|css))"/g)].map(([, name]) => name!);
  expect(named.length).toBeGreaterThan(0);
  const weights = [gzipSync(html).length];
  // What else it asks for never comes.
  await page.route(/\.(js|css)$/, async (route) => {
    if (!named.includes(new URL(route.request().url()).pathname)) return;
    const response = await route.fetch();
    weights.push(gzipSync(await response.body()).length);
    await route.fulfill({ response });
  });
  await page.goto(program.url, { waitUntil: 'commit' });
  await expect(card(page, 1)).toBeVisible();
  await expect.poll(() => page.evaluate(() => window.__skein!.firstVehicleMs())).not.toBeNull();
  expect(weights).toHaveLength(named.length + 1);
  expect(weights.reduce((sum, bytes) => sum + bytes, 0)).toBeLessThan(LIMIT_BYTES);
});

test('what a camera sees of the ground and what is tracked is on the map', { tag: '@long' }, async ({ page }) => {
  await open(page, program.url, VEHICLES);
  const seen = () => page.evaluate(() => window.__skein!.groundSeen());
  const tracks = () => page.evaluate(() => window.__skein!.tracksSeen());
  const gimbal = `${program.url}/api/v1/vehicles/2/payloads/gimbal/command`;
  await selectAll(page);
  await hold(page, `Take off ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: 60_000 });
  expect(await seen()).toEqual([]);
  await button(page, 'Layers').click();
  await page.getByRole('checkbox', { name: 'What cameras see' }).check();
  // One in three carries a camera.
  await expect.poll(async () => (await seen()).map(({ vehicle }) => vehicle)).toEqual([2]);

  // Straight down: the vehicle is in the middle of what it sees.
  expect((await page.request.post(gimbal, { data: { command: 'take_control' } })).ok()).toBe(true);
  expect((await page.request.post(gimbal, { data: { command: 'angles', pitch_rad: -Math.PI / 2, yaw_rad: 0 } })).ok()).toBe(true);
  const offMiddleM = async (): Promise<number> => {
    const view = (await seen()).find((one) => one.vehicle === 2)!;
    const { northM, eastM } = await vehicle(page, 2);
    const middle = (key: 'north' | 'east') => view.corners.reduce((sum, corner) => sum + corner[key], 0) / view.corners.length;
    return Math.hypot(middle('north') - northM, middle('east') - eastM);
  };
  await expect.poll(offMiddleM, { timeout: 20_000 }).toBeLessThan(1);
  expect(await findings(page)).toEqual([]);

  // A track as another program tells it; told no more, it looks stale.
  const { time } = (await (await page.request.get(`${program.url}/api/v1/tracks`)).json()) as { time: number };
  const track = { track: 7, position: { north_m: 12, east_m: -5, down_m: -20 }, velocity: { north_m_s: 1, east_m_s: 0, down_m_s: 0 }, time };
  expect((await page.request.put(`${program.url}/api/v1/tracks`, { data: { tracks: [track] } })).ok()).toBe(true);
  await expect.poll(async () => (await tracks()).map((one) => [one.track, one.north, one.east])).toEqual([[7, 12, -5]]);
  await expect.poll(async () => (await tracks())[0]!.stale, { timeout: 10_000 }).toBe(true);
  await page.getByRole('checkbox', { name: 'Tracks', exact: true }).uncheck();
  expect(await tracks()).toEqual([]);
  expect((await page.request.put(`${program.url}/api/v1/tracks`, { data: { tracks: [] } })).ok()).toBe(true);
  await page.keyboard.press('Escape');
  await hold(page, `LAND ALL ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: 60_000 });
});

test('one vehicle is followed and the targets stay as they were', { tag: '@long' }, async ({ page }) => {
  await open(page, program.url, VEHICLES);
  await button(page, 'Zoom in').click();
  await page.mouse.dblclick(...(await onPage(page, await vehicle(page, 2))));
  await expect(page.getByText('Following 2')).toBeVisible();
  await expect(page.getByTestId('targets')).toContainText('nothing selected');
  // The map gives way to what is said of commands below it, so that its middle is not where it was.
  const fromMiddle = async (): Promise<number> => {
    const { x, y } = await vehicle(page, 2);
    const [middleX, middleY] = await page.locator('canvas').evaluate((canvas) => [canvas.clientWidth / 2, canvas.clientHeight / 2] as const);
    return Math.hypot(x - middleX, y - middleY);
  };
  await expect.poll(fromMiddle).toBeLessThan(1.5);
  await selectAll(page);
  await hold(page, `Take off ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: 60_000 });
  await expect.poll(fromMiddle).toBeLessThan(1.5);
  await button(page, 'Stop following').click();
  await expect(page.getByText('Following 2')).toBeHidden();
  await hold(page, `LAND ALL ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: 60_000 });
});

test('the map is never without its ground while it changes its size', { tag: '@long' }, async ({ page, watch }) => {
  watch.expected.push(/Multiple readback operations/);
  await open(page, program.url, VEHICLES);
  // Told after the page was: what the canvas holds then is what the browser paints.
  await page.evaluate(() => {
    const canvas = document.querySelector('canvas')!;
    const ctx = canvas.getContext('2d')!;
    const seen: number[] = [];
    Object.assign(window, { blackShares: seen });
    new ResizeObserver(() => {
      const { data } = ctx.getImageData(0, 0, canvas.width, canvas.height);
      let black = 0;
      for (let at = 0; at < data.length; at += 4) if (data[at]! + data[at + 1]! + data[at + 2]! === 0) black++;
      seen.push(black / (data.length / 4));
    }).observe(canvas.closest('section')!);
  });
  const seen = () => page.evaluate(() => (window as unknown as { blackShares: number[] }).blackShares);
  await expect.poll(async () => (await seen()).length).toBe(1);
  const size = page.viewportSize()!;
  for (let step = 1; step <= 5; step++) {
    await page.setViewportSize({ width: size.width - 40 * step, height: size.height - 20 * step });
    await expect.poll(async () => (await seen()).length).toBeGreaterThan(step);
  }
  for (const share of await seen()) expect(share).toBeLessThan(0.2);
});

test('between the frames of the socket a vehicle is drawn where it has got to', { tag: '@long' }, async ({ page }) => {
  await open(page, program.url, VEHICLES);
  await selectAll(page);
  await hold(page, `Take off ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: 60_000 });
  const { northM, eastM } = await vehicle(page, 1);
  const command = { command: 'go_to', position: { north_m: northM + 60, east_m: eastM, down_m: -20 }, speed_m_s: 5 };
  expect((await page.request.post(`${program.url}/api/v1/commands`, { data: { targets: { vehicles: [1] }, command } })).ok()).toBe(true);
  await expect.poll(async () => (await vehicle(page, 1)).northM - northM).toBeGreaterThan(4);
  // Pictures after which a vehicle stands somewhere else though no frame came: on the canvas, not in what it said.
  const { carried, said } = await page.evaluate(async () => {
    const first = () => window.__skein!.positions().find(({ id }) => id === 1)!;
    let [carried, said] = [0, 0];
    let [frames, before] = [-1, first()];
    for (const end = performance.now() + 60_000; performance.now() < end && carried < 10; ) {
      await new Promise(requestAnimationFrame);
      const now = first();
      if (window.__skein!.framesTaken() === frames) {
        if (now.y < before.y) carried++;
        if (now.northM !== before.northM) said++;
      }
      [frames, before] = [window.__skein!.framesTaken(), now];
    }
    return { carried, said };
  });
  expect(carried).toBe(10);
  expect(said).toBe(0);
  await hold(page, `LAND ALL ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: 60_000 });
});
