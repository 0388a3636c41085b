// Plugins exchanged, started anew, stopped and given up in front of the operator: really built ones, in the real program.

import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Locator, Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, card, expect, hold, open, summary, test } from './console';
import { Program, install } from './program';

const VEHICLES = 6;
/** Those that the demonstration flies with `generic-uav`. */
const GENERIC = [3, 6];
/** Those that carry a gimbal. */
const CARRIERS = [2, 5];
const SHIPPED = /^generic-uav (\d+\.\d+\.\d+), uav model$/i;
const FLIGHT_MS = 90_000;
/** Some seconds of back-off, and the rest for a slow machine. */
const RESTART_MS = 30_000;
/** More failures than this within a minute are not forgiven. */
const MOST_FAILURES = 25;

let program: Program;
let folder: string;
test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), 'skein-plugins-'));
  program = await Program.start(VEHICLES, 0, folder);
});
test.afterAll(async () => {
  await program.stop();
  rmSync(folder, { recursive: true });
});

test.beforeEach(async ({ page }) => {
  await open(page, program.url, VEHICLES);
});

const leaf = (page: Page, name: string): Locator => page.locator(`[data-supervised="${name}"]`);
const status = (page: Page, name: string): Locator => leaf(page, name).getByTestId('supervised-status');
const incarnation = async (page: Page, name: string): Promise<number> => Number(await leaf(page, name).getByTestId('supervised-incarnation').textContent());
const listed = (page: Page, plugin: string): Locator => page.locator(`[data-plugin="${plugin}"]`);
const outcome = (page: Page): Locator => page.getByTestId('plugin-outcome');

async function toPlugins(page: Page): Promise<void> {
  await page.getByRole('link', { name: 'Plugins' }).click();
  await expect(page.getByTestId('supervision-sum')).toHaveText(/^all \d+ run$/, { timeout: RESTART_MS });
}

test('what fails again and again is given up in its open panel, refuses with the reason, and is started anew there', async ({ page, watch }) => {
  watch.expected.push(/status of 503/);
  await page.goto(`${program.url}/#vehicle/2`);
  const gimbal = page.locator('[data-instance="payload-2-gimbal"]');
  const is = gimbal.getByTestId('instance-status');
  const number = async (): Promise<number> => Number(await gimbal.getByTestId('instance-incarnation').textContent());
  await expect(is).toHaveText('Running');
  await gimbal.getByRole('button', { name: 'Take control' }).first().click();
  await expect(page.getByText('gimbal take control: taken up')).toBeVisible();

  for (let k = 0; k < MOST_FAILURES && (await is.textContent()) !== 'Given up'; k++) {
    const before = await number();
    const crash = await page.request.post(`${program.url}/api/v1/faults`, { data: { fault: 'plugin_panic', vehicle: 2, payload: 'gimbal' } });
    expect(crash.ok()).toBe(true);
    await expect.poll(number, { timeout: RESTART_MS }).toBeGreaterThan(before);
    // The first time it is back by itself; the panel stays what it was and says what happened.
    if (k > 0) continue;
    await expect(is).toHaveText('Running', { timeout: RESTART_MS });
    await expect(gimbal.getByTestId('instance-restarts')).toHaveText('1');
    await expect(gimbal).toContainText('Last error: panicked');
    await gimbal.getByRole('button', { name: 'Ahead' }).click();
    await expect(page.getByText('gimbal ahead: taken up')).toBeVisible();
  }
  await expect(is).toHaveText('Given up');
  const panel = page.getByTestId('payload-panel').filter({ has: gimbal });
  await expect(panel.getByText(/^Degraded:.*gimbal/)).toBeVisible();
  await gimbal.getByRole('button', { name: 'Ahead' }).click();
  await expect(panel.getByRole('status').filter({ hasText: 'gimbal ahead: payload gimbal of vehicle 2 is not running' })).toBeVisible();
  expect(await findings(page)).toEqual([]);

  // What stands beside it is well, and the tree says which one is not.
  await expect(page.locator('[data-instance="payload-2-radio"]').getByTestId('instance-status')).toHaveText('Running');
  await page.getByRole('link', { name: 'Plugins' }).click();
  await expect(page.getByTestId('supervision-sum')).toHaveText(/^1 of \d+ not running$/);
  await expect(status(page, 'payload-2-gimbal')).toHaveText('given up');
  await expect(page.locator('[data-branch="2"]')).toContainText('Degraded:');
  expect(await findings(page)).toEqual([]);

  await page.goBack();
  await expect(is).toHaveText('Given up');
  await hold(page, gimbal.getByRole('button', { name: 'Restart' }));
  await expect(is).toHaveText('Running', { timeout: RESTART_MS });
  await expect(panel.getByText(/^Degraded:/)).toHaveCount(0);
  await gimbal.getByRole('button', { name: 'Ahead' }).click();
  await expect(page.getByText('gimbal ahead: taken up')).toBeVisible();
});

