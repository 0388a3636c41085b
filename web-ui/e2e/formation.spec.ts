// Formations beyond the wedge: a shape with parameters of its own, places by hand, and one that no vehicle leads. What is previewed
// is what the node lays out, and what is flown is what was previewed.

import type { Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, card, expect, hold, largestSlotError, open, plotted, summary, test } from './console';
import { Program } from './program';

const VEHICLES = 4;
const FLIGHT_MS = 60_000;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

type Place = { north: number; east: number; upM: number };

const slots = (page: Page): Promise<Place[]> => page.evaluate(() => window.__skein!.previewSlots());
const choose = (page: Page, shape: string) => page.getByRole('radio', { name: shape, exact: true }).check({ force: true });
const field = (page: Page, name: string) => page.getByRole('spinbutton', { name, exact: true });

/** Distances between all pairs, shortest first, to the centimetre: the same for the same shape wherever and however it is turned. */
function distances(places: readonly { north: number; east: number }[]): number[] {
  const found: number[] = [];
  places.forEach((a, i) => places.slice(i + 1).forEach((b) => found.push(Math.hypot(a.north - b.north, a.east - b.east))));
  return found.map((d) => Math.round(d * 100) / 100).sort((a, b) => a - b);
}

test('shapes with parameters, places by hand, and a formation about a place', async ({ page }) => {
  await open(page, program.url, VEHICLES);
  await test.step('before take-off a shape is previewed for the targets', async () => {
    await choose(page, 'Helix');
    await field(page, 'Rise per turn (0: automatic)').fill('12');
    await expect.poll(async () => (await slots(page)).length).toBe(VEHICLES);
    await expect.poll(async () => Math.max(...(await slots(page)).map((s) => s.upM))).toBeGreaterThan(1);
    expect(await findings(page)).toEqual([]);
  });
  await test.step('all take off', async () => {
    await hold(page, `Take off ${VEHICLES}`);
    await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
  });
  await test.step('an arc with its angle is previewed and flown', () => arc(page));
  await test.step('places by hand', () => free(page));
  await test.step('a circle about a place, with no leader', () => aboutPlace(page));
  await test.step('all land', async () => {
    await hold(page, `LAND ALL ${VEHICLES}`);
    await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
  });
});

async function arc(page: Page): Promise<void> {
  await choose(page, 'Arc');
  await field(page, 'Spacing').fill('6');
  await expect.poll(async () => distances(await slots(page))[0]).toBeCloseTo(6, 1);
  const half = distances(await slots(page));
  await field(page, 'Arc').fill('60');
  // A flatter arc is wider from end to end: the answer is to the new angle.
  await expect.poll(async () => distances(await slots(page)).at(-1)).toBeGreaterThan(half.at(-1)! + 1);
  await expect(page.getByTestId('preview-said')).toHaveText('Closest together: 6.0 m');
  const previewed = distances(await slots(page));
  await hold(page, `Form arc ${VEHICLES}`);
  await expect(page.getByTestId('formation-flown')).toContainText('Arc of 4, 6 m apart, behind 1');
  await expect.poll(() => largestSlotError(page, VEHICLES - 1), { timeout: FLIGHT_MS }).toBeLessThan(1);
  await expect
    .poll(async () => {
      const flown = distances((await plotted(page)).map((v) => ({ north: v.northM, east: v.eastM })));
      return Math.max(...flown.map((d, k) => Math.abs(d - previewed[k]!)));
    }, { timeout: FLIGHT_MS })
    .toBeLessThan(1.5);
}

async function free(page: Page): Promise<void> {
  await choose(page, 'Free');
  const text = page.getByRole('textbox', { name: /^Offsets/ });
  await text.fill('0,0,0\n-8,x,0');
  await expect(page.getByTestId('preview-said')).toHaveText('Offsets: line 2: "x" is no number');
  await expect(button(page, `Form free ${VEHICLES}`)).toBeDisabled();
  await text.fill('forward_m,right_m,up_m\n0,0,0\n-8,0,0\n-8,6,0\n-16,0,2');
  await expect.poll(async () => distances(await slots(page))).toEqual([6, 8, 8, 10, 10, 16]);
  expect((await slots(page)).map((s) => s.upM)).toEqual([0, 0, 0, 2]);
}

async function aboutPlace(page: Page): Promise<void> {
  await choose(page, 'Circle');
  await page.getByRole('combobox', { name: 'Anchor' }).selectOption('place');
  await expect(page.getByTestId('preview-said')).toHaveText('Pick the place on the map');
  await button(page, 'Pick on the map').click();
  const at = { north: 5, east: 12 };
  const position = await page.evaluate(([n, e]) => window.__skein!.toCanvas(n!, e!), [at.north, at.east]);
  await page.locator('canvas').click({ position });
  await expect.poll(async () => (await slots(page)).length).toBe(VEHICLES);
  await hold(page, `Form circle ${VEHICLES}`);
  await expect(page.getByText(/Circle of 4 about a fixed place: \d+ s to form/)).toBeVisible();
  await expect(page.getByTestId('formation-flown')).toContainText('Circle of 4, 6 m apart, about a fixed place');
  // Without a leader every vehicle has a slot.
  await expect.poll(() => largestSlotError(page, VEHICLES), { timeout: FLIGHT_MS }).toBeLessThan(1);
  await expect.poll(async () => {
    const all = await plotted(page);
    const mean = (of: (v: (typeof all)[number]) => number) => all.reduce((sum, v) => sum + of(v), 0) / all.length;
    return Math.hypot(mean((v) => v.northM) - at.north, mean((v) => v.eastM) - at.east);
  }, { timeout: FLIGHT_MS }).toBeLessThan(1.5);
  for (let id = 1; id <= VEHICLES; id++) await expect(card(page, id).getByText('Leader', { exact: true })).toHaveCount(0);
  const before = await page.evaluate(() => window.__skein!.framesDrawn());
  await button(page, 'Follow the targets or the leader').click();
  await expect.poll(() => page.evaluate(() => window.__skein!.framesDrawn())).toBeGreaterThan(before + 3);
  await page.getByRole('tab', { name: 'Route' }).click();
  await expect(page.getByText('This formation has no leader vehicle')).toBeVisible();
  await page.getByRole('tab', { name: 'Formation' }).click();
  await button(page, 'End').click();
  await expect(page.getByTestId('formation-flown')).toContainText('No formation is flown');
}
