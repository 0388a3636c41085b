// Formations beyond the wedge: a shape with parameters of its own, places by hand, and one that no vehicle leads. What is previewed
// is what the node lays out, and what is flown is what was previewed.

import { readFileSync } from 'node:fs';
import type { Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, card, expect, hold, largestSlotError, open, plotted, selectAll, summary, test } from './console';
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

// Nobody flies in this one: it comes first, while all stand where they began.
test('a shape is drawn, moved by keys, read from a file and saved', { tag: '@long' }, async ({ page }) => {
  await open(page, program.url, VEHICLES);
  await selectAll(page);
  await choose(page, 'Free');
  await test.step('three places with the mouse', () => drawn(page));
  await test.step('keys move, choose, remove and take back', () => byKeys(page));
  await test.step('files are read, refused in words, and written', () => files(page));
  await test.step('nothing for axe to find, in any theme', async () => {
    for (const colorScheme of ['dark', 'light'] as const) {
      await page.emulateMedia({ colorScheme });
      expect(await findings(page)).toEqual([]);
    }
  });
  await test.step('a narrow phone scrolls in one direction only', async () => {
    await page.setViewportSize({ width: 360, height: 740 });
    await page.getByRole('tab', { name: 'Formation', exact: true }).click();
    await board(page).scrollIntoViewIfNeeded();
    expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
    const { x, width } = (await board(page).boundingBox())!;
    expect([x >= 0, x + width <= 360]).toEqual([true, true]);
    const panel = page.getByRole('tabpanel').filter({ has: board(page) }).locator('.scroll');
    expect(await panel.evaluate((element) => element.scrollWidth - element.clientWidth)).toBeLessThanOrEqual(0);
    expect(await findings(page)).toEqual([]);
  });
});

