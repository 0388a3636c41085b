// Alerts and supervision: a plugin crashes while its page is open; that is seen, heard if wished, acknowledged, found in the log.

import { findings } from './accessibility';
import { button, expect, open, test } from './console';
import { Program } from './program';

const VEHICLES = 2;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

test.beforeEach(async ({ page }) => {
  await open(page, program.url, VEHICLES);
});

test('a plugin that crashes while one looks is seen, heard and acknowledged', async ({ page }) => {
  await page.getByRole('link', { name: 'Alerts' }).click();
  const sound = page.getByRole('button', { name: /^Sound/ });
  // Off until somebody turns it on; on, it says once how loud it is.
  await expect(sound).toHaveAttribute('aria-pressed', 'false');
  await expect(sound).toHaveAttribute('data-played', '0');
  if (await button(page, 'Acknowledge all').isEnabled()) await button(page, 'Acknowledge all').click();
  await sound.click();
  await expect(sound).toHaveText('Sound on');
  await expect(sound).toHaveAttribute('data-played', '1');

  const crash = await page.request.post(`${program.url}/api/v1/faults`, { data: { fault: 'plugin_panic', vehicle: 1, payload: 'radio' } });
  expect(crash.ok()).toBe(true);
  const alert = page.getByTestId('alert').filter({ hasText: 'radio' }).first();
  await expect(alert).toBeVisible();
  await expect(sound).not.toHaveAttribute('data-played', '1');
  expect(await findings(page)).toEqual([]);
  // Who comes later is told of it as well, until somebody has acknowledged it.
  const later = await page.context().newPage();
  await open(later, program.url, VEHICLES);
  await later.getByRole('link', { name: 'Alerts' }).click();
  await expect(later.getByTestId('alert').filter({ hasText: 'radio' }).first()).toBeVisible();
  await alert.getByRole('button', { name: /^Acknowledge/ }).click();
  for (const one of [page, later]) await expect(one.getByTestId('alert').filter({ hasText: 'radio' })).toHaveCount(0);
  await later.close();

  const log = page.getByRole('list', { name: 'Event log' });
  await page.getByRole('searchbox', { name: 'Search events' }).fill('1 radio');
  await expect(log.getByRole('listitem').first()).toContainText('radio');
  for (const line of await log.getByRole('listitem').allTextContents()) expect(line).toMatch(/radio/);
  await page.getByRole('combobox', { name: 'How urgent' }).selectOption('critical');
  await expect(log).toContainText('No event fits.');
  await button(page, 'Show all').click();
  await page.keyboard.press('Escape');
  await page.getByRole('heading', { name: 'Events' }).click();
  await page.keyboard.press('s');
  await expect(sound).toHaveText('Sound off');
});

test('the supervision tree shows the crash, and starts a plugin anew', { tag: '@long' }, async ({ page }) => {
  await page.getByRole('link', { name: 'Plugins' }).click();
  const radio = page.locator('[data-supervised="payload-2-radio"]');
  await expect(radio.getByTestId('supervised-status')).toHaveText('running');
  await expect(radio).toContainText('calls p50, p99');
  await expect(page.locator('[data-supervised="coordinator"]')).toBeVisible();
  const before = Number(await radio.getByTestId('supervised-restarts').textContent());
  await page.request.post(`${program.url}/api/v1/faults`, { data: { fault: 'plugin_panic', vehicle: 2, payload: 'radio' } });
  await expect(radio.getByTestId('supervised-restarts')).toHaveText(`${before + 1}`, { timeout: 20_000 });
  await expect(radio).toContainText('Last error');
  await expect(radio.getByTestId('supervised-status')).toHaveText('running', { timeout: 20_000 });
  await page.getByText('Restarts after failures').click();
  await expect(page.getByText(/payload-2-radio was back after \d+ ms/).first()).toBeVisible();

  const incarnation = Number(await radio.getByTestId('supervised-incarnation').textContent());
  const restart = radio.getByRole('button', { name: 'Restart' });
  await restart.click({ delay: 100 });
  await expect(radio.getByText('Keep holding')).toBeVisible();
  await restart.hover();
  const sent = page.waitForRequest((request) => request.url().endsWith('/restart'));
  await page.mouse.down();
  await sent;
  await page.mouse.up();
  await expect(radio.getByTestId('supervised-incarnation')).toHaveText(`${incarnation + 1}`, { timeout: 20_000 });
  expect(await findings(page)).toEqual([]);
});

test('plugins are listed with what they may do, and looked for again', { tag: '@long' }, async ({ page }) => {
  await page.getByRole('link', { name: 'Plugins' }).click();
  const gimbal = page.locator('[data-plugin="gimbal"]');
  await expect(gimbal).toContainText('payload-2-gimbal');
  await gimbal.getByText('What it may do').click();
  await expect(gimbal).toContainText('SHA-256');
  await button(page, 'Look for new ones').click();
  await expect(page.getByTestId('plugin-outcome')).toContainText(/\d+ plugins/);
});
