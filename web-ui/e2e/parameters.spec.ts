// The parameters of an autopilot: read, found, changed and refused, on the page of its vehicle.

import type { Locator, Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, expect, hold, open, selectAll, test } from './console';
import { Program } from './program';

const VEHICLES = 2;
const READ_MS = 30_000;

let program: Program;
test.beforeEach(async () => {
  program = await Program.start(VEHICLES);
});
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
  await program.stop();
});

const line = (page: Page, name: string): Locator => page.locator(`[data-parameter="${name}"]`);
const outcome = (page: Page): Locator => page.getByTestId('write-outcome');

/** Opens the parameters of a vehicle and waits until all are there. */
async function read(page: Page, id: number): Promise<void> {
  await open(page, program.url, VEHICLES);
  await page.goto(`${program.url}/#vehicle/${id}`);
  await page.getByRole('link', { name: 'Parameters' }).click();
  await expect(page.getByTestId('reading')).toContainText(/^All \d+ read$/, { timeout: READ_MS });
}

test('parameters are read, found, changed by a hold, and marked as changed here', { tag: '@long' }, async ({ page }) => {
  await read(page, 1);
  const all = await page.getByTestId('parameter-count').textContent();
  expect(Number(/of (\d+)/.exec(all!)![1])).toBeGreaterThan(50);
  expect(await findings(page)).toEqual([]);

  await page.getByRole('searchbox', { name: 'Find parameters by name' }).fill('mpc cruise');
  await expect(page.locator('[data-parameter]')).toHaveCount(1);
  await expect(line(page, 'MPC_XY_CRUISE')).toContainText('5');

  // By the keyboard alone.
  await button(page, 'Change MPC_XY_CRUISE').focus();
  await page.keyboard.press('Enter');
  const field = page.getByRole('textbox', { name: /^MPC_XY_CRUISE/ });
  await expect(field).toBeFocused();
  await expect(button(page, 'Write MPC_XY_CRUISE of 1')).toBeDisabled();
  await field.fill('six');
  await expect(page.getByRole('form', { name: 'Change MPC_XY_CRUISE' })).toContainText('That is no number.');
  await field.fill('6,5');
  expect(await findings(page)).toEqual([]);
  await hold(page, 'Write MPC_XY_CRUISE of 1');
  await expect(outcome(page)).toHaveText('MPC_XY_CRUISE is 6.5 now, was 5');
  await expect(line(page, 'MPC_XY_CRUISE')).toContainText('was 5');
  await field.press('Escape');
  await expect(button(page, 'Change MPC_XY_CRUISE')).toBeFocused();

  await page.getByRole('searchbox', { name: 'Find parameters by name' }).fill('');
  await page.getByRole('checkbox', { name: 'Changed here (1)' }).check();
  await expect(page.locator('[data-parameter]')).toHaveCount(1);
  await page.getByRole('checkbox', { name: 'Changed here (1)' }).uncheck();

  // In the other order, and still no more drawn than is seen.
  await page.getByRole('checkbox', { name: 'By prefix' }).uncheck();
  const first = await page.locator('[data-parameter]').first().getAttribute('data-parameter');
  await button(page, 'Name').click();
  await expect(page.locator('[data-parameter]').first()).not.toHaveAttribute('data-parameter', first!);
  expect(await page.locator('[data-parameter]').count()).toBeLessThan(60);

  await page.goto(`${program.url}/#alerts`);
  await expect(page.getByRole('log')).toContainText('parameter MPC_XY_CRUISE set to 6.5, was 5');
});

test('a whole number takes no other, and a refusal is said in words', { tag: '@long' }, async ({ page, watch, browser }) => {
  watch.expected.push(/409/);
  await read(page, 2);
  const search = page.getByRole('searchbox', { name: 'Find parameters by name' });
  await search.fill('COM_RC_IN_MODE');
  await button(page, 'Change COM_RC_IN_MODE').click();
  const field = page.getByRole('textbox', { name: /^COM_RC_IN_MODE/ });
  await field.fill('1.5');
  await expect(page.getByRole('form')).toContainText('This parameter takes whole numbers.');
  await expect(button(page, 'Write COM_RC_IN_MODE of 2')).toBeDisabled();

  // Somebody else takes control authority over the vehicle.
  const context = await browser.newContext();
  const other = await context.newPage();
  await open(other, program.url, VEHICLES);
  await button(other, /^Target 2,/).click();
  await button(other, 'Take 1').click();
  await expect(page.getByTestId('authority').first()).toBeVisible();
  await field.fill('3');
  await hold(page, 'Write COM_RC_IN_MODE of 2');
  await expect(outcome(page)).toContainText('Not written: vehicle 2 is under the control of');
  await expect(line(page, 'COM_RC_IN_MODE')).toContainText('4');
  await context.close();
});

test('nothing is written to an armed vehicle', { tag: '@long' }, async ({ page }) => {
  await read(page, 1);
  await button(page, 'Change BAT_CRIT_THR').click();
  await page.getByRole('textbox', { name: /^BAT_CRIT_THR/ }).fill('0.08');
  await expect(button(page, 'Write BAT_CRIT_THR of 1')).toBeEnabled();
  await page.getByRole('textbox', { name: /^BAT_CRIT_THR/ }).press('Escape');
  await page.goto(`${program.url}/#map`);
  await button(page, 'Clear').click();
  await selectAll(page);
  await hold(page, `Take off ${VEHICLES}`);
  await page.goto(`${program.url}/#vehicle/1/parameters`);
  await expect(page.getByText('The vehicle is armed: nothing can be written.')).toBeVisible({ timeout: READ_MS });
  await expect(button(page, 'Change BAT_CRIT_THR')).toBeDisabled();
  expect(await findings(page)).toEqual([]);
});

test('the page fits a phone, and speaks German', { tag: '@long' }, async ({ page }) => {
  await read(page, 1);
  await page.setViewportSize({ width: 360, height: 740 });
  expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
  await page.evaluate(() => localStorage.setItem('skein-language', 'de'));
  await page.reload();
  await expect(page.getByTestId('reading')).toContainText(/^Alle \d+ gelesen$/, { timeout: READ_MS });
  expect(await findings(page)).toEqual([]);
});
