// The view in space: vehicles at their height, fences as volumes, a camera for pointer and keys.

import type { Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, expect, hold, open, plotted, selectAll, summary, test } from './console';
import type {} from '../src/features/view3d/hook';
import { Program } from './program';

const VEHICLES = 3;
const FLIGHT_MS = 60_000;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

test.beforeEach(async ({ page, watch }) => {
  // Reading the picture back is what a machine without a graphics card does; the browser mentions it.
  watch.expected.push(/GPU stall due to ReadPixels/);
  await open(page, program.url, VEHICLES);
});

async function enter(page: Page): Promise<void> {
  await button(page, 'View in space').click();
  await expect.poll(() => page.evaluate(() => window.__skeinSpace?.frames() ?? 0), { timeout: 30_000 }).toBeGreaterThan(2);
}

const positions = (page: Page) => page.evaluate(() => window.__skeinSpace!.positions());
const camera = (page: Page) => page.evaluate(() => ({ bearingDeg: window.__skeinSpace!.bearingDeg(), distanceM: window.__skeinSpace!.distanceM() }));

test('drawn with WebGL, loaded when it is looked at, turned, moved and left again', { tag: '@long' }, async ({ page }) => {
  const scripts: string[] = [];
  page.on('request', (request) => request.url().endsWith('.js') && scripts.push(request.url()));
  await enter(page);
  expect(await page.evaluate(() => window.__skeinSpace!.drawer())).toBe('webgl');
  expect(scripts.length).toBeGreaterThan(0);
  await expect(page.getByTestId('space-plain')).toHaveCount(0);
  expect(await findings(page)).toEqual([]);
  const size = await page.locator('canvas.over').evaluate((canvas) => [canvas.clientWidth, canvas.clientHeight]);
  for (const { x, y } of await positions(page)) {
    expect(x).toBeGreaterThan(0);
    expect(x).toBeLessThan(size[0]!);
    expect(y).toBeGreaterThan(0);
    expect(y).toBeLessThan(size[1]!);
  }

  await test.step('by keys', async () => {
    await page.getByRole('application').focus();
    const before = await camera(page);
    await page.keyboard.press('ArrowRight');
    expect((await camera(page)).bearingDeg - before.bearingDeg).toBeCloseTo(10, 5);
    await page.keyboard.press('+');
    expect((await camera(page)).distanceM).toBeCloseTo(before.distanceM / 1.4, 5);
    const [first] = await positions(page);
    await page.keyboard.press('Shift+ArrowRight');
    expect((await positions(page))[0]!.x).toBeLessThan(first!.x);
    await page.keyboard.press('f');
    await expect.poll(async () => (await camera(page)).distanceM).toBeCloseTo(before.distanceM, 0);
  });
  await test.step('by pointer', async () => {
    const before = await camera(page);
    const box = (await page.locator('canvas.over').boundingBox())!;
    await page.mouse.move(box.x + 120, box.y + 300);
    await page.mouse.down();
    await page.mouse.move(box.x + 220, box.y + 300, { steps: 4 });
    await page.mouse.up();
    expect((await camera(page)).bearingDeg).toBeGreaterThan(before.bearingDeg + 20);
    await expect(page.getByTestId('targets')).toContainText('nothing selected');
    await page.mouse.wheel(0, 300);
    await expect.poll(async () => (await camera(page)).distanceM).toBeGreaterThan(before.distanceM * 1.2);
    const third = (await positions(page)).find((v) => v.id === 3)!;
    await page.mouse.click(box.x + third.x, box.y + third.y);
    await expect(page.getByTestId('targets')).toContainText('1 selected');
  });
  await page.getByRole('application').focus();
  await page.keyboard.press('v');
  await expect.poll(() => page.evaluate(() => window.__skeinSpace === undefined)).toBe(true);
  // The map is drawn again.
  const drawn = await page.evaluate(() => window.__skein!.framesDrawn());
  await expect.poll(() => page.evaluate(() => window.__skein!.framesDrawn())).toBeGreaterThan(drawn + 3);
});

test('height is seen: a climb goes up in the picture, a fence is as high as it is', { tag: '@long' }, async ({ page }) => {
  const at = (await plotted(page))[0]!;
  const corners = [[-1, -1], [-1, 1], [1, 1], [1, -1], [-1, -1]].map(([n, e]) => [at.longitudeDeg + e! * 0.001, at.latitudeDeg + n! * 0.001]);
  const field = {
    type: 'FeatureCollection',
    features: [{
      type: 'Feature', properties: { name: 'field', kind: 'inclusion', floor_m: null, ceiling_m: 40 },
      geometry: { type: 'Polygon', coordinates: [corners] },
    }],
  };
  await page.getByRole('tab', { name: 'Fences' }).click();
  await page.locator('input[type=file]').setInputFiles({ name: 'field.geojson', mimeType: 'application/geo+json', buffer: Buffer.from(JSON.stringify(field)) });
  await hold(page, 'Put 1 zone in force');
  await enter(page);
  await expect.poll(() => page.evaluate(() => window.__skeinSpace!.walls())).toEqual([{ name: 'field', floorM: 0, ceilingM: 40 }]);
  // A camera that stands still, so that what moves is the vehicle.
  await page.getByRole('application').focus();
  await page.keyboard.press('-');
  const before = await positions(page);
  await selectAll(page);
  await hold(page, `Take off ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
  const after = await positions(page);
  for (const [k, { y }] of after.entries()) expect(y).toBeLessThan(before[k]!.y - 10);
  await hold(page, `LAND ALL ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
  await page.getByRole('tab', { name: 'Fences' }).click();
  await hold(page, 'Lift all');
  await expect.poll(() => page.evaluate(() => window.__skeinSpace!.walls())).toEqual([]);
});
