// The fleet on one page and a vehicle on its own: sorted, grouped, searched, told in charts; a vehicle gone silent looks so.

import { findings } from './accessibility';
import { button, expect, hold, open, selectAll, summary, test } from './console';
import { Program } from './program';

const VEHICLES = 4;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

test.beforeEach(async ({ page }) => {
  await open(page, program.url, VEHICLES);
});

test('a demonstration says on every page that it is simulated', { tag: '@long' }, async ({ page }) => {
  for (const where of ['map', 'fleet', 'vehicle/1', 'preflight', 'alerts', 'plugins', 'links']) {
    await page.goto(`${program.url}/#${where}`);
    await expect(page.getByTestId('reality'), where).toHaveText('SIM');
  }
});

test('the table is sorted, grouped and searched, and makes targets', { tag: '@long' }, async ({ page }) => {
  await page.getByRole('link', { name: 'Fleet' }).click();
  const table = page.getByRole('table', { name: 'Vehicles' });
  const order = (): Promise<string[]> => page.locator('[data-row]').evaluateAll((rows) => rows.map((row) => row.getAttribute('data-row') ?? ''));
  await expect(table.getByRole('row')).toHaveCount(VEHICLES + 1);
  expect(await order()).toEqual(['1', '2', '3', '4']);
  await table.getByRole('button', { name: 'Vehicle', exact: true }).click();
  await expect(table.getByRole('columnheader', { name: 'Vehicle', exact: true })).toHaveAttribute('aria-sort', 'descending');
  expect(await order()).toEqual(['4', '3', '2', '1']);
  await table.getByRole('button', { name: 'Vehicle', exact: true }).click();

  await page.getByRole('combobox', { name: 'Group' }).selectOption('place');
  await expect(table.getByText('On the ground')).toBeVisible();
  await button(page, `Target these ${VEHICLES}`).click();
  await expect(page.getByTestId('targets')).toContainText(`${VEHICLES} selected`);
  await button(page, 'Clear').click();

  await page.keyboard.press('/');
  await page.keyboard.type('2-3');
  await expect(page.locator('[data-row]')).toHaveCount(2);
  // Typing selects nothing: Enter goes to the button that does.
  await page.keyboard.press('Enter');
  await expect(page.getByTestId('targets')).toContainText('nothing selected');
  await expect(page.locator('[data-verb="target_shown"]')).toBeFocused();
  await page.keyboard.press('Enter');
  await expect(page.getByTestId('targets')).toContainText('2 selected');
  await page.getByRole('searchbox', { name: /^Find vehicles/ }).press('Escape');
  await expect(page.locator('[data-row]')).toHaveCount(VEHICLES);
  expect(await findings(page)).toEqual([]);
  await button(page, 'Cards').click();
  await expect(page.locator('[data-vehicle]')).toHaveCount(VEHICLES);
  expect(await findings(page)).toEqual([]);
});

