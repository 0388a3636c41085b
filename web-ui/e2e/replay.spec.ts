// A flight is recorded, found on the page of flights and looked at again: marked as over, gone through by the keyboard, and nothing of it can be commanded.

import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, expect, open, plotted, test } from './console';
import { Program } from './program';

const VEHICLES = 2;
const HEIGHT_M = 4;
/** Up, and down again. */
const FLIGHT_MS = 60_000;

let folder: string;
let program: Program;
test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), 'skein-flights-'));
  program = await Program.start(VEHICLES, 0, ['--record', folder]);
});
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
});
test.afterAll(async () => {
  await program.stop();
  rmSync(folder, { recursive: true });
});

const landed = (page: Page) => page.getByTestId('landed');
const flown = (page: Page) => page.locator('[data-flight]').filter({ hasText: 'flown' });
const slider = (page: Page) => page.getByRole('slider', { name: 'Time in the recording' });

async function command(page: Page, what: object): Promise<void> {
  const response = await page.request.post(`${program.url}/api/v1/commands`, { data: { targets: 'all', command: what } });
  expect(response.ok()).toBe(true);
}

/** Greatest height of a vehicle as its card has it, in metres. */
async function greatestHeightM(page: Page): Promise<number> {
  const heights = await page.locator('[data-vehicle] dd:first-of-type').evaluateAll((all) => all.map((one) => (one.previousElementSibling?.textContent === 'Height' ? Number.parseFloat(one.textContent ?? '') : NaN)));
  return Math.max(-1, ...heights.filter((height) => !Number.isNaN(height)));
}

/** Flies up and down with a page open, from take-off to the end of the recording; gives the file. */
async function fly(page: Page): Promise<string> {
  const recorder = page.getByTestId('recorder');
  await expect(recorder).toHaveAccessibleName('REC: Flights are recorded; nobody flies');
  await command(page, { command: 'take_off', height_m: HEIGHT_M });
  await expect(page.getByTestId('flight-state').filter({ hasText: 'Holding' })).toHaveCount(VEHICLES, { timeout: FLIGHT_MS });
  await expect(recorder).toHaveAccessibleName(/^REC: This flight is recorded: /);
  await command(page, { command: 'land' });
  await expect(landed(page)).toContainText('Flight recorded', { timeout: FLIGHT_MS });
  return (await landed(page).locator('span').innerText()).trim();
}