test('shapes with parameters, places by hand, and a formation about a place', { tag: '@long' }, async ({ page }) => {
  await open(page, program.url, VEHICLES);
  await test.step('before take-off a shape is previewed for the targets', async () => {
    await expect(page.getByTestId('preview-said')).toHaveText('Select vehicles first');
    await expect(button(page, 'Form wedge')).toBeDisabled();
    await selectAll(page);
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

const board = (page: Page) => page.getByTestId('shape-board');
const place = (page: Page, name: string | RegExp) => board(page).getByRole('option', { name });
const said = (page: Page) => page.getByTestId('shape-said');

/** A point of the board, from its left and upper edge as parts of its size. */
async function spot(page: Page, right: number, down: number): Promise<[number, number]> {
  await board(page).scrollIntoViewIfNeeded();
  const { x, y, width, height } = (await board(page).boundingBox())!;
  return [x + width * right, y + height * down];
}

async function drawn(page: Page): Promise<void> {
  await expect(place(page, 'Place 1: at the origin, level')).toBeVisible();
  for (const [right, down] of [[0.3, 0.7], [0.7, 0.7], [0.5, 0.85]] as const) await page.mouse.click(...(await spot(page, right, down)));
  await expect(place(page, /^Place \d/)).toHaveCount(VEHICLES);
  await expect(page.getByTestId('shape-count')).toContainText(`Places: ${VEHICLES}. Vehicles that take part: ${VEHICLES}.`);
  await expect.poll(async () => (await slots(page)).length).toBe(VEHICLES);
  const before = (await slots(page))[3]!;
  await page.mouse.move(...(await spot(page, 0.5, 0.85)));
  await page.mouse.down();
  await page.mouse.move(...(await spot(page, 0.6, 0.4)), { steps: 40 });
  await page.mouse.up();
  await expect.poll(async () => Math.hypot((await slots(page))[3]!.north - before.north, (await slots(page))[3]!.east - before.east)).toBeGreaterThan(3);
}

async function byKeys(page: Page): Promise<void> {
  const text = page.getByRole('textbox', { name: /^Offsets/ });
  await page.getByText('As text', { exact: true }).click();
  await text.fill('0,0,0\n-5,5,0\n-5,-5,0\n-10,0,0');
  await place(page, /^Place 1/).focus();
  await page.keyboard.press('End');
  await expect(place(page, 'Place 4: 10.0 m back, level')).toBeFocused();
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('Shift+ArrowDown');
  await expect(place(page, 'Place 4: 10.1 m back, 0.5 m right, level')).toBeFocused();
  await expect(said(page)).toHaveText('Place 4: 10.1 m back, 0.5 m right, level');
  await field(page, 'Up').fill('2.5');
  await expect(text).toHaveValue('forward_m,right_m,down_m\n0,0,0\n-5,5,0\n-5,-5,0\n-10.1,0.5,-2.5\n');
  await expect.poll(async () => (await slots(page)).map((s) => s.upM)).toEqual([0, 0, 0, 2.5]);
  await place(page, /^Place 4/).focus();
  await page.keyboard.press('Delete');
  await expect(place(page, /^Place \d/)).toHaveCount(3);
  await expect(page.getByTestId('shape-count')).toContainText('Places missing: 1');
  await expect(place(page, /^Place 3/)).toBeFocused();
  await page.keyboard.press('Control+z');
  await page.keyboard.press('Control+z');
  await expect(place(page, 'Place 4: 10.1 m back, 0.5 m right, level')).toBeVisible();
  await text.fill('0,0,0\n-5,5,0\n-5,4.5,0');
  await expect(page.getByTestId('shape-near')).toHaveText('Nearer than 1.0 m to another: 2, 3');
  await expect(place(page, /^Place 3: .*, nearer than 1\.0 m to another$/)).toBeVisible();
  await text.fill('0,0,0\n-5,x,0');
  await expect(page.getByText('this is how the shape was before: line 2: "x" is no number')).toBeVisible();
  await expect(place(page, /^Place \d/)).toHaveCount(3);
}

async function files(page: Page): Promise<void> {
  const give = (name: string, text: string) => page.getByTestId('shape-file').setInputFiles({ name, mimeType: 'text/plain', buffer: Buffer.from(text) });
  await give('four.json', '[[0,0,0],[-8,0,0],[-8,6,0],{"forward_m":-16,"right_m":0,"up_m":2}]');
  await expect(said(page)).toHaveText('Read from four.json. Places: 4');
  await expect.poll(async () => distances(await slots(page))).toEqual([6, 8, 8, 10, 10, 16]);
  await give('broken.csv', 'forward_m,right_m,down_m\n0,0,0\n-8,six,0\n');
  await expect(said(page)).toHaveText('broken.csv not read: line 3: "six" is no number');
  await give('large.csv', '0,0,0\n'.repeat(200_000));
  await expect(said(page)).toHaveText('large.csv not read: it is larger than 1 MB');
  await expect(place(page, 'Place 4: 16.0 m back, 2.0 m up')).toBeVisible();
  const saved = page.waitForEvent('download');
  await button(page, 'Save as a file').click();
  const file = await saved;
  expect(file.suggestedFilename()).toBe('shape.csv');
  expect(readFileSync(await file.path(), 'utf8')).toBe('forward_m,right_m,down_m\n0,0,0\n-8,0,0\n-8,6,0\n-16,0,-2\n');
  const dropped = await page.evaluateHandle(() => {
    const carried = new DataTransfer();
    carried.items.add(new File(['0,0,0\n-7,0,0\n-14,0,0\n-21,0,0\n'], 'column.csv'));
    return carried;
  });
  await board(page).dispatchEvent('drop', { dataTransfer: dropped });
  await expect(said(page)).toHaveText('Read from column.csv. Places: 4');
  await expect.poll(async () => distances(await slots(page))).toEqual([7, 7, 7, 14, 14, 21]);
}

async function arc(page: Page): Promise<void> {
  await choose(page, 'Arc');
  await field(page, 'Spacing').fill('6');
  await expect.poll(async () => distances(await slots(page))[0]).toBeCloseTo(6, 1);
  const half = distances(await slots(page));
  await field(page, 'Arc').fill('60');
  // A flatter arc is wider from end to end: the answer is to the new angle.
  await expect.poll(async () => distances(await slots(page)).at(-1)).toBeGreaterThan(half.at(-1)! + 1);
  await expect(page.getByTestId('preview-said')).toHaveText(/^\d+ s to form; closest on the way: \d\.\d m; closest in place: 6\.0 m$/);
  const previewed = distances(await slots(page));
  // Each vehicle has a line to a place of its own.
  const ways = await page.evaluate(() => window.__skein!.previewWays());
  const taken = (await slots(page)).map((slot) => ways.filter(({ to }) => Math.hypot(to.north - slot.north, to.east - slot.east) < 0.5).length);
  expect(taken).toEqual(Array<number>(VEHICLES).fill(1));
  await hold(page, `Form arc ${VEHICLES}`);
  await expect(page.getByTestId('formation-flown')).toContainText(/Arc of 4, 6 m apart, behind [1-4]/);
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
  await page.getByText('As text', { exact: true }).click();
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
  await button(page, `End ${VEHICLES}`).click();
  await expect(page.getByTestId('formation-flown')).toContainText('No formation is flown');
}
