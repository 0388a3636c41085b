// Several operators at one program: who has control authority over a vehicle is seen by all; it is asked for, handed over, and taken from who is gone.
// What stops or ends a flight is everybody's all the while.

import type { Locator, Page } from '@playwright/test';
import { findings } from './accessibility';
import { button, card, expect, hold, open, summary, test } from './console';
import { Program } from './program';

const VEHICLES = 3;
const FLIGHT_MS = 60_000;
/** Whoever is not heard for ten seconds can be relieved; the rest is for a slow machine. */
const RELIEF_MS = 40_000;

let program: Program;
test.beforeEach(async () => {
  program = await Program.start(VEHICLES);
});
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
  await program.stop();
});

const authority = (page: Page, id: number): Locator => card(page, id).getByTestId('authority');
const share = (page: Page): Locator => page.getByTestId('targets-authority');
const request = (page: Page): Locator => page.getByTestId('request');
/** The signs on the map. */
const marked = (page: Page) => page.evaluate(() => window.__skein!.held());

/** Opens the page as an operator of this name. */
async function sit(page: Page, name: string): Promise<void> {
  await open(page, program.url, VEHICLES);
  await button(page, 'Settings').click();
  const field = page.getByRole('textbox', { name: 'Your name, as other operators see it' });
  await expect(field).toHaveAttribute('placeholder', /^Console [0-9a-f]{4}$/);
  await field.fill(name);
  await field.press('Enter');
  await expect.poll(() => page.evaluate(() => localStorage.getItem('skein-operator'))).toBe(name);
  await page.keyboard.press('Escape');
  await expect(page.getByRole('dialog')).toHaveCount(0);
}