test('what is stopped is gone from the tree, is not forgotten while a rule names it, and is back when it is attached', async ({ page, watch }) => {
  watch.expected.push(/status of 409/);
  await toPlugins(page);
  await expect(listed(page, 'gimbal')).toContainText('Used by 2: payload-2-gimbal, payload-5-gimbal');
  for (const id of CARRIERS) {
    await hold(page, leaf(page, `payload-${id}-gimbal`).getByRole('button', { name: 'Stop' }));
    await expect(page.getByText(`payload-${id}-gimbal stop: taken up`)).toBeVisible();
    await expect(leaf(page, `payload-${id}-gimbal`)).toHaveCount(0);
  }
  await expect(page.getByTestId('supervision-sum')).toHaveText(/^all \d+ run$/);
  await expect(listed(page, 'gimbal')).toContainText('Nothing uses it.');
  await hold(page, listed(page, 'gimbal').getByRole('button', { name: 'Remove' }));
  await expect(outcome(page)).toContainText('gimbal removal: "gimbal" is in use by the adoption rule');
  await expect(listed(page, 'gimbal')).toBeVisible();

  for (const id of CARRIERS) {
    const attached = await page.request.post(`${program.url}/api/v1/vehicles/${id}/payloads`, { data: { name: 'gimbal', plugin: 'gimbal' } });
    expect(attached.ok()).toBe(true);
    await expect(status(page, `payload-${id}-gimbal`)).toHaveText('running', { timeout: RESTART_MS });
  }
  await expect(listed(page, 'gimbal')).toContainText('Used by 2: payload-2-gimbal, payload-5-gimbal');
});

test('a new plugin is found, a file that is none is named with its fault, and what nothing uses is forgotten', async ({ page }) => {
  await toPlugins(page);
  await expect(listed(page, 'frame-counter')).toHaveCount(0);
  install('frame_counter', folder);
  install('no_symbol', folder);
  await button(page, 'Look for new ones').click();
  await expect(listed(page, 'frame-counter')).toContainText('1.0.0');
  await expect(listed(page, 'frame-counter')).toContainText('Nothing uses it.');
  await expect(page.getByText(/^Not taken: .*libno_symbol\.so: it does not export \w+, so it is no plugin$/)).toBeVisible();
  expect(await findings(page)).toEqual([]);
  await hold(page, listed(page, 'frame-counter').getByRole('button', { name: 'Remove' }));
  await expect(outcome(page)).toHaveText('frame-counter is forgotten');
  await expect(listed(page, 'frame-counter')).toHaveCount(0);
});

