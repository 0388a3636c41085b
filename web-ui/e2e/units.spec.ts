// The page in feet and knots: chosen in the settings, remembered, said everywhere, and taken from what is typed; what the program is told
// and what the tests read from the canvas stays metric.

import type { Locator, Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, card, expect, hold, open, plotted, selectAll, summary, test } from './console';
import { Program } from './program';

const VEHICLES = 2;
const FLIGHT_MS = 60_000;
const FOOT_M = 0.3048;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

const field = (page: Page, name: string): Locator => page.getByRole('spinbutton', { name, exact: true });
const figure = (page: Page, id: number, name: string): Locator => card(page, id).locator('dl > div').filter({ hasText: name }).locator('dd').first();

async function choose(page: Page, units: RegExp): Promise<void> {
  await button(page, 'Settings').click();
  await page.getByRole('radio', { name: units }).check();
  expect(await findings(page)).toEqual([]);
  await page.keyboard.press('Escape');
  await expect(page.getByRole('dialog')).toHaveCount(0);
}

test('in feet and knots a fleet is flown', { tag: '@long' }, async ({ page }) => {
  const told = page.getByTestId('forecast');
  await open(page, program.url, VEHICLES);

  await test.step('the height of before is the same in another unit', async () => {
    await selectAll(page);
    await expect(field(page, 'Take-off height')).toHaveValue('10');
    await expect(figure(page, 1, 'Height')).toHaveText(/^-?\d+\.\d m$/);
    await choose(page, /^Aviation/);
    await expect(field(page, 'Take-off height')).toHaveValue('32.8');
    await expect(field(page, 'Take-off height')).toHaveAccessibleDescription('ft');
    await expect(field(page, 'Spacing')).toHaveValue('16.4');
    await expect(figure(page, 1, 'Height')).toHaveText(/^-?\d+ ft$/);
    await expect(figure(page, 1, 'Speed')).toHaveText(/^\d+\.\d kn$/);
    await button(page, `Take off ${VEHICLES}`).hover();
    await expect(told).toContainText('climb to 32.8 ft and hold there');
  });

  await test.step('what is typed is feet, digit by digit, and what is sent is metres', async () => {
    await field(page, 'Take-off height').fill('');
    // Two feet are less than is allowed, and the beginning of twenty.
    await field(page, 'Take-off height').pressSequentially('20');
    await expect(field(page, 'Take-off height')).toHaveValue('20');
    await field(page, 'Take-off height').press('Tab');
    await expect(field(page, 'Take-off height')).toHaveValue('20');
    // The button that the focus went on to is told of, until the pointer comes to another.
    await page.mouse.move(0, 0);
    await button(page, `Take off ${VEHICLES}`).hover();
    await expect(told).toContainText('climb to 20 ft and hold there');
    const sent = page.waitForRequest((request) => request.method() === 'POST' && request.url().endsWith('/commands'));
    await hold(page, `Take off ${VEHICLES}`);
    const { command } = (await sent).postDataJSON() as { command: { command: string; height_m: number } };
    expect(command.command).toBe('take_off');
    expect(command.height_m).toBeCloseTo(20 * FOOT_M, 9);
    await expect(summary(page)).toContainText('Take off 20 ft');
    await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
    await expect.poll(async () => parseInt((await figure(page, 1, 'Height').textContent()) ?? ''), { timeout: FLIGHT_MS }).toBeGreaterThan(15);
    expect(parseInt((await figure(page, 1, 'Height').textContent()) ?? '')).toBeLessThan(26);
  });

  await test.step('what is less than allowed is put right when the field is left', async () => {
    await field(page, 'Take-off height').fill('2');
    await expect(field(page, 'Take-off height')).toHaveValue('2');
    await field(page, 'Take-off height').press('Tab');
    await expect(field(page, 'Take-off height')).toHaveValue('3.3');
    await field(page, 'Take-off height').fill('20');
  });

  await test.step('the map measures in feet', async () => {
    await button(page, 'Clear').click();
    for (const id of [1, 2]) await button(page, new RegExp(`^Target ${id},`)).click();
    await page.getByRole('application').focus();
    await page.keyboard.press('m');
    await expect(page.getByTestId('measured')).toHaveText(/^\d+(\.\d)? ft, \d{3}°, [+−]\d+ ft up$/);
    const shown = parseFloat((await page.getByTestId('measured').textContent()) ?? '');
    const [a, b] = await plotted(page);
    expect(Math.abs(shown * FOOT_M - Math.hypot(a!.northM - b!.northM, a!.eastM - b!.eastM))).toBeLessThan(0.5);
    await page.keyboard.press('Escape');
    await button(page, 'Clear').click();
  });

  await test.step('so do a formation, a route, and a place', async () => {
    await selectAll(page);
    await field(page, 'Spacing').fill('20');
    const previewed = page.waitForRequest((request) => request.url().endsWith('/formation/preview'));
    await page.getByRole('radio', { name: 'Line', exact: true }).check({ force: true });
    const asked = (await previewed).postDataJSON() as { spacing_m: number };
    expect(asked.spacing_m).toBeCloseTo(20 * FOOT_M, 9);
    await expect(page.getByTestId('preview-said')).toContainText(/closest in place: 20\.0 ft/i);
    await page.getByRole('checkbox', { name: 'Preview on the map' }).uncheck();
    await button(page, 'Clear').click();
    await page.getByRole('tab', { name: 'Route' }).click();
    await button(page, 'Point').click();
    await expect(field(page, 'Point 1 north')).toHaveValue('32.8');
    await expect(field(page, 'Point 1 north')).toHaveAccessibleDescription('ft N');
    await expect(field(page, 'Speed')).toHaveAccessibleDescription('kn');
    await button(page, 'Clear').click();
  });

  await test.step('table, charts and facts of a vehicle', async () => {
    const pages = page.getByRole('navigation', { name: 'Pages' });
    await pages.getByRole('link', { name: 'Fleet' }).click();
    await expect(page.locator('[data-row="1"]')).toContainText(/\d ft/);
    expect(await findings(page)).toEqual([]);
    await page.goto(`${program.url}/#vehicle/1`);
    const vehicle = page.getByRole('region', { name: 'Vehicle 1' });
    await expect(vehicle.locator('figcaption').filter({ hasText: 'Height above launch' })).toContainText(/\d ft/);
    await expect(vehicle.locator('figcaption').filter({ hasText: 'Speed' })).toContainText(/\d kn/);
    await expect(vehicle).toContainText(/\d ft\/min/);
    expect(await findings(page)).toEqual([]);
    await page.goto(`${program.url}/#map`);
  });

  await test.step('they are remembered, and metric comes back', async () => {
    await page.reload();
    await expect(field(page, 'Take-off height')).toHaveValue('32.8');
    await expect(figure(page, 1, 'Height')).toHaveText(/^\d+ ft$/);
    for (const width of [360, 390, 1024, 1920, 1440]) {
      await page.setViewportSize({ width, height: 900 });
      expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), `${width} px`).toBeLessThanOrEqual(0);
    }
    await choose(page, /^Metric/);
    await expect(field(page, 'Take-off height')).toHaveValue('10');
    await expect(figure(page, 1, 'Height')).toHaveText(/^[56]\.\d m$/);
    await hold(page, `LAND ALL ${VEHICLES}`);
    await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
  });
});

test.describe('where the browser wants German', () => {
  test.use({ locale: 'de-AT' });

  test('the units are a choice of their own', { tag: '@long' }, async ({ page }) => {
    await page.goto(program.url);
    await expect(page.getByTestId('count-all')).toHaveText(`${VEHICLES}`, { timeout: 60_000 });
    await button(page, 'Einstellungen').click();
    await page.getByRole('radio', { name: /^Luftfahrt/ }).check();
    await page.keyboard.press('Escape');
    await button(page, `Alle ${VEHICLES} auswählen`).click();
    await button(page, `Starten ${VEHICLES}`).hover();
    await expect(page.getByTestId('forecast')).toContainText('auf 32.8 ft steigen und dort halten');
    await expect(figure(page, 1, 'Höhe')).toHaveText(/^-?\d+ ft$/);
  });
});
