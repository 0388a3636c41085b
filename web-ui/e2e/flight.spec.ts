// An operator flies the swarm through the page: take-off, formation, refusals, route, hold, landing. One flight, step by step.

import type { Page } from '@playwright/test';
import { button, card, expect, hold, largestSlotError, open, plotted, selectAll, smallestDistance, summary, test } from './console';
import { Program } from './program';

const VEHICLES = 4;
const FLIGHT_MS = 60_000;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

test('the swarm takes off, flies in formation behind its leader and lands', async ({ page, watch }) => {
  // The browser itself reports an answer that is no success: the formation that is refused on purpose.
  watch.expected.push(/Failed to load resource: .* status of (409|422)/);
  await test.step('a short press on a guarded button does nothing', async () => {
    await open(page, program.url, VEHICLES);
    const posts: string[] = [];
    page.on('request', (request) => request.method() === 'POST' && !request.url().endsWith('/preview') && posts.push(request.url()));
    await selectAll(page);
    await button(page, `Take off ${VEHICLES}`).click({ delay: 150 });
    await expect(page.getByText('Keep holding')).toBeVisible();
    await expect(page.getByText('Keep holding')).toBeHidden();
    expect(posts).toEqual([]);
    await expect(summary(page)).toBeHidden();
  });
  await test.step('all take off', () => takeOff(page));
  await test.step('they form a wedge', () => formWedge(page));
  await test.step('refusals are shown where they belong', () => refusals(page));
  await test.step('the leader flies a route drawn on the map', () => route(page));
  await test.step('HOLD ALL stops everybody', async () => {
    await button(page, `HOLD ALL ${VEHICLES}`).click();
    await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
    await expect(page.getByTestId('flight-state').filter({ hasText: 'Holding' })).toHaveCount(VEHICLES, { timeout: FLIGHT_MS });
  });
  await test.step('all land', () => land(page));
});

async function takeOff(page: Page): Promise<void> {
  await hold(page, `Take off ${VEHICLES}`);
  await expect(summary(page)).toContainText('Take off 10 m');
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
  await expect(page.getByTestId('count-air')).toHaveText(`${VEHICLES}`);
  await expect(page.getByTestId('count-ground')).toHaveText('0');
  await expect(card(page, 1).getByTestId('armed')).toHaveText('armed');
  // The list says the same as the server does to anybody else.
  const response = await page.request.get(`${program.url}/api/v1/vehicles`);
  const { vehicles } = (await response.json()) as { vehicles: { armed: boolean; landed: string }[] };
  expect(vehicles.map((v) => [v.armed, v.landed])).toEqual(Array.from({ length: VEHICLES }, () => [true, 'in_air']));
}

async function formWedge(page: Page): Promise<void> {
  await page.getByRole('radio', { name: 'Wedge' }).check({ force: true });
  // Named, since who leads by itself is who is fittest: a few lost packets at the moment of asking make that another one.
  await page.getByRole('combobox', { name: 'Leader' }).selectOption({ label: '1 uav-1' });
  await hold(page, `Form wedge ${VEHICLES}`);
  await expect(page.getByText(/Wedge of 4 behind 1: \d+ s to form, never closer than \d+\.\d m/)).toBeVisible();
  await expect(page.getByTestId('formation-flown')).toContainText('Wedge of 4, 5 m apart, behind 1');
  await expect(page.getByTestId('doing')).toContainText(/^Wedge of 4, 5 m apart, behind 1: (forming, \d+ s more|in its places)/);
  // The slots themselves move into place: only when the spacing is there too is the wedge flown.
  await expect.poll(() => smallestDistance(page), { timeout: FLIGHT_MS }).toBeGreaterThan(4.5);
  await expect.poll(() => largestSlotError(page, VEHICLES - 1), { timeout: FLIGHT_MS }).toBeLessThan(1);
  await expect(card(page, 1)).toContainText('Leader');
  await expect(page.getByTestId('flight-state').filter({ hasText: 'Following' })).toHaveCount(VEHICLES - 1);
  for (const id of [1, 2, 3, 4]) {
    const { x, y } = (await plotted(page)).find((v) => v.id === id)!;
    expect(await page.evaluate(([px, py]) => window.__skein!.hitTest(px!, py!), [x, y])).toBe(id);
  }
}

async function refusals(page: Page): Promise<void> {
  // A vehicle in the air is not armed again: the vehicle's own reason comes back to its card.
  await button(page, 'Clear').click();
  await button(page, /^Target 2,/).click();
  await expect(page.getByTestId('targets')).toContainText('1 selected');
  await hold(page, 'Arm 1');
  await expect(summary(page)).toContainText('1 of 1 refused');
  await expect(card(page, 2)).toContainText(/Arm refused: cannot arm while following/);
  await page.keyboard.press('Escape');
  await expect(page.getByTestId('targets')).toContainText('nothing selected');
  await selectAll(page);
  // Closer together than the coordinator flies: the order is refused, the formation stays.
  await page.getByRole('spinbutton', { name: 'Spacing' }).fill('1');
  await expect(page.getByTestId('preview-said')).toContainText(/Would be refused: .+/);
  await hold(page, `Form wedge ${VEHICLES}`);
  await expect(page.getByRole('status').getByText(/Wedge refused: .+/)).toBeVisible();
  await expect(page.getByTestId('formation-flown')).toContainText('5 m apart');
  await expect(page.getByRole('log')).toContainText('Wedge refused');
  await page.getByRole('spinbutton', { name: 'Spacing' }).fill('5');
}

async function route(page: Page): Promise<void> {
  await page.getByRole('tab', { name: 'Route' }).click();
  await button(page, 'Draw on the map').click();
  const canvas = page.locator('canvas');
  const leader = (await plotted(page)).find((v) => v.id === 1)!;
  for (const [north, east] of [[12, 0], [12, 12]] as const) {
    const position = await page.evaluate(
      ([n, e]) => window.__skein!.toCanvas(n!, e!),
      [leader.northM + north, leader.eastM + east],
    );
    await canvas.click({ position });
  }
  await expect(page.getByRole('spinbutton', { name: 'Point 2 east' })).toBeVisible();
  await hold(page, /^Fly route of 2 points.*: 1 and 3 behind$/);
  await expect(page.getByTestId('doing')).toContainText('flies a route of 2 points');
  await expect(page.getByText('Route of 2 points taken up')).toBeVisible();
  await expect(page.getByText(/1 has flown a route of 2 points/)).toBeVisible({ timeout: FLIGHT_MS });
  const end = (await plotted(page)).find((v) => v.id === 1)!;
  expect(Math.hypot(end.northM - leader.northM - 12, end.eastM - leader.eastM - 12)).toBeLessThan(2);
  expect(await page.evaluate(() => window.__skein!.trailLength(1))).toBeGreaterThan(10);
  await button(page, 'Stop drawing').click();
}

async function land(page: Page): Promise<void> {
  await hold(page, `Land ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
  await expect(page.getByTestId('count-ground')).toHaveText(`${VEHICLES}`);
  await expect(page.getByTestId('armed').filter({ hasText: 'disarmed' })).toHaveCount(VEHICLES, { timeout: FLIGHT_MS });
  await page.getByRole('tab', { name: 'Commands' }).click();
  await expect(page.getByRole('region', { name: 'Commands given' })).toContainText('Land');
}
