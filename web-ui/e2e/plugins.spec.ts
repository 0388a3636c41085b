// Plugins exchanged, started anew, stopped and given up in front of the operator: really built ones, in the real program.

import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Locator, Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, card, expect, hold, open, selectAll, summary, test } from './console';
import { Program, install } from './program';
import type { PluginHealth, VehicleSnapshot } from '../src/protocol/types';

/** The second one carries a gimbal. */
const MIXED = 2;
/** All flown by one plugin, and with a radio only. */
const ALIKE = 3;
const ALIKE_MODELS = ['model-1', 'model-2', 'model-3'];
const SHIPPED = /^generic-uav (\d+\.\d+\.\d+), uav.model$/i;
const FLIGHT_MS = 90_000;
/** Some seconds of back-off, and the rest for a slow machine. */
const RESTART_MS = 30_000;
/** More failures than this within a minute are not forgiven. */
const MOST_FAILURES = 25;

// What one test stops is not there for the next: each has a program of its own.
let program: Program;
let folder: string;
test.beforeEach(() => {
  folder = mkdtempSync(join(tmpdir(), 'skein-plugins-'));
});
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
  await program.stop();
  rmSync(folder, { recursive: true });
});

async function mixed(page: Page): Promise<void> {
  program = await Program.start(MIXED);
  await open(page, program.url, MIXED);
}

async function alike(page: Page): Promise<void> {
  program = await Program.start(ALIKE, 0, ['--model', 'generic-uav', '--plugins', folder]);
  await open(page, program.url, ALIKE);
}

const leaf = (page: Page, name: string): Locator => page.locator(`[data-supervised="${name}"]`);
const status = (page: Page, name: string): Locator => leaf(page, name).getByTestId('supervised-status');
const incarnation = async (page: Page, name: string): Promise<number> => Number(await leaf(page, name).getByTestId('supervised-incarnation').textContent());
const listed = (page: Page, plugin: string): Locator => page.locator(`[data-plugin="${plugin}"]`);
const outcome = (page: Page): Locator => page.getByTestId('plugin-outcome');

/** The gimbal of 2 as the program has it. */
async function health(page: Page): Promise<PluginHealth> {
  const answer = (await (await page.request.get(`${program.url}/api/v1/vehicles/2`)).json()) as VehicleSnapshot;
  return answer.payloads.find(({ name }) => name === 'gimbal')!.plugin;
}

/** Makes it fail once, and waits until it is back or given up. Not at the pace of the page: only what fails often in a short time is given up. */
async function crash(page: Page): Promise<void> {
  const { incarnation: before } = await health(page);
  const told = await page.request.post(`${program.url}/api/v1/faults`, { data: { fault: 'plugin_panic', vehicle: 2, payload: 'gimbal' } });
  expect(told.ok()).toBe(true);
  const over = async (): Promise<boolean> => {
    const { incarnation, status } = await health(page);
    return incarnation > before || status === 'given_up';
  };
  await expect.poll(over, { timeout: RESTART_MS, intervals: [50] }).toBe(true);
}