test('two operators share the fleet', { tag: '@long' }, async ({ page: anna, browser }) => {
  const context = await browser.newContext();
  const ben = await context.newPage();
  const faults: string[] = [];
  ben.on('pageerror', (error) => faults.push(error.message));

  await test.step('while nobody has control authority, there is one button and no word of it', async () => {
    await sit(anna, 'Anna');
    await sit(ben, 'Ben');
    for (const page of [anna, ben]) {
      await expect(page.getByTestId('authority')).toHaveCount(0);
      await expect(share(page)).toHaveText('Take');
    }
  });

  await test.step('Anna takes two, and both see it', async () => {
    await button(anna, /^Target 1,/).click();
    await button(anna, /^Target 2,/).click();
    await button(anna, 'Take 2').click();
    for (const id of [1, 2]) {
      await expect(authority(anna, id)).toHaveText('you');
      await expect(authority(ben, id)).toHaveText('Anna');
    }
    for (const page of [anna, ben]) await expect(authority(page, 3)).toHaveText('nobody');
    await expect.poll(() => marked(ben)).toEqual([{ id: 1, heard: true }, { id: 2, heard: true }]);
    expect(await marked(anna)).toEqual([]);
    await expect(share(anna)).toContainText('2 yours');
    await expect(share(ben)).toContainText('2 with Anna');
    await expect(share(ben)).toContainText("1 nobody's");
    await expect(anna.getByRole('log')).toContainText('Control taken: 1, 2');
    for (const page of [anna, ben]) expect(await findings(page)).toEqual([]);
  });

  await test.step('the table, the search and the page of a vehicle say it too', async () => {
    await ben.getByRole('link', { name: 'Fleet' }).click();
    const line = (id: number): Locator => ben.locator(`[data-row="${id}"]`);
    await expect(line(1).getByTestId('authority')).toHaveText('Anna');
    await ben.keyboard.press('/');
    await ben.keyboard.type('anna');
    await expect(ben.locator('[data-row]')).toHaveCount(2);
    await ben.keyboard.press('Escape');
    await expect(ben.locator('[data-row]')).toHaveCount(VEHICLES);
    await ben.getByRole('combobox', { name: 'Group' }).selectOption('authority');
    await expect(ben.getByRole('table', { name: 'Vehicles' })).toContainText("Under nobody's control");
    expect(await findings(ben)).toEqual([]);
    await ben.goto(`${program.url}/#vehicle/1`);
    await expect(ben.getByRole('region', { name: 'Vehicle 1' }).getByTestId('authority')).toHaveText('Anna');
    await ben.goto(`${program.url}/#map`);
  });

  await test.step("what is Anna's refuses Ben, and the page says so before", async () => {
    // The page of 1 has selected it.
    await button(ben, 'Take off 1').hover();
    await expect(ben.getByTestId('forecast')).toContainText('likely refused: 1 under the control of Anna: 1');
    await button(ben, 'Hold 1').hover();
    await expect(ben.getByTestId('forecast')).not.toContainText('under the control of');
    await hold(ben, 'Take off 1');
    await expect(summary(ben)).toContainText('1 of 1 refused');
    await expect(summary(ben)).toContainText('vehicle 1 is under the control of Anna');
    await expect(card(ben, 1).getByTestId('armed')).toContainText('disarmed');
  });

  await test.step('she flies it, and he may stop it and bring it down all the same', async () => {
    await hold(anna, 'Take off 2');
    await expect(summary(anna)).toContainText('2 of 2 done', { timeout: FLIGHT_MS });
    await expect(button(ben, `HOLD ALL ${VEHICLES}`)).toBeEnabled();
    await button(ben, 'Hold 1').click();
    await expect(summary(ben)).toContainText(/Hold\s*1 of 1 done/, { timeout: FLIGHT_MS });
    await button(ben, 'Land 1').click();
    await expect(summary(ben)).toContainText(/Land\s*1 of 1 done/, { timeout: FLIGHT_MS });
    await expect(authority(ben, 1)).toHaveText('Anna');
  });

  await test.step('Ben asks; Anna cannot overlook it, on whatever screen, and hands over', async () => {
    await button(ben, 'Ask for 1').click();
    await expect(authority(ben, 1)).toHaveText('Anna, asked');
    await expect(share(ben)).toContainText('asked for 1');
    await expect(request(anna)).toContainText('Ben asks for 1');
    await expect(button(anna, /^Seen: Ben asks for 1/)).toBeVisible();
    // A key that was meant for something else must not hand over.
    await expect(button(anna, 'Hand over')).not.toBeFocused();
    for (const [width, height] of [[360, 740], [768, 1024], [1024, 768], [3840, 2160], [1440, 900]] as const) {
      await anna.setViewportSize({ width, height });
      expect(await anna.evaluate(() => document.documentElement.scrollWidth - innerWidth), `${width} px`).toBeLessThanOrEqual(0);
      for (const name of ['Hand over', 'Not now']) {
        const box = (await button(anna, name).boundingBox())!;
        expect(box.x + box.width, `${name}, ${width} px`).toBeLessThanOrEqual(width);
        expect(box.y + box.height, `${name}, ${width} px`).toBeLessThanOrEqual(height);
        expect(box.height).toBeGreaterThanOrEqual(44);
      }
    }
    // Not at every width: who asks is forgotten after a minute.
    expect(await findings(anna)).toEqual([]);
    await button(anna, 'Hand over').click();
    await expect(request(anna)).toHaveCount(0);
    await expect(authority(anna, 1)).toHaveText('Ben');
    await expect(authority(ben, 1)).toHaveText('you');
    await expect(button(anna, /^Seen: Ben asks/)).toHaveCount(0);
    await expect(anna.getByRole('log')).toContainText('Handed over to Ben: 1');
    await expect(ben.getByRole('log')).toContainText('Under your control now: 1');
  });

  await test.step("now it is Anna's command that is refused", async () => {
    await button(anna, /^Target 2,/).click();
    await hold(anna, 'Arm 1');
    await expect(summary(anna)).toContainText('1 of 1 refused');
    await expect(summary(anna)).toContainText('vehicle 1 is under the control of Ben');
  });

  await test.step('"not now" puts a request away and changes nothing else', async () => {
    await button(ben, /^Target 1,/).click();
    await button(ben, /^Target 2,/).click();
    await button(ben, 'Ask for 1').click();
    await expect(request(anna)).toContainText('Ben asks for 2');
    await button(anna, 'Not now').click();
    await expect(request(anna)).toHaveCount(0);
    await expect(authority(anna, 2)).toHaveText('you');
    await expect(authority(ben, 2)).toHaveText('Anna, asked');
  });

  await test.step('a page that is loaded anew is the same console', async () => {
    await anna.reload();
    await expect(authority(anna, 2)).toHaveText('you');
    await expect(authority(anna, 1)).toHaveText('Ben');
    await expect(authority(ben, 2)).toContainText('Anna');
  });

  await test.step('whoever is gone is relieved', async () => {
    await context.close();
    await button(anna, /^Target 1,/).click();
    await expect(authority(anna, 1)).toHaveText('Ben, not heard', { timeout: RELIEF_MS });
    await expect.poll(() => marked(anna)).toEqual([{ id: 1, heard: false }]);
    await button(anna, 'Take 1').click();
    await expect(authority(anna, 1)).toHaveText('you');
    expect(await findings(anna)).toEqual([]);
  });

  await test.step('when all is let go the page is as it was', async () => {
    await button(anna, 'Target your 2').click();
    await expect(anna.getByTestId('targets')).toContainText('2 selected');
    await button(anna, 'Let go 2').click();
    await expect(anna.getByTestId('authority')).toHaveCount(0);
    expect(await marked(anna)).toEqual([]);
    await expect(share(anna)).toHaveText('Take 2');
  });
  expect(faults).toEqual([]);
});

test('a window opened from the page is another console, also of the same operator', { tag: '@long' }, async ({ page }) => {
  await sit(page, 'Anna');
  await button(page, /^Target 1,/).click();
  await button(page, 'Take 1').click();
  await expect(authority(page, 1)).toHaveText('you');
  // It is given a copy of what the tab has stored.
  const opening = page.waitForEvent('popup');
  await page.evaluate(() => void window.open(location.href));
  const other = await opening;
  await other.setViewportSize({ width: 1440, height: 900 });
  await expect(authority(other, 1)).toHaveText(/Anna \([0-9a-f]{4}\)/, { timeout: FLIGHT_MS });
  await button(other, /^Target 1,/).click();
  await button(other, 'Ask for 1').click();
  await expect(request(page)).toContainText(/Anna \([0-9a-f]{4}\) asks for 1/);
  await page.keyboard.press('a');
  await expect(button(page, 'Hand over')).toBeFocused();
  await page.keyboard.press('Enter');
  await expect(authority(other, 1)).toHaveText('you');
  await expect(authority(page, 1)).toHaveText(/Anna \(/);
});