test('a command says what it will do and to whom before it is given', async ({ page }) => {
  const told = page.getByTestId('forecast');
  await expect(told).toContainText('Select vehicles first');
  for (const name of ['Arm', 'Disarm', 'Take off']) await expect(button(page, name)).toBeDisabled();
  // What brings to safety is for all where nothing is selected, and marks them on the map.
  await button(page, `Hold all ${VEHICLES}`).hover();
  await expect(told).toContainText('Stop and hold the position');
  await selectAll(page);
  await button(page, `Take off ${VEHICLES}`).hover();
  await expect(told).toHaveText('Arm if need be, climb to 10 m and hold there: 1–4');
  await page.getByRole('spinbutton', { name: 'Take-off height' }).fill('14');
  await button(page, `Take off ${VEHICLES}`).hover();
  await expect(told).toContainText('climb to 14 m');
  // By key the button is found, not pressed: nothing goes out.
  const posts: string[] = [];
  page.on('request', (request) => request.method() === 'POST' && posts.push(request.url()));
  await page.locator('canvas').hover();
  await page.getByRole('application').focus();
  await page.keyboard.press('l');
  await expect(button(page, `Land ${VEHICLES}`)).toBeFocused();
  await expect(told).toHaveText('Land where it is: nobody · likely refused: 4 on the ground: 1–4');
  expect(posts).toEqual([]);
  // Given all the same, everybody answers for himself.
  await button(page, `Hold ${VEHICLES}`).click();
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} refused`);
  await button(page, 'Each vehicle').click();
  const each = page.getByRole('list', { name: 'Hold, each vehicle' });
  await expect(each.getByRole('listitem')).toHaveCount(VEHICLES);
  for (const line of await each.getByRole('listitem').all()) await expect(line).toContainText('refused: cannot hold while idle');
  expect(await findings(page)).toEqual([]);
});

test('keys: a list of them, pages by two of them', { tag: '@long' }, async ({ page }) => {
  await page.keyboard.press('?');
  const list = page.getByRole('dialog', { name: 'Keys' });
  await expect(list).toContainText('HOLD ALL');
  expect(await findings(page)).toEqual([]);
  await page.keyboard.press('Escape');
  await expect(list).toHaveCount(0);
  await page.keyboard.press('g');
  await page.keyboard.press('f');
  await expect(page.getByRole('region', { name: 'Fleet table' })).toBeVisible();
  await page.keyboard.press('g');
  await page.keyboard.press('p');
  await expect(page.getByRole('heading', { name: 'Supervision' })).toBeVisible();
  await page.goBack();
  await expect(page.getByRole('region', { name: 'Fleet table' })).toBeVisible();
  await page.keyboard.press('Shift+E');
  await expect(page.locator('#emergency-unlock')).toBeFocused();
});

for (const [width, height] of [[390, 844], [1024, 768], [1920, 1080]] as const) {
  test(`every page keeps the commands in reach at ${width} by ${height}`, { tag: '@long' }, async ({ page }) => {
    await page.setViewportSize({ width, height });
    for (const where of ['fleet', 'vehicle/2', 'preflight', 'alerts', 'plugins', 'links']) {
      await page.goto(`${program.url}/#${where}`);
      await expect(page.getByRole('navigation', { name: 'Pages' })).toBeVisible();
      expect(await findings(page), where).toEqual([]);
      expect(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), where).toBe(true);
      for (const name of [/^HOLD ALL/, /^RETURN ALL/, /^LAND ALL/, /^EMERGENCY STOP/, /^Take off/, /^Hold (all )?\d/, /^Land (all )?\d/, /^Return (all )?\d/]) {
        const box = (await button(page, name).boundingBox())!;
        expect(box.x + box.width, `${where} ${String(name)}`).toBeLessThanOrEqual(width);
        expect(box.y + box.height, `${where} ${String(name)}`).toBeLessThanOrEqual(height);
        expect(Math.min(box.width, box.height)).toBeGreaterThanOrEqual(44);
      }
    }
  });
}

// The last one: a vehicle that has landed is not at once ready for the next.
test('a vehicle has a page: charts that move, its events, its facts, what it carries', { tag: '@long' }, async ({ page }) => {
  await page.goto(`${program.url}/#vehicle/2`);
  const own = page.getByRole('region', { name: 'Vehicle 2' });
  await expect(own.getByRole('heading', { name: /^2/ })).toContainText('uav-2');
  await expect(own.getByTestId('vehicle-link')).toContainText('live');
  await expect(own.locator('canvas')).toHaveCount(6);
  await expect(own).toContainText('Height above launch');
  await expect(own).toContainText('MAVLink system');
  await expect(own.locator('[data-instance="model-2"]')).toContainText('Running');
  await expect(own.locator('[data-instance="payload-2-gimbal"]')).toBeVisible();
  expect(await findings(page)).toEqual([]);

  // Whose page is opened is whom the commands are for, and its payloads too.
  await expect(page.getByTestId('targets')).toContainText('1 selected 2');
  await expect(own.getByRole('button', { name: 'Take control' })).toBeEnabled();
  await button(page, /^Target 3,/).click();
  await expect(page.getByTestId('targets')).toContainText('2 selected');
  await expect(own.getByRole('button', { name: 'Take control' })).toBeDisabled();
  await button(page, 'Target only 2').first().click();
  await expect(page.getByTestId('targets')).toContainText('1 selected 2');
  await hold(page, 'Take off 1');
  await expect(summary(page)).toContainText('1 of 1 done', { timeout: 60_000 });
  const height = own.locator('figure').filter({ hasText: 'Height above launch' }).locator('figcaption b');
  await expect.poll(async () => Number.parseFloat((await height.textContent()) ?? '0')).toBeGreaterThan(8);
  await expect(own.getByRole('list')).toContainText('take off done');

  await page.getByRole('link', { name: 'Vehicle after this' }).click();
  await expect(page.getByRole('region', { name: 'Vehicle 3' })).toBeVisible();
  await expect(page.getByTestId('targets')).toContainText('1 selected 3');
  await page.keyboard.press('k');
  await expect(own).toBeVisible();
  await button(page, 'Land 1').click();
  await expect(summary(page)).toContainText(/Land\s*1 of 1 done/, { timeout: 60_000 });
  await page.goto(`${program.url}/#vehicle/99`);
  await expect(page.getByText('There is no vehicle 99 here.')).toBeVisible();
});
