// A zone drawn on the map: its corners are clicked and dragged, it is put in force, changed and lifted; a crossed outline is refused with its reason.

import type { Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, expect, hold, open, test } from './console';
import { Program } from './program';

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(2);
});
test.afterAll(() => program.stop());

const drawing = (page: Page) => page.getByTestId('fence-drawing');
const said = (page: Page) => page.getByTestId('fence-panel').locator('> [role=status]');
const zones = (page: Page) => page.evaluate(() => window.__skein!.zones());

async function at(page: Page, [north, east]: readonly [number, number]): Promise<[number, number]> {
  const { x, y } = await page.evaluate(([n, e]) => window.__skein!.toCanvas(n!, e!), [north, east]);
  const box = (await page.locator('.surface canvas').boundingBox())!;
  return [box.x + x, box.y + y];
}

async function corners(page: Page, ...places: readonly (readonly [number, number])[]): Promise<void> {
  await drawing(page).getByRole('button', { name: 'Draw on the map' }).click();
  for (const place of places) await page.mouse.click(...(await at(page, place)));
}

test('a zone is drawn, put in force, changed and lifted', async ({ page, watch }) => {
  watch.expected.push(/409/);
  await open(page, program.url, 2);
  await page.getByRole('tab', { name: 'Fences' }).click();
  await test.step('an outline that crosses itself is refused, and nothing is in force', async () => {
    await corners(page, [-8, -10], [8, 10], [8, -10], [-8, 10]);
    await hold(page, 'Put the zone in force');
    await expect(said(page)).toContainText('Not put in force');
    expect(await zones(page)).toEqual([]);
    await drawing(page).getByRole('button', { name: 'Put away' }).click();
  });
  await test.step('four corners, one of them dragged', async () => {
    await corners(page, [-8, -10], [8, -10], [8, 10], [-8, 10]);
    await page.mouse.move(...(await at(page, [8, 10])));
    await page.mouse.down();
    await page.mouse.move(...(await at(page, [10, 12])), { steps: 5 });
    await page.mouse.up();
    await page.getByRole('textbox', { name: 'Name', exact: true }).fill('field');
    await page.getByRole('checkbox', { name: 'Greatest height' }).check();
    expect(await findings(page)).toEqual([]);
    await hold(page, 'Put the zone in force');
    await expect.poll(() => zones(page)).toEqual([{ name: 'field', kind: 'inclusion', corners: 4 }]);
    await expect(page.getByRole('region', { name: 'Fences in force' })).toContainText('up to 60 m');
  });
  await test.step('it is taken up, loses a corner and takes its own place', async () => {
    await button(page, 'Change field').click();
    await page.locator('.surface').press('Backspace');
    await hold(page, 'Put the change in force');
    await expect.poll(() => zones(page)).toEqual([{ name: 'field', kind: 'inclusion', corners: 3 }]);
  });
  await test.step('it is lifted', async () => {
    await button(page, 'Change field').click();
    await hold(page, 'Lift this zone');
    await expect.poll(() => zones(page)).toEqual([]);
  });
});
