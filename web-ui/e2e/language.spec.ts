// The page in German: by the browser's wish, by choice, on every page, and back again. Codes and names of the program stay what they are.

import { findings } from './accessibility';
import { button, expect, test } from './console';
import { Program } from './program';

const VEHICLES = 2;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

test.describe('where the browser wants German', () => {
  test.use({ locale: 'de-AT' });

  test('every page is German and says so, and English is a choice that is remembered', { tag: '@long' }, async ({ page }) => {
    await page.goto(program.url);
    await expect(page.locator('html')).toHaveAttribute('lang', 'de');
    await expect(page.getByTestId('count-all')).toHaveText(`${VEHICLES}`, { timeout: 60_000 });
    await expect(button(page, `ALLE ${VEHICLES} HALTEN`)).toBeVisible();
    await button(page, /^Alle \d+ auswählen$/).click();
    await button(page, /^Starten/).hover();
    await expect(page.getByTestId('forecast')).toContainText('auf 10 m steigen und dort halten');
    const pages = page.getByRole('navigation', { name: 'Seiten' });
    for (const [name, word] of [['Flotte', 'Zustand'], ['Video', 'Übertragung'], ['Vorflug', 'grün'], ['Alarme', 'Ereignisse'], ['Plugins', 'Aufsicht'], ['Karte', 'Formation']] as const) {
      await pages.getByRole('link', { name }).click();
      await expect(page.getByRole('main')).toContainText(word);
      expect(await findings(page), name).toEqual([]);
    }
    for (const width of [360, 390, 1024, 1920]) {
      await page.setViewportSize({ width, height: 900 });
      expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), `${width} px`).toBeLessThanOrEqual(0);
    }

    await button(page, 'Einstellungen').click();
    await page.getByRole('radio', { name: 'English' }).check();
    await expect(page.locator('html')).toHaveAttribute('lang', 'en');
    await expect(button(page, `HOLD ALL ${VEHICLES}`)).toBeVisible();
    await page.reload();
    await expect(button(page, `HOLD ALL ${VEHICLES}`)).toBeVisible();
    await expect(page.locator('html')).toHaveAttribute('lang', 'en');
  });
});

test('German is chosen while the page is open', { tag: '@long' }, async ({ page }) => {
  await page.goto(program.url);
  await expect(button(page, `HOLD ALL ${VEHICLES}`)).toBeVisible({ timeout: 60_000 });
  await button(page, 'Settings').click();
  await page.getByRole('radio', { name: 'Deutsch' }).check();
  await expect(page.getByRole('dialog', { name: 'Einstellungen' })).toBeVisible();
  await page.keyboard.press('Escape');
  await expect(button(page, `ALLE ${VEHICLES} HALTEN`)).toBeVisible();
  await page.reload();
  await expect(button(page, `ALLE ${VEHICLES} HALTEN`)).toBeVisible();
});
