// The logs that an autopilot keeps itself: listed on the page of its vehicle, fetched on the ground, and found beside the recording of the flight.

import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Locator, Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, expect, hold, open, selectAll, test } from './console';
import { Program } from './program';

const VEHICLES = 2;
/** Log 0 of simulated vehicle 1. */
const SIZE_BYTES = 200_007;
const FETCH_MS = 60_000;
const FLIGHT_MS = 60_000;
/** What each file of logs begins with. */
const ULOG = Buffer.from('ULog');

let folder: string;
let program: Program;
test.beforeEach(async () => {
  folder = mkdtempSync(join(tmpdir(), 'skein-logs-'));
  program = await Program.start(VEHICLES, 0, ['--record', folder]);
});
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
  await program.stop();
  rmSync(folder, { recursive: true });
});

const fetched = (page: Page): Locator => page.getByTestId('log-fetch');

/** Opens the logs of a vehicle from its page and waits until they are listed. */
async function list(page: Page, id: number): Promise<void> {
  await open(page, program.url, VEHICLES);
  await page.goto(`${program.url}/#vehicle/${id}`);
  await page.getByRole('link', { name: 'Logs', exact: true }).click();
  await expect(page.locator('[data-log]')).toHaveCount(2);
}

/** What a link leads to. */
async function download(page: Page, link: Locator): Promise<Buffer> {
  const response = await page.request.get((await link.getAttribute('href'))!);
  expect(response.ok()).toBe(true);
  return response.body();
}

/** The page of the logs, and the two that lead to it and away from it, are as wide as their room. */
async function fits(page: Page): Promise<void> {
  for (const place of ['vehicle/1/logs', 'vehicle/1', 'flights']) {
    await page.goto(`${program.url}/#${place}`);
    await expect(page.locator(place === 'flights' ? '[data-logs-of]' : '.center header').first()).toBeVisible();
    for (const [width, height] of [[360, 740], [820, 1180], [1024, 768], [1440, 900], [1920, 1080]] as const) {
      await page.setViewportSize({ width, height });
      const over = await page.evaluate(() => [document.documentElement, ...document.querySelectorAll('.center > *')].map((part) => part.scrollWidth - part.clientWidth));
      expect(Math.max(...over), `${place} at ${width} px`).toBeLessThanOrEqual(0);
    }
  }
}

test('a log is listed, fetched, downloaded, and found beside the recording', async ({ page }) => {
  await list(page, 1);
  await expect(page.locator('[data-log="0"]')).toContainText('200 kB');
  await expect(page.locator('[data-log="1"]')).toContainText('100 kB');
  expect(await findings(page)).toEqual([]);

  await button(page, 'Fetch log 0').click();
  await expect(fetched(page)).toContainText(/log 0/);
  await expect(fetched(page)).toContainText('Log 0 was fetched, 200 kB', { timeout: FETCH_MS });
  expect(await findings(page)).toEqual([]);
  const link = page.getByRole('link', { name: /^Download .+_uav-1_0\.ulg$/ });
  const log = await download(page, link);
  expect([log.length, log.subarray(0, 4)]).toEqual([SIZE_BYTES, ULOG]);

  // How it ended is still there when the page is opened anew.
  await page.reload();
  await expect(fetched(page)).toContainText('Log 0 was fetched, 200 kB');
  await expect(button(page, 'Fetch log 1')).toBeEnabled();

  await page.getByRole('link', { name: 'Recorded flights' }).click();
  const beside = page.locator('[data-logs-of]').getByRole('link', { name: /^uav-1, log 0: Download / });
  await expect(beside).toHaveText('uav-1, log 0');
  expect((await download(page, beside)).equals(log)).toBe(true);
  expect(await findings(page)).toEqual([]);
});

test('a fetch that is under way is shown, and none is fetched of an armed vehicle', { tag: '@long' }, async ({ page }) => {
  await list(page, 1);
  // It would be there before anybody has seen it: what the node says of it is held at the half.
  const answer = { fetch: { log: { number: 0, size_bytes: 200_000, written_unix_s: null }, received_bytes: 100_000, end: null } };
  await page.route('**/api/v1/vehicles/1/logs/fetch', (route) => route.fulfill({ json: answer }));
  await page.reload();
  await expect(fetched(page)).toContainText('Fetching log 0');
  await expect(fetched(page)).toContainText('100 kB of 200 kB');
  await expect(page.getByRole('progressbar', { name: 'Fetching log 0' })).toHaveJSProperty('value', 0.5);
  await expect(button(page, 'Reload')).toBeDisabled();
  await expect(page.locator('[data-log]')).toHaveCount(0);
  expect(await findings(page)).toEqual([]);
  await page.unroute('**/api/v1/vehicles/1/logs/fetch');
  await expect(page.locator('[data-log]')).toHaveCount(2);

  await page.goto(`${program.url}/#map`);
  await button(page, 'Clear').click();
  await selectAll(page);
  await hold(page, `Take off ${VEHICLES}`);
  await expect(page.getByTestId('count-air')).toHaveText(`${VEHICLES}`, { timeout: FLIGHT_MS });
  await page.goto(`${program.url}/#vehicle/1/logs`);
  await expect(page.getByText('The vehicle is armed. Logs are fetched on the ground only.')).toBeVisible();
  await expect(button(page, 'Reload')).toBeDisabled();
  for (const one of await page.getByRole('button', { name: /^Fetch log/ }).all()) await expect(one).toBeDisabled();
  expect(await findings(page)).toEqual([]);
});

test('the page fits a phone, and speaks German', { tag: '@long' }, async ({ page }) => {
  await list(page, 1);
  await button(page, 'Fetch log 1').click();
  await expect(fetched(page)).toContainText('Log 1 was fetched', { timeout: FETCH_MS });
  await fits(page);
  await page.evaluate(() => localStorage.setItem('skein-language', 'de'));
  await page.goto(`${program.url}/#vehicle/1/logs`);
  await page.reload();
  await expect(fetched(page)).toContainText('Log 1 wurde geholt');
  await expect(button(page, 'Log 0 holen')).toBeEnabled();
  expect(await findings(page)).toEqual([]);
  await fits(page);
});