test('a recorded flight is found, and looked at again', async ({ page, context, watch }) => {
  let file = '';
  await test.step('it is recorded, and after the landing the page says so', async () => {
    await open(page, program.url, VEHICLES);
    file = await fly(page);
    const at = `${program.url.replace(/\/$/, '')}/`;
    await expect(landed(page).getByRole('link', { name: 'Replay' })).toHaveAttribute('href', `${at}replay/${file}/`);
    await landed(page).getByRole('button', { name: 'Put this message away' }).click();
    await expect(landed(page)).toHaveCount(0);
  });
  await test.step('it is in the list', async () => {
    await page.getByTestId('recorder').click();
    await expect(page.getByRole('heading', { name: /^Recorded flights/ })).toBeVisible();
    await expect(flown(page)).toHaveCount(1);
    await expect(flown(page)).toHaveAttribute('data-flight', file);
    await expect(flown(page)).toContainText('demo');
    expect(await findings(page)).toEqual([]);
    const report = await page.request.get((await flown(page).getByRole('link', { name: /^Report/ }).getAttribute('href'))!);
    expect(report.headers()['content-type']).toContain('text/html');
    const download = page.waitForEvent('download');
    await flown(page).getByRole('link', { name: /^Download/ }).click();
    expect((await download).suggestedFilename()).toBe(file);
  });

  const tab = context.waitForEvent('page');
  await flown(page).getByRole('link', { name: /^Replay/ }).click();
  const replay = await tab;
  const faults: string[] = [];
  replay.on('console', (message) => (message.type() === 'error' || message.type() === 'warning') && faults.push(message.text()));
  replay.on('pageerror', (error) => faults.push(error.message));
  // The page watched is the one it was opened from.
  watch.expected.push(/net::ERR_ABORTED/);

  await test.step('its page says that it is over, and shows the vehicles', async () => {
    await expect(replay.getByTestId('replay-bar')).toContainText('recorded flight, not live');
    await expect(replay.getByTestId('reality')).toHaveText('REPLAY');
    await expect(replay).toHaveTitle(/^Replay /);
    // It begins with the node, before a vehicle is heard.
    await expect(slider(replay)).toHaveAttribute('aria-valuemax', /^[1-9]\d+$/);
    await slider(replay).focus();
    await replay.keyboard.press('End');
    await expect(replay.getByTestId('count-all')).toHaveText(`${VEHICLES}`);
    await expect.poll(async () => (await plotted(replay)).length).toBe(VEHICLES);
    expect(await findings(replay)).toEqual([]);
  });
  await test.step('nothing that commands is there, and what commands is refused', async () => {
    for (const name of ['Commands', 'Safety']) await expect(replay.getByRole('region', { name, exact: true })).toHaveCount(0);
    await expect(button(replay, /EMERGENCY STOP/)).toHaveCount(0);
    await expect(replay.getByRole('tab', { name: 'Formation' })).toHaveCount(0);
    for (const name of ['Video', 'Preflight', 'Plugins', 'Links', 'Flights']) await expect(replay.getByRole('navigation', { name: 'Pages' }).getByRole('link', { name })).toHaveCount(0);
    const refused = await replay.request.post(new URL('api/v1/commands', replay.url()).href, { data: { targets: 'all', command: { command: 'land' } } });
    expect(refused.status()).toBe(409);
    expect(((await refused.json()) as { error: { code: string } }).error.code).toBe('replaying');
  });
  await test.step('the keyboard goes to any moment of it, and the vehicles are where they were', async () => {
    await slider(replay).focus();
    await replay.keyboard.press('End');
    await expect(replay.getByTestId('count-ground')).toHaveText(`${VEHICLES}`);
    expect(await greatestHeightM(replay)).toBeLessThan(0.5);
    expect(await slider(replay).getAttribute('aria-valuenow')).toBe(await slider(replay).getAttribute('aria-valuemax'));
    // Event after event backwards, until somebody is in the air.
    await expect(async () => {
      await replay.keyboard.press('b');
      await expect.poll(() => greatestHeightM(replay), { timeout: 1500 }).toBeGreaterThan(HEIGHT_M / 2);
    }).toPass({ timeout: 30_000 });
    await expect(replay.getByTestId('count-air')).not.toHaveText('0');
    await replay.keyboard.press('Home');
    await expect(slider(replay)).toHaveAttribute('aria-valuenow', '0');
    await expect(replay.getByTestId('count-air')).toHaveText('0');
    // Nothing of the page is told as an alarm, and the log is that of the moment.
    await expect(replay.getByRole('log', { name: 'Events' })).not.toContainText('the server was restarted');
  });
  await test.step('it goes on, as fast as one likes, and stands still', async () => {
    await replay.getByRole('combobox', { name: 'Speed of the replay' }).selectOption('20×');
    await replay.keyboard.press('Escape');
    await slider(replay).focus();
    await replay.keyboard.press('Space');
    await expect(button(replay, 'Pause')).toBeVisible();
    await expect.poll(() => greatestHeightM(replay), { intervals: [50] }).toBeGreaterThan(HEIGHT_M / 2);
    await replay.keyboard.press('Space');
    await expect(button(replay, 'Play')).toBeVisible();
    const stands = await replay.getByTestId('replay-position').innerText();
    await replay.waitForTimeout(600);
    expect(await replay.getByTestId('replay-position').innerText()).toBe(stands);
  });
  await test.step('on a tablet and on a phone nothing stands out of the screen', async () => {
    for (const [width, height] of [[1024, 768], [768, 1024], [390, 844]] as const) {
      await replay.setViewportSize({ width, height });
      await expect(slider(replay)).toBeInViewport();
      await expect(button(replay, 'Play')).toBeInViewport();
      expect(await replay.evaluate(() => document.documentElement.scrollWidth - innerWidth), `${width} px`).toBeLessThanOrEqual(0);
    }
  });
  expect(faults).toEqual([]);
  await replay.close();
});
