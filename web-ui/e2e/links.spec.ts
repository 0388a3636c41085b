// Nodes and links: what goes over the endpoints, how each vehicle is heard, and one that falls silent.

import type { ChildProcess } from 'node:child_process';
import type { Locator, Page } from '@playwright/test';
import { findings } from './accessibility';
import { expect, test } from './console';
import { Program, freePort } from './program';

const SLOW_MS = 60_000;

let program: Program;
const vehicles: ChildProcess[] = [];
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
  for (const vehicle of vehicles.splice(0)) vehicle.kill('SIGKILL');
  await program.stop();
});

const link = (page: Page, id: number): Locator => page.locator(`[data-link="${id}"]`);
/** The number that a cell begins with, counted from nought. */
const figure = async (row: Locator, cell: number): Promise<number> => parseFloat((await row.locator('td').nth(cell).textContent()) ?? '');

test('what comes and goes is shown, and who is not heard any more', { tag: '@long' }, async ({ page }) => {
  const port = await freePort();
  const sendTo = `127.0.0.1:${port}`;
  program = await Program.node([
    '[[endpoints]]', 'name = "sitl"', `address = "udp-listen://${sendTo}"`, '[[adopt]]', 'model = "generic-uav"',
  ]);
  vehicles.push(Program.vehicles(1, 1, sendTo), Program.vehicles(1, 2, sendTo));
  await page.goto(`${program.url}/#links`);
  await expect(page.getByRole('heading', { name: 'Nodes and links' })).toBeVisible();
  await expect(page.getByText('This node is on its own')).toBeVisible();
  const endpoint = page.locator('[data-endpoint="sitl"]');
  await expect(endpoint).toContainText(sendTo, { timeout: SLOW_MS });
  for (const id of [1, 2]) await expect(link(page, id)).toContainText('heard', { timeout: SLOW_MS });
  await expect.poll(() => figure(endpoint, 0), { timeout: SLOW_MS }).toBeGreaterThan(0);
  await expect.poll(() => figure(endpoint, 1), { timeout: SLOW_MS }).toBeGreaterThan(0);
  await expect.poll(() => figure(link(page, 1), 3), { timeout: SLOW_MS }).toBeGreaterThan(5);
  await expect(link(page, 1).locator('td').nth(1)).toHaveText(/^\d+\.\d ms$/, { timeout: SLOW_MS });
  expect(await findings(page)).toEqual([]);

  vehicles[1]!.kill('SIGKILL');
  await expect(link(page, 2)).toContainText('not heard for', { timeout: SLOW_MS });
  await expect(link(page, 1)).not.toContainText('not heard for');
  expect(await findings(page)).toEqual([]);

  for (const width of [360, 390, 1024]) {
    await page.setViewportSize({ width, height: 800 });
    expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), `${width} px`).toBeLessThanOrEqual(0);
  }
  await link(page, 1).getByRole('link').click();
  await expect(page.getByRole('region', { name: 'Vehicle 1' })).toBeVisible();
});
