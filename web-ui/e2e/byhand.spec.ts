// One vehicle flown by hand through the page: a gamepad that the test holds, a vehicle that really moves, and standing when it is let go.

import type { Locator, Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, card, expect, hold, open, plotted, selectAll, summary, test } from './console';
import { Program } from './program';

const VEHICLES = 2;
const FLIGHT_MS = 60_000;

let program: Program;
test.beforeEach(async () => {
  program = await Program.start(VEHICLES);
});
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
  await program.stop();
});

declare global {
  interface Window {
    testPad: { there: boolean; held: boolean; axes: number[] };
  }
}

/** A gamepad that is plugged in, held and moved by `pad`. */
async function withPad(page: Page): Promise<void> {
  await page.addInitScript(() => {
    window.testPad = { there: false, held: false, axes: [0, 0, 0, 0] };
    const buttons = (): { pressed: boolean; touched: boolean; value: number }[] =>
      Array.from({ length: 17 }, (_, at) => {
        const pressed = at === 5 && window.testPad.held;
        return { pressed, touched: pressed, value: pressed ? 1 : 0 };
      });
    navigator.getGamepads = () => [
      window.testPad.there
        ? ({ id: 'Test Pad (STANDARD GAMEPAD)', index: 0, connected: true, mapping: 'standard', timestamp: performance.now(), axes: window.testPad.axes, buttons: buttons() } as unknown as Gamepad)
        : null,
    ];
  });
}

const pad = (page: Page, change: Partial<Window['testPad']>): Promise<void> => page.evaluate((with_) => void Object.assign(window.testPad, with_), change);
const says = (page: Page): Locator => page.getByTestId('hand-state');

/** Where a vehicle is, in metres about the swarm's origin. */
async function place(page: Page, id: number): Promise<{ northM: number; eastM: number; altitudeM: number }> {
  const found = (await plotted(page)).find((vehicle) => vehicle.id === id);
  if (!found) throw new Error(`vehicle ${id} is not on the map`);
  return found;
}

/** How far it is from a place, level. */
async function away(page: Page, id: number, from: { northM: number; eastM: number }): Promise<number> {
  const at = await place(page, id);
  return Math.hypot(at.northM - from.northM, at.eastM - from.eastM);
}

/** Waits until a vehicle has come to a stand: half a second changes nothing. */
async function stands(page: Page, id: number): Promise<void> {
  let before = await place(page, id);
  await expect
    .poll(
      async () => {
        const moved = await away(page, id, before);
        before = await place(page, id);
        return moved;
      },
      { timeout: FLIGHT_MS, intervals: [500] },
    )
    .toBeLessThan(0.1);
}

