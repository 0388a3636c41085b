// A browser that gives no WebGL: the view in space is drawn on a plain canvas, and the page says so.

import { findings } from './accessibility';
import { button, expect, open, test } from './console';
import config from './playwright.config';
import type {} from '../src/features/view3d/hook';
import { Program } from './program';

const VEHICLES = 2;
const launch = config.use?.launchOptions ?? {};
test.use({ launchOptions: { ...launch, args: [...(launch.args ?? []), '--disable-3d-apis'] } });

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

test('without WebGL the view in space is drawn all the same', { tag: '@long' }, async ({ page }) => {
  const scripts: string[] = [];
  page.on('request', (request) => scripts.push(request.url()));
  await open(page, program.url, VEHICLES);
  expect(await page.evaluate(() => document.createElement('canvas').getContext('webgl2'))).toBeNull();
  await button(page, 'View in space').click();
  await expect.poll(() => page.evaluate(() => window.__skeinSpace?.frames() ?? 0)).toBeGreaterThan(5);
  expect(await page.evaluate(() => window.__skeinSpace!.drawer())).toBe('canvas');
  // What could not be used is not fetched either.
  expect(scripts.filter((url) => url.includes('webgl'))).toEqual([]);
  await expect(page.getByTestId('space-plain')).toBeVisible();
  expect(await findings(page)).toEqual([]);
  await page.getByRole('application').focus();
  const before = await page.evaluate(() => window.__skeinSpace!.bearingDeg());
  await page.keyboard.press('ArrowLeft');
  expect(before - (await page.evaluate(() => window.__skeinSpace!.bearingDeg()))).toBeCloseTo(10, 5);
  await page.keyboard.press('v');
  await expect(page.getByTestId('space-plain')).toHaveCount(0);
});