test('what fails again and again is given up in its open panel, refuses with the reason, and is started anew there', { tag: '@long' }, async ({ page, watch }) => {
  watch.expected.push(/status of 409/);
  await mixed(page);
  await page.goto(`${program.url}/#vehicle/2`);
  const gimbal = page.locator('[data-instance="payload-2-gimbal"]');
  const is = gimbal.getByTestId('instance-status');
  await expect(is).toHaveText('Running');
  await gimbal.getByRole('button', { name: 'Take control' }).first().click();
  await expect(page.getByText('gimbal Take control: taken up')).toBeVisible();

  await crash(page);
  // Once is forgiven: it is back by itself, the panel stays what it was and says what happened.
  await expect(gimbal.getByTestId('instance-restarts')).toHaveText('1', { timeout: RESTART_MS });
  await expect(is).toHaveText('Running');
  await expect(gimbal).toContainText('Last error: panicked');
  await gimbal.getByRole('button', { name: 'Ahead' }).click();
  await expect(page.getByText('gimbal ahead: taken up')).toBeVisible();

  for (let failures = 1; failures < MOST_FAILURES && (await health(page)).status !== 'given_up'; failures++) await crash(page);
  await expect(is).toHaveText('Given up');
  const panel = page.getByTestId('payload-panel').filter({ has: gimbal });
  await expect(panel.getByText(/^Degraded:.*gimbal/)).toBeVisible();
  await gimbal.getByRole('button', { name: 'Ahead' }).click();
  await expect(panel.getByRole('status').filter({ hasText: 'gimbal ahead: payload gimbal of vehicle 2 is not running' })).toBeVisible();
  expect(await findings(page)).toEqual([]);

  // What stands beside it is well, and the tree says which one is not.
  await expect(page.locator('[data-instance="payload-2-radio"]').getByTestId('instance-status')).toHaveText('Running');
  await page.getByRole('link', { name: 'Plugins' }).click();
  await expect(page.getByTestId('supervision-sum')).toHaveText(/^\d of \d+ not running$/);
  await expect(status(page, 'payload-2-gimbal')).toHaveText('given up');
  await expect(page.locator('[data-branch="2"]')).toContainText('Degraded:');
  expect(await findings(page)).toEqual([]);

  await page.goBack();
  await expect(is).toHaveText('Given up');
  await hold(page, gimbal.getByRole('button', { name: 'Restart' }));
  await expect(is).toHaveText('Running', { timeout: RESTART_MS });
  await expect(panel.getByText(/^Degraded:.*gimbal/)).toHaveCount(0);
  await gimbal.getByRole('button', { name: 'Ahead' }).click();
  await expect(page.getByText('gimbal ahead: taken up')).toBeVisible();
});

test('what is stopped is gone from the tree, is not forgotten while a rule names it, and is back when it is attached', { tag: '@long' }, async ({ page, watch }) => {
  watch.expected.push(/status of 409/);
  await mixed(page);
  await page.getByRole('link', { name: 'Plugins' }).click();
  const gimbal = leaf(page, 'payload-2-gimbal');
  await expect(listed(page, 'gimbal')).toContainText('Used by 1: payload-2-gimbal');
  await expect(listed(page, 'gimbal').getByRole('button', { name: 'Remove' })).toHaveCount(0);
  await hold(page, gimbal.getByRole('button', { name: 'Stop' }));
  await expect(page.getByText('payload-2-gimbal stop: taken up')).toBeVisible();
  await expect(gimbal).toHaveCount(0);
  await expect(listed(page, 'gimbal')).toContainText('Nothing uses it.');
  await hold(page, listed(page, 'gimbal').getByRole('button', { name: 'Remove' }));
  await expect(outcome(page)).toContainText('gimbal removal: "gimbal" is in use by the adoption rule');
  await expect(listed(page, 'gimbal')).toBeVisible();
  await page.goto(`${program.url}/#vehicle/2`);
  await expect(page.locator('[data-instance="payload-2-radio"]')).toBeVisible();
  await expect(page.locator('[data-instance="payload-2-gimbal"]')).toHaveCount(0);

  const attached = await page.request.post(`${program.url}/api/v1/vehicles/2/payloads`, { data: { name: 'gimbal', plugin: 'gimbal' } });
  expect(attached.ok()).toBe(true);
  await expect(page.locator('[data-instance="payload-2-gimbal"]').getByTestId('instance-status')).toHaveText('Running', { timeout: RESTART_MS });
  await page.getByRole('link', { name: 'Plugins' }).click();
  await expect(status(page, 'payload-2-gimbal')).toHaveText('running');
  await expect(listed(page, 'gimbal')).toContainText('Used by 1: payload-2-gimbal');
});