async function up(page: Page): Promise<void> {
  await open(page, program.url, VEHICLES);
  await selectAll(page);
  await hold(page, `Take off ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: FLIGHT_MS });
  await button(page, 'Clear').click();
}

test('a vehicle flies while the dead-man is held, and stands when it is not', async ({ page }) => {
  await withPad(page);
  await up(page);
  await page.getByRole('tab', { name: 'By hand' }).click();

  await test.step('whom and with what is said before', async () => {
    await expect(page.getByTestId('hand-why')).toContainText('Select one vehicle first');
    await expect(button(page, 'Fly by hand')).toBeDisabled();
    await button(page, /^Target 1,/).click();
    await expect(page.getByTestId('hand-pad')).toContainText('No gamepad');
    await pad(page, { there: true });
    await expect(page.getByTestId('hand-pad')).toContainText('Gamepad: Test Pad.');
    await expect(page.getByRole('img', { name: /^Right stick: forward 0 %/ })).toBeVisible();
    await pad(page, { axes: [0, 0, 0, -1] });
    await expect(page.getByRole('img', { name: /^Right stick: forward 100 %/ })).toBeVisible();
    expect(await findings(page)).toEqual([]);
  });

  const start = await place(page, 1);
  const other = await place(page, 2);
  await test.step('nothing moves before the dead-man is held', async () => {
    await button(page, /^Fly .* by hand$/).click();
    await expect(says(page)).toContainText(/^Let go: .* stands$/);
    await expect(card(page, 1).getByTestId('flight-state')).toContainText('Going to');
    await stands(page, 1);
    expect(await away(page, 1, start)).toBeLessThan(0.5);
  });

  await test.step('it flies where the stick points, and nobody else does', async () => {
    await pad(page, { held: true });
    await expect(says(page)).toContainText(/^Steering /);
    await expect.poll(() => away(page, 1, start), { timeout: FLIGHT_MS }).toBeGreaterThan(6);
    expect(await away(page, 2, other)).toBeLessThan(0.5);
    expect(await findings(page)).toEqual([]);
  });

  await test.step('let go, it stands', async () => {
    await pad(page, { held: false });
    await expect(says(page)).toContainText(/^Let go: /);
    await stands(page, 1);
  });

  await test.step('it climbs', async () => {
    const before = await place(page, 1);
    await pad(page, { axes: [0, -1, 0, 0], held: true });
    await expect.poll(async () => (await place(page, 1)).altitudeM - before.altitudeM, { timeout: FLIGHT_MS }).toBeGreaterThan(2);
    await pad(page, { held: false });
    await stands(page, 1);
  });

  await test.step('a window that is left stops it, and coming back does not set it off again', async () => {
    await pad(page, { axes: [0, 0, 0, -1], held: true });
    await expect(says(page)).toContainText(/^Steering /);
    await page.evaluate(() => void window.dispatchEvent(new Event('blur')));
    await expect(says(page)).toContainText('This page is not looked at');
    await stands(page, 1);
    await page.evaluate(() => void window.dispatchEvent(new Event('focus')));
    await expect(says(page)).toContainText('Let the dead-man go, then hold it again');
    await pad(page, { held: false });
    await expect(says(page)).toContainText(/^Let go: /);
  });

  await test.step('a pad that is pulled out stops it', async () => {
    await pad(page, { held: true });
    await expect(says(page)).toContainText(/^Steering /);
    await pad(page, { there: false });
    await expect(page.getByTestId('hand-pad')).toContainText('No gamepad');
    await expect(says(page)).toContainText(/^Let go: /);
    await stands(page, 1);
    await pad(page, { held: false });
  });

  await test.step('a key on the button flies it too', async () => {
    const before = await place(page, 1);
    await page.getByTestId('dead-man').focus();
    await page.keyboard.down('Space');
    await page.keyboard.down('ArrowUp');
    await expect(says(page)).toContainText(/^Steering /);
    await expect.poll(() => away(page, 1, before), { timeout: FLIGHT_MS }).toBeGreaterThan(3);
    await page.keyboard.up('ArrowUp');
    await page.keyboard.up('Space');
    await expect(says(page)).toContainText(/^Let go: /);
    await stands(page, 1);
  });

  await test.step('ended, it holds', async () => {
    await button(page, /^End: /).click();
    await expect(says(page)).toContainText('Not flown by hand.');
    await expect(card(page, 1).getByTestId('flight-state')).toContainText('Holding', { timeout: FLIGHT_MS });
  });
});

test("another operator's vehicle is refused, and taking it ends a flight by hand", { tag: '@long' }, async ({ page: anna, browser }) => {
  await withPad(anna);
  await up(anna);
  const context = await browser.newContext();
  const ben = await context.newPage();
  await ben.goto(program.url);
  await expect(ben.getByTestId('count-all')).toHaveText(`${VEHICLES}`, { timeout: FLIGHT_MS });
  for (const page of [anna, ben]) await page.getByRole('tab', { name: 'By hand' }).click();
  await button(anna, /^Target 1,/).click();
  await button(anna, /^Fly .* by hand$/).click();
  await expect(says(anna)).toContainText(/^Let go: /);

  await button(ben, /^Target 1,/).click();
  await button(ben, 'Take 1').click();
  await expect(says(anna)).toContainText('Not flown by hand any more: under the control of Console');
  await expect(anna.getByTestId('hand-why')).toContainText('Somebody else has it: Console');
  await expect(button(anna, /^Fly .* by hand$/)).toBeDisabled();
  // Ben has control authority over it, and flies it.
  await button(ben, /^Fly .* by hand$/).click();
  await expect(says(ben)).toContainText(/^Let go: /);
  await context.close();
});

test('from the narrowest phone to the widest screen it can be held', { tag: '@long' }, async ({ page }) => {
  await withPad(page);
  await open(page, program.url, VEHICLES);
  for (const [width, height] of [[360, 740], [768, 1024], [1024, 768], [1440, 900], [3840, 2160]] as const) {
    await page.setViewportSize({ width, height });
    await page.getByRole('tab', { name: 'By hand' }).click();
    expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), `${width} px`).toBeLessThanOrEqual(0);
    const panel = (await page.getByTestId('by-hand').boundingBox())!;
    for (const part of [page.getByTestId('dead-man'), page.getByRole('img', { name: /^Left stick/ }), page.getByRole('img', { name: /^Right stick/ })]) {
      await part.scrollIntoViewIfNeeded();
      const box = (await part.boundingBox())!;
      expect(box.x, `${width} px`).toBeGreaterThanOrEqual(panel.x - 0.5);
      expect(box.x + box.width, `${width} px`).toBeLessThanOrEqual(panel.x + panel.width + 0.5);
      expect(Math.min(box.width, box.height), `${width} px`).toBeGreaterThanOrEqual(44);
    }
  }
  expect(await findings(page)).toEqual([]);
});
