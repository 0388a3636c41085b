// Somebody who has never seen the page: from opening it to a flying formation, in under ten clicks, reading nothing but the screen.

import { expect, largestSlotError, test } from './console';
import { Program } from './program';

const VEHICLES = 3;
const FLIGHT_MS = 60_000;

let program: Program;
test.beforeEach(async () => {
  program = await Program.start(VEHICLES);
});
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
  await program.stop();
});

for (const [width, height] of [[1440, 900], [390, 844]] as const) {
  test(`a formation flies after less than ten clicks at ${width} by ${height}`, { tag: '@long' }, async ({ page }) => {
    await page.setViewportSize({ width, height });
    // Every press of the pointer counts, whatever it hits, the ones that do nothing too.
    await page.addInitScript(() => {
      addEventListener('pointerdown', () => ((window as unknown as { presses: number }).presses = ((window as unknown as { presses?: number }).presses ?? 0) + 1), true);
    });
    await page.goto(program.url);
    await expect(page.getByTestId('count-all')).toHaveText(`${VEHICLES}`, { timeout: FLIGHT_MS });
    const press = async (name: RegExp): Promise<void> => {
      const wanted = page.getByRole('button', { name });
      await expect(wanted).toBeEnabled({ timeout: FLIGHT_MS });
      await wanted.scrollIntoViewIfNeeded();
      await wanted.hover();
      const sent = page.waitForRequest((request) => request.method() !== 'GET' && !request.url().endsWith('/preview'));
      await page.mouse.down();
      await sent;
      await page.mouse.up();
    };
    await expect(page.getByTestId('armed').filter({ hasText: 'disarmed, ready' })).toHaveCount(VEHICLES, { timeout: FLIGHT_MS });
    await expect(page.getByRole('button', { name: /^Take off/ })).toBeDisabled();
    await page.getByRole('button', { name: /^Select all/ }).click();
    await press(/^Take off/);
    await expect(page.getByTestId('count-air')).toHaveText(`${VEHICLES}`, { timeout: FLIGHT_MS });
    await expect(page.getByTestId('flight-state').filter({ hasText: /Holding|Following|Leading/ })).toHaveCount(VEHICLES, { timeout: FLIGHT_MS });
    await page.getByRole('tab', { name: 'Formation' }).click();
    await press(/^Form /);
    await expect(page.getByTestId('formation-flown')).toContainText(`of ${VEHICLES}`);
    await expect.poll(() => largestSlotError(page, VEHICLES - 1), { timeout: FLIGHT_MS }).toBeLessThan(1);
    const presses = await page.evaluate(() => (window as unknown as { presses?: number }).presses ?? 0);
    expect(presses).toBeLessThan(10);
    expect(presses).toBeGreaterThan(0);
  });
}
