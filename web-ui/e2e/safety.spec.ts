// What keeps people from harm, seen through the page: the preflight report, fences read from a file, and an emergency stop that takes
// two steps and never one.

import type { Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, card, expect, hold, open, selectAll, summary, test } from './console';
import { Program } from './program';

const VEHICLES = 3;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

test.beforeEach(async ({ page }) => {
  await open(page, program.url, VEHICLES);
});

type Corner = readonly [latitude: number, longitude: number];

/** A rectangle about the vehicles, `shift` degrees of latitude away. */
async function rectangle(page: Page, size: number, shift: number): Promise<Corner[]> {
  const at = await page.evaluate(() => window.__skein!.positions()[0]!);
  const [north, east] = [at.latitudeDeg + shift, at.longitudeDeg];
  return [[-1, -1], [-1, 1], [1, 1], [1, -1], [-1, -1]].map(([n, e]) => [north + n! * size, east + e! * size]);
}

const feature = (name: string, kind: string, corners: Corner[]) => ({
  type: 'Feature',
  properties: { name, kind, floor_m: kind === 'exclusion' ? 0 : null, ceiling_m: 50 },
  geometry: { type: 'Polygon', coordinates: [corners.map(([latitude, longitude]) => [longitude, latitude])] },
});

async function load(page: Page, features: object[]): Promise<void> {
  await page.getByRole('tab', { name: 'Fences' }).click();
  const buffer = Buffer.from(JSON.stringify({ type: 'FeatureCollection', features }));
  await page.locator('input[type=file]').setInputFiles({ name: 'field.geojson', mimeType: 'application/geo+json', buffer });
  await expect(page.getByTestId('fence-import')).toContainText(`field.geojson: ${features.length} zone`, { ignoreCase: true });
}

const zones = (page: Page) => page.evaluate(() => window.__skein!.zones());

test('fences are read from a file, shown on the map when they are in force, and lifted', { tag: '@long' }, async ({ page }) => {
  await load(page, [
    feature('field', 'inclusion', await rectangle(page, 0.001, 0)),
    feature('mast', 'exclusion', await rectangle(page, 0.0001, 0.0005)),
  ]);
  // Reading a file puts nothing in force.
  expect(await zones(page)).toEqual([]);
  expect(await findings(page)).toEqual([]);
  await hold(page, 'Put 2 zones in force');
  await expect.poll(() => zones(page)).toEqual([{ name: 'field', kind: 'inclusion', corners: 4 }, { name: 'mast', kind: 'exclusion', corners: 4 }]);
  const panel = page.getByTestId('fence-panel');
  await expect(panel).toContainText('stay inside, up to 50 m');
  await expect(panel).toContainText('keep out, 0 to 50 m');
  const exported = await page.request.get(await page.getByRole('link', { name: 'Export GeoJSON' }).evaluate((a: HTMLAnchorElement) => a.href));
  expect(((await exported.json()) as { features: unknown[] }).features).toHaveLength(2);
  await hold(page, 'Lift all');
  await expect.poll(() => zones(page)).toEqual([]);
});

