// Two hundred vehicles at once: all on the map, one found and stopped in an emergency while all of them stream.

import { button, expect, hold, plotted, test } from './console';
import { Program } from './program';

const VEHICLES = 200;
const ONE = 150;
const START_MS = 120_000;

type Listed = { vehicles: { id: number; ready_to_arm: boolean; stopped: boolean }[] };

let program: Program;
test.beforeAll(async () => {
  program = await Program.crowd(VEHICLES);
});
test.afterAll(() => program.stop());

test('one of two hundred is stopped in an emergency while all stream', { tag: '@long' }, async ({ page }) => {
  const listed = async () => ((await (await page.request.get(`${program.url}/api/v1/vehicles`)).json()) as Listed).vehicles;
  await page.goto(program.url);
  await expect(page.getByTestId('count-all')).toHaveText(`${VEHICLES}`, { timeout: START_MS });
  await expect.poll(async () => (await listed()).filter((v) => v.ready_to_arm).length, { timeout: START_MS }).toBe(VEHICLES);
  await expect.poll(async () => (await plotted(page)).length).toBe(VEHICLES);

  await page.keyboard.press('/');
  await page.keyboard.type(`${ONE}`);
  await button(page, 'Target these 1').click();
  await expect(page.getByTestId('targets')).toContainText('1 selected');
  await page.getByRole('searchbox', { name: /^Find vehicles/ }).press('Escape');
  await hold(page, 'Arm 1');
  const before = await page.evaluate(() => [window.__skein!.framesTaken(), window.__skein!.framesDrawn()]);
  await button(page, /^EMERGENCY STOP/).click();
  await button(page, /^STOP MOTORS OF 1 SELECTED/).click();
  await expect(page.getByText(`Emergency stop sent to ${ONE}`)).toBeVisible();
  await expect.poll(async () => (await listed()).filter((v) => v.stopped).map((v) => v.id)).toEqual([ONE]);
  // The picture has gone on meanwhile, and goes on.
  await expect.poll(() => page.evaluate(() => window.__skein!.framesTaken())).toBeGreaterThan(before[0]! + 5);
  await expect.poll(() => page.evaluate(() => window.__skein!.framesDrawn())).toBeGreaterThan(before[1]! + 5);
  expect((await plotted(page)).length).toBe(VEHICLES);
});