test('a new plugin is found, a file that is none is named with its fault, and what nothing uses is forgotten', { tag: '@long' }, async ({ page }) => {
  await alike(page);
  await page.getByRole('link', { name: 'Plugins' }).click();
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

test('a model is upgraded in flight, stays if the next does not come up, is rolled back and started anew', { tag: '@long' }, async ({ page }) => {
  await alike(page);
  await selectAll(page);
  await hold(page, `Take off ${ALIKE}`);
  await expect(summary(page)).toContainText(`${ALIKE} of ${ALIKE} done`, { timeout: FLIGHT_MS });
  await page.getByRole('link', { name: 'Plugins' }).click();
  await expect(leaf(page, 'model-3')).toBeVisible();
  const generic = listed(page, 'generic-uav');
  const first = SHIPPED.exec((await generic.getByRole('heading').textContent())?.trim() ?? '')?.[1] ?? 'no version is shown';
  const counted = (): Promise<number[]> => Promise.all(ALIKE_MODELS.map((name) => incarnation(page, name)));
  /** Version and incarnations of all its instances, in list and tree, and that the vehicles fly on. */
  const flies = async (version: string, incarnations: readonly number[]): Promise<void> => {
    await expect(generic.getByRole('heading')).toContainText(`generic-uav ${version},`);
    for (const name of ALIKE_MODELS) await expect(leaf(page, name)).toContainText(`generic-uav ${version}, node's process`, { timeout: RESTART_MS });
    await expect.poll(counted, { timeout: RESTART_MS }).toEqual(incarnations);
    for (const name of ALIKE_MODELS) {
      await expect(status(page, name)).toHaveText('running');
      // None of it was a failure.
      await expect(leaf(page, name).getByTestId('supervised-restarts')).toHaveText('0');
    }
    for (const id of [1, 2, 3]) await expect(card(page, id).getByTestId('flight-state')).toHaveText('Holding');
  };
  const start = await counted();
  await flies(first, start);
  await expect(generic).toContainText(`Used by 3: ${ALIKE_MODELS.join(', ')}`);
  for (const name of [/^Upgrade/, /^Roll back/, 'Remove']) await expect(generic.getByRole('button', { name })).toHaveCount(0);

  await test.step('a newer version is found, and waits until it is asked for', async () => {
    install('good_version', folder);
    await button(page, 'Look for new ones').click();
    await expect(outcome(page)).toContainText('1 with a newer version');
    await expect(generic).toContainText('Version 9.1.0 was found and waits.');
    await flies(first, start);
    expect(await findings(page)).toEqual([]);
    await hold(page, 'Upgrade 3 to 9.1.0');
    await expect(outcome(page)).toHaveText('generic-uav is 9.1.0 now, 3 instances exchanged', { timeout: RESTART_MS });
    await expect(button(page, 'Upgrade 3 to 9.1.0')).toHaveCount(0);
    await flies('9.1.0', start.map((n) => n + 1));
  });

  await test.step('one that does not come up changes nothing, and why is said', async () => {
    install('bad_version', folder);
    await button(page, 'Look for new ones').click();
    await hold(page, 'Upgrade 3 to 9.2.0');
    await expect(outcome(page)).toContainText('generic-uav stays 9.1.0: model-', { timeout: RESTART_MS });
    await expect(outcome(page)).toContainText('a snapshot of another version');
    expect(await findings(page)).toEqual([]);
    await flies('9.1.0', start.map((n) => n + 1));
  });

  await test.step('it goes back to the version before', async () => {
    await hold(page, `Roll back to ${first}`);
    await expect(outcome(page)).toHaveText(`generic-uav is ${first} now, 3 instances exchanged`, { timeout: RESTART_MS });
    await expect(button(page, 'Roll back to 9.1.0')).toBeVisible();
    await flies(first, start.map((n) => n + 2));
  });

  await test.step('one instance is started anew, and the other is not', async () => {
    await hold(page, leaf(page, ALIKE_MODELS[0]!).getByRole('button', { name: 'Restart' }));
    await expect(page.getByText(`${ALIKE_MODELS[0]} restart: taken up`)).toBeVisible();
    await flies(first, start.map((n, k) => (k === 0 ? n + 3 : n + 2)));
  });

  await test.step('the log has all of it', async () => {
    await page.getByRole('link', { name: 'Alerts' }).click();
    await page.getByRole('searchbox', { name: 'Search events' }).fill('plugin generic-uav');
    const log = page.getByRole('list', { name: 'Event log' });
    for (const text of [`9.1.0 instead of ${first}`, '9.2.0 did not come up; 9.1.0 stays', `${first} instead of 9.1.0`]) await expect(log).toContainText(text);
  });
});
