// What an operator does at the console now and then. Each gesture begins and ends on the map with nothing chosen and nothing open, so that
// what the page holds between them can be compared.

import type { Page } from '@playwright/test';
import { button, card, expect, hold } from '../e2e/console';
import type {} from '../src/features/map/hook';
import type {} from '../src/features/view3d/hook';
import { VEHICLES } from './soakLength';

export type Gesture = { name: string; does: (page: Page, turn: number) => Promise<void> };

/** As long as somebody looks at a page: it asks the program in this time as often as it does. */
const LOOK_MS = 4000;
const SLOW_MS = 60_000;

const link = (page: Page, name: string) => page.getByRole('navigation', { name: 'Pages' }).getByRole('link', { name });

/** Opens a page by its name in the rail, and goes back to the map when `look` is done with it. */
async function visit(page: Page, name: string, look: () => Promise<void>): Promise<void> {
  await link(page, name).click();
  await look();
  await page.waitForTimeout(LOOK_MS);
  await link(page, 'Map').click();
}

async function map(page: Page): Promise<void> {
  const box = (await page.getByRole('application').boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 120, y - 60, { steps: 20 });
  await page.mouse.up();
  await page.mouse.wheel(0, -400);
  await page.mouse.wheel(0, 300);
  for (const name of ['Zoom in', 'Zoom out', 'Keep all vehicles in view']) await button(page, name).click();
  await button(page, 'Layers').click();
  for (const name of ['Links', 'What cameras see']) await page.getByRole('checkbox', { name, exact: true }).click();
  await page.waitForTimeout(LOOK_MS);
  for (const name of ['Links', 'What cameras see']) await page.getByRole('checkbox', { name, exact: true }).click();
  await button(page, 'Layers').click();
}

async function space(page: Page): Promise<void> {
  await button(page, 'View in space').click();
  await page.waitForFunction(() => (window.__skeinSpace?.frames() ?? 0) > 5, undefined, { timeout: SLOW_MS });
  await page.getByRole('application').focus();
  for (const key of ['ArrowRight', '+', 'Shift+ArrowLeft', 'f']) await page.keyboard.press(key);
  await button(page, 'View in space').click();
  await expect.poll(() => page.evaluate(() => window.__skeinSpace === undefined)).toBe(true);
}

async function hands(page: Page, turn: number): Promise<void> {
  const [one, other] = [(turn % VEHICLES) + 1, ((turn + 7) % VEHICLES) + 1];
  for (const id of [one, other]) await button(page, new RegExp(`^Target ${id},`)).click();
  await button(page, 'Take 2').click();
  await expect(card(page, one).getByTestId('hands')).toHaveText('you');
  await button(page, 'Let go 2').click();
  await expect(page.getByTestId('hands')).toHaveCount(0);
  await button(page, 'Clear').click();
}

async function fleet(page: Page, turn: number): Promise<void> {
  await visit(page, 'Fleet', async () => {
    await page.getByRole('table', { name: 'Vehicles' }).getByRole('button', { name: 'Vehicle', exact: true }).click();
    await page.keyboard.press('/');
    await page.keyboard.type(`${(turn % 40) + 1}-${(turn % 40) + 9}`);
    await expect(page.locator('[data-row]')).toHaveCount(9);
    await button(page, 'Target these 9').click();
    await expect(page.getByTestId('targets')).toContainText('9 selected');
    await page.getByRole('searchbox', { name: /^Find vehicles/ }).press('Escape');
    await button(page, 'Clear').click();
  });
}

async function vehicle(page: Page, turn: number): Promise<void> {
  // One of those that carry a camera: its picture is fetched anew twice a second.
  const id = (turn % 16) * 3 + 2;
  await card(page, id).getByRole('link').first().click();
  await expect(page.getByRole('region', { name: `Vehicle ${id}` }).locator('canvas')).toHaveCount(6);
  await page.waitForTimeout(LOOK_MS);
  await link(page, 'Map').click();
  // Its page has selected it.
  await button(page, 'Clear').click();
}

async function alerts(page: Page): Promise<void> {
  await visit(page, 'Alerts', async () => {
    if (await button(page, 'Acknowledge all').isEnabled()) await button(page, 'Acknowledge all').click();
    await page.getByRole('searchbox', { name: 'Search events' }).fill('take off');
    await page.getByRole('searchbox', { name: 'Search events' }).fill('');
  });
}

async function plugins(page: Page): Promise<void> {
  await visit(page, 'Plugins', async () => {
    await expect(page.getByTestId('supervision-sum')).toHaveText(/\d+/, { timeout: SLOW_MS });
    await page.locator('[data-branch="3"] summary').click();
    await expect(page.locator('[data-supervised="model-3"]')).toBeVisible();
    await button(page, 'Look for new ones').click();
    await expect(page.getByTestId('plugin-outcome')).toContainText(/\d+ plugins/);
  });
}

async function links(page: Page): Promise<void> {
  await visit(page, 'Links', async () => expect(page.getByRole('region', { name: 'Nodes and links' }).getByRole('row')).not.toHaveCount(0));
}

async function small(page: Page): Promise<void> {
  for (const name of ['Preflight', 'Missions', 'Tracks', 'Video', 'Replay', 'Map']) await link(page, name).click();
  await button(page, 'Settings').click();
  for (const theme of [/^Light/, /^Dark/]) await page.getByRole('radio', { name: theme }).check();
  await button(page, 'Close the settings').click();
  await page.keyboard.press('?');
  await expect(page.getByRole('dialog', { name: 'Keys' })).toBeVisible();
  await page.keyboard.press('Escape');
  await button(page, /^EMERGENCY STOP/).click();
  await page.keyboard.press('Escape');
  await expect(page.getByRole('alertdialog')).toHaveCount(0);
}

async function panels(page: Page): Promise<void> {
  for (const name of [/^Route/, /^By hand/, /^Preflight/, /^Fences/, /^Payloads/, /^Formation/, /^Commands/, /^Events/]) {
    await page.getByRole('tab', { name }).click();
    await page.waitForTimeout(LOOK_MS / 4);
  }
}

const command = (name: string): Gesture => ({
  name,
  does: async (page) => {
    await button(page, /^Select all/).click();
    await hold(page, `${name} ${VEHICLES}`);
    await button(page, 'Each vehicle').click();
    await page.waitForTimeout(LOOK_MS);
    await button(page, 'Less').click();
    await button(page, 'Clear').click();
  },
});

/** In this order, again and again. All are in the air for a seventh of the time: so their batteries last. */
export const GESTURES: readonly Gesture[] = [
  { name: 'map', does: map },
  { name: 'fleet', does: fleet },
  command('Take off'),
  { name: 'space', does: space },
  command('Land'),
  { name: 'vehicle', does: vehicle },
  { name: 'alerts', does: alerts },
  { name: 'plugins', does: plugins },
  { name: 'panels', does: panels },
  { name: 'hands', does: hands },
  { name: 'small', does: small },
  { name: 'links', does: links },
  { name: 'vehicle', does: vehicle },
  { name: 'map', does: map },
  { name: 'space', does: space },
];