test('a red preflight item refuses the take-off, and the refusal leads to it', async ({ page, watch }) => {
  watch.expected.push(/Failed to load resource: .* status of (401|403)/);
  await page.getByRole('tab', { name: 'Preflight' }).click();
  const panel = page.getByTestId('preflight-panel');
  await expect(panel.locator('[data-report]')).toHaveCount(VEHICLES + 1);
  await expect(page.getByTestId('preflight-counts')).toContainText('0 red');
  await panel.locator('[data-report="1"] summary').click();
  const satellites = panel.locator('[data-report="1"] [data-item="gnss_satellites"]');
  await expect(satellites).toContainText(/Satellites\s*\d+\s*limit 6/);
  expect(await findings(page)).toEqual([]);

  // A field the vehicles do not stand in.
  await load(page, [feature('elsewhere', 'inclusion', await rectangle(page, 0.0005, 0.01))]);
  await hold(page, 'Put 1 zone in force');
  await expect.poll(async () => (await zones(page)).length).toBe(1);
  await selectAll(page);
  await hold(page, `Take off ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} refused`);
  await button(page, 'Show preflight').click();
  await expect(page.getByTestId('preflight-sign')).toContainText(/\d+ red/);
  await expect(panel.locator('[data-report="1"] li').first()).toHaveAttribute('data-item', 'inside_fence');
  await expect(panel.locator('[data-report="1"] li').first()).toContainText('red');

  const form = page.getByRole('form', { name: 'Override red items' });
  await form.getByRole('combobox', { name: 'Of' }).selectOption('1');
  await form.getByRole('checkbox', { name: /^Inside of the fence/ }).check();
  await form.getByLabel('Reason, for the record').fill('a test');
  const secret = form.getByLabel("Operator's secret");
  await expect(secret).toHaveAttribute('type', 'password');
  await secret.fill('not a secret');
  expect(await findings(page)).toEqual([]);
  await hold(page, 'Override 1 item');
  await expect(form.getByRole('status')).toContainText('Not overridden');
  await expect(secret).toHaveValue('');

  await page.getByRole('tab', { name: 'Fences' }).click();
  await hold(page, 'Lift all');
  await expect.poll(() => zones(page)).toEqual([]);
});

test('the emergency stop takes two steps', async ({ page }) => {
  const posts: string[] = [];
  page.on('request', (request) => request.method() === 'POST' && posts.push(new URL(request.url()).pathname));
  const unlock = button(page, /^EMERGENCY STOP/);
  const dialog = page.getByRole('alertdialog', { name: 'Emergency stop unlocked' });
  const stopped = async () => {
    const { vehicles } = (await (await page.request.get(`${program.url}/api/v1/vehicles`)).json()) as { vehicles: { id: number; stopped: boolean }[] };
    return vehicles.filter((v) => v.stopped).map((v) => v.id);
  };

  const said = button(page, /^Seen: emergency stop unlocked/);

  await test.step('one step does nothing, nor does a double click, nor a key pressed twice', async () => {
    await unlock.dblclick();
    await expect(dialog).toBeVisible();
    expect(posts).toEqual(['/api/v1/emergency-stop/unlock']);
    await expect(button(page, 'Cancel')).toBeFocused();
    await expect(said).toBeVisible();
    await page.keyboard.press('Enter');
    await expect(dialog).toBeHidden();
    await expect(said).toBeHidden();
    await expect(unlock).toBeFocused();
    expect(posts).toEqual(['/api/v1/emergency-stop/unlock']);
    expect(await stopped()).toEqual([]);
  });
  await test.step('the key runs out by itself, counted down', async () => {
    await unlock.click();
    await expect(dialog.getByRole('timer')).toHaveText(/^(10|9|8) s$/);
    expect(await findings(page)).toEqual([]);
    await expect(dialog).toBeHidden();
    await expect(page.getByText('emergency stop locked again')).toBeVisible();
    await expect(said).toBeHidden();
    expect(await stopped()).toEqual([]);
  });
  await test.step('the second step stops those it names and nobody else', async () => {
    await button(page, /^Target 2,/).click();
    await hold(page, 'Arm 1');
    await expect(card(page, 2).getByTestId('armed')).toHaveText('armed');
    await unlock.click();
    // That of all stands apart and wants to be held: a click on it stops nobody.
    await button(page, `Not only these: hold to stop all ${VEHICLES}`).click();
    await expect(dialog).toBeVisible();
    expect(posts).not.toContain('/api/v1/emergency-stop');
    await button(page, /^STOP MOTORS OF 1 SELECTED/).click();
    await expect(dialog).toBeHidden();
    await expect(page.getByText('Emergency stop sent to 2')).toBeVisible();
    await expect(card(page, 2).getByTestId('stopped')).toContainText('MOTORS STOPPED');
    await expect(card(page, 2).getByTestId('armed')).toContainText('disarmed');
    await expect(page.getByTestId('stopped')).toHaveCount(1);
    expect(await stopped()).toEqual([2]);
    expect(posts.filter((path) => path === '/api/v1/emergency-stop')).toHaveLength(1);
    expect(await findings(page)).toEqual([]);
  });
});