// The last one: vehicles that have landed are not at once ready for the next.
test('a model is upgraded in flight, stays if the next does not come up, is rolled back and started anew', async ({ page }) => {
  await hold(page, `Take off ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
  await toPlugins(page);
  const generic = listed(page, 'generic-uav');
  const first = SHIPPED.exec((await generic.getByRole('heading').textContent())?.trim() ?? '')?.[1] ?? 'no version is shown';
  const models = GENERIC.map((id) => `model-${id}`);
  const counted = (): Promise<number[]> => Promise.all(models.map((name) => incarnation(page, name)));
  /** Version and incarnations of all its instances, in list and tree, and that the vehicles fly on. */
  const flies = async (version: string, incarnations: readonly number[]): Promise<void> => {
    await expect(generic.getByRole('heading')).toContainText(`generic-uav ${version},`);
    for (const name of models) await expect(leaf(page, name)).toContainText(`generic-uav ${version}, node's process`, { timeout: RESTART_MS });
    await expect.poll(counted, { timeout: RESTART_MS }).toEqual(incarnations);
    for (const name of models) {
      await expect(status(page, name)).toHaveText('running');
      // None of it was a failure.
      await expect(leaf(page, name).getByTestId('supervised-restarts')).toHaveText('0');
    }
    for (const id of GENERIC) await expect(card(page, id).getByTestId('flight-state')).toHaveText('Holding');
  };
  const start = await counted();
  await flies(first, start);
  await expect(generic).toContainText(`Used by 2: ${models.join(', ')}`);
  for (const name of [/^Upgrade/, /^Roll back/, 'Remove']) await expect(generic.getByRole('button', { name })).toHaveCount(0);

  await test.step('a newer version is found, and waits until it is asked for', async () => {
    install('good_version', folder);
    await button(page, 'Look for new ones').click();
    await expect(outcome(page)).toContainText('1 with a newer version');
    await expect(generic).toContainText('Version 9.1.0 was found and waits.');
    await flies(first, start);
    expect(await findings(page)).toEqual([]);
    await hold(page, 'Upgrade 2 to 9.1.0');
    await expect(outcome(page)).toHaveText('generic-uav is 9.1.0 now, 2 instances exchanged', { timeout: RESTART_MS });
    await expect(button(page, 'Upgrade 2 to 9.1.0')).toHaveCount(0);
    await flies('9.1.0', start.map((n) => n + 1));
  });

  await test.step('one that does not come up changes nothing, and why is said', async () => {
    install('bad_version', folder);
    await button(page, 'Look for new ones').click();
    await hold(page, 'Upgrade 2 to 9.2.0');
    await expect(outcome(page)).toContainText('generic-uav stays 9.1.0: model-', { timeout: RESTART_MS });
    await expect(outcome(page)).toContainText('a snapshot of another version');
    expect(await findings(page)).toEqual([]);
    await flies('9.1.0', start.map((n) => n + 1));
  });

  await test.step('it goes back to the version before', async () => {
    await hold(page, `Roll back to ${first}`);
    await expect(outcome(page)).toHaveText(`generic-uav is ${first} now, 2 instances exchanged`, { timeout: RESTART_MS });
    await expect(button(page, 'Roll back to 9.1.0')).toBeVisible();
    await flies(first, start.map((n) => n + 2));
  });

  await test.step('one instance is started anew, and the other is not', async () => {
    await hold(page, leaf(page, models[0]!).getByRole('button', { name: 'Restart' }));
    await expect(page.getByText(`${models[0]} restart: taken up`)).toBeVisible();
    await flies(first, start.map((n, k) => (k === 0 ? n + 3 : n + 2)));
  });

  await test.step('the log has all of it', async () => {
    await page.getByRole('link', { name: 'Alerts' }).click();
    await page.getByRole('searchbox', { name: 'Search events' }).fill('plugin generic-uav');
    const log = page.getByRole('list', { name: 'Event log' });
    for (const text of [`9.1.0 instead of ${first}`, '9.2.0 did not come up; 9.1.0 stays', `${first} instead of 9.1.0`]) await expect(log).toContainText(text);
  });
});
