// Vehicles sent to a place on the map: refused with its reason on the ground, flown as previewed in the air.

import type { Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, card, expect, hold, open, plotted, summary, test, selectAll } from './console';
import { Program } from './program';

const VEHICLES = 2;
const FLIGHT_MS = 60_000;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

const note = (page: Page) => page.getByRole('region', { name: 'Send the targets to a place' });

async function click(page: Page, north: number, east: number): Promise<void> {
  const at = await page.evaluate(([n, e]) => window.__skein!.toCanvas(n!, e!), [north, east]);
  await page.locator('.surface canvas').click({ position: at });
}

test('two vehicles go where the map is clicked, arranged as they are', async ({ page }) => {
  await open(page, program.url, VEHICLES);
  await selectAll(page);
  await button(page, 'Send the targets to a place').click();
  await test.step('on the ground it is refused, and why is said', async () => {
    await click(page, 8, 2);
    await hold(page, `Fly there ${VEHICLES}`);
    await expect(note(page).getByRole('status')).toContainText(/1: .+; 2: .+/);
    expect(await findings(page)).toEqual([]);
    await note(page).getByRole('button', { name: 'Cancel' }).click();
  });
  await test.step('both take off', async () => {
    await hold(page, `Take off ${VEHICLES}`);
    await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
  });
  await test.step('both go there', async () => {
    const before = await plotted(page);
    await button(page, 'Send the targets to a place').click();
    await click(page, 12, 4);
    await expect(page.getByTestId('goto-way')).toContainText('arranged as they are');
    await hold(page, `Fly there ${VEHICLES}`);
    await expect(card(page, 1).getByTestId('flight-state')).toHaveText('Going to');
    await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
    const middle = (places: typeof before) => [places.reduce((sum, p) => sum + p.northM, 0) / VEHICLES, places.reduce((sum, p) => sum + p.eastM, 0) / VEHICLES];
    const after = await plotted(page);
    const [north, east] = middle(after);
    expect(Math.hypot(north! - 12, east! - 4)).toBeLessThan(2);
    const apart = ([a, b]: typeof before) => Math.hypot(a!.northM - b!.northM, a!.eastM - b!.eastM);
    expect(Math.abs(apart(after) - apart(before))).toBeLessThan(1.5);
  });
});
