// The page itself: its headers, its accessibility in every theme and on a tablet, the keyboard, the targets.

import { findings } from './accessibility';
import { button, card, expect, open, plotted, summary, test } from './console';
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

test('nothing but its own files may be loaded', async ({ page }) => {
  const response = await page.request.get(program.url);
  expect(response.headers()['content-security-policy']).toContain("default-src 'self'");
  const html = await response.text();
  expect(html).not.toMatch(/<script(?![^>]*\bsrc=)/);
  expect(html).not.toMatch(/(src|href)="(https?:)?\/\//);
});

for (const theme of ['Dark', 'Light', 'Sunlight']) {
  test(`no serious accessibility faults, ${theme.toLowerCase()}`, { tag: theme === 'Dark' ? [] : '@long' }, async ({ page }) => {
    await button(page, 'Settings').click();
    await page.getByRole('radio', { name: new RegExp(`^${theme}`) }).check();
    await expect(page.locator('html')).toHaveAttribute('data-theme', theme.toLowerCase());
    expect(await findings(page)).toEqual([]);
    await page.keyboard.press('Escape');
    await expect(page.getByRole('dialog')).toHaveCount(0);
    await page.reload();
    await expect(page.locator('html')).toHaveAttribute('data-theme', theme.toLowerCase());
    await button(page, /^Target 1,/).click();
    for (const tab of ['Formation', 'Route', 'By hand', 'Preflight', 'Fences', 'Payloads', 'Commands']) {
      await page.getByRole('tab', { name: tab }).click();
      expect(await findings(page), tab).toEqual([]);
    }
    for (const name of ['Fleet', 'Video', 'Preflight', 'Alerts', 'Plugins']) {
      await page.getByRole('navigation', { name: 'Pages' }).getByRole('link', { name }).click();
      expect(await findings(page), name).toEqual([]);
    }
  });
}

for (const [width, height] of [[1024, 768], [768, 1024], [390, 844]] as const) {
  test(`on a screen of ${width} by ${height} nothing is out of reach`, { tag: '@long' }, async ({ page }) => {
    await page.setViewportSize({ width, height });
    await expect(page.getByRole('tab', { name: 'Fleet' })).toBeVisible();
    expect(await findings(page)).toEqual([]);
    expect(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth)).toBe(true);
    // Where the commands have no room for it in one row it is in a menu.
    if (!(await button(page, /^Arm/).isVisible())) await button(page, 'More commands').click();
    for (const name of [/^HOLD ALL/, /^RETURN ALL/, /^LAND ALL/, /^EMERGENCY STOP/, /^Arm/, /^Take off/, /^Hold all \d/, /^Land all/, /^Return all/]) {
      const box = (await button(page, name).boundingBox())!;
      expect(box.x).toBeGreaterThanOrEqual(0);
      expect(box.x + box.width).toBeLessThanOrEqual(width);
      expect(box.y + box.height).toBeLessThanOrEqual(height);
      expect(Math.min(box.width, box.height)).toBeGreaterThanOrEqual(44);
    }
    await page.getByRole('tab', { name: 'Formation' }).click();
    await expect(button(page, /^Form wedge/)).toBeVisible();
  });
}

test('payloads: the camera\'s picture, the gimbal obeys, a restart is seen', async ({ page }) => {
  await page.getByRole('tab', { name: 'Payloads' }).click();
  const panel = page.getByTestId('payload-panel');
  await expect(panel).toContainText('Select a vehicle to see and command what it carries.');
  await panel.getByRole('button', { name: /^2 uav-2/ }).click();
  await expect(page.getByTestId('targets')).toContainText('1 selected 2');
  await expect(panel.getByRole('button', { name: 'Take control' })).toBeEnabled();
  const picture = panel.getByRole('img', { name: /camera/ });
  // A single picture, or live video that says how wide it is.
  const widthPx = (): Promise<number> => picture.evaluate((img: HTMLElement) => (img instanceof HTMLImageElement ? img.naturalWidth : Number(img.dataset.widthPx)));
  await expect.poll(widthPx, { timeout: 20_000 }).toBeGreaterThan(100);
  const gimbal = panel.locator('[data-instance="payload-2-gimbal"]');
  await gimbal.getByRole('button', { name: 'Take control' }).click();
  await gimbal.getByRole('button', { name: 'Down 45°' }).click();
  await expect(gimbal).toContainText('-45°', { timeout: 20_000 });
  expect(await findings(page)).toEqual([]);
  const incarnation = gimbal.getByTestId('instance-incarnation');
  await expect(incarnation).toHaveText('1');
  await gimbal.getByRole('button', { name: 'Restart' }).hover();
  const sent = page.waitForRequest((request) => request.url().endsWith('/restart'));
  await page.mouse.down();
  await sent;
  await page.mouse.up();
  await expect(incarnation).toHaveText('2', { timeout: 20_000 });
  await expect(gimbal.getByTestId('instance-status')).toHaveText('Running');
  await expect(gimbal).toContainText('-45°', { timeout: 20_000 });
});

test('targets: by number, by click on the map, by box, and said in words', { tag: '@long' }, async ({ page }) => {
  const targets = page.getByTestId('targets');
  await expect(targets).toContainText('nothing selected');
  await page.keyboard.press('/');
  await page.keyboard.type('1-2');
  await expect(page.locator('[data-vehicle]')).toHaveCount(2);
  await page.keyboard.press('Enter');
  await expect(targets).toContainText('nothing selected');
  await expect(button(page, 'Target these 2')).toBeFocused();
  await page.keyboard.press('Space');
  await expect(targets).toContainText('2 selected');
  await expect(button(page, 'Land 2')).toBeVisible();
  await page.getByRole('searchbox', { name: /^Find vehicles/ }).press('Escape');
  await expect(page.locator('[data-vehicle]')).toHaveCount(VEHICLES);

  const third = (await plotted(page)).find((v) => v.id === 3)!;
  await page.locator('canvas').click({ position: { x: third.x, y: third.y } });
  await expect(targets).toContainText('3 selected');
  await expect(button(page, /^Target 3,/)).toHaveAttribute('aria-pressed', 'true');
  await button(page, 'Clear').click();
  await expect(targets).toContainText('nothing selected');

  const all = await plotted(page);
  const box = (await page.locator('canvas').boundingBox())!;
  await button(page, 'Select with a box').click();
  await page.mouse.move(box.x + Math.min(...all.map((v) => v.x)) - 25, box.y + Math.min(...all.map((v) => v.y)) - 25);
  await page.mouse.down();
  await page.mouse.move(box.x + Math.max(...all.map((v) => v.x)) + 25, box.y + Math.max(...all.map((v) => v.y)) + 25, { steps: 4 });
  await page.mouse.up();
  await expect(targets).toContainText(`${VEHICLES} selected`);
});

test('what is typed in a field reaches neither the keys of the console nor the targets', async ({ page }) => {
  const posts: string[] = [];
  page.on('request', (request) => request.method() === 'POST' && !request.url().endsWith('/preview') && posts.push(request.url()));
  await button(page, /^Target 2,/).click();
  // The field is on another page: what is typed before it is there does nothing else either.
  await page.goto(`${program.url}/#vehicle/3`);
  await expect(page.getByTestId('targets')).toContainText('1 selected 3');
  await page.setViewportSize({ width: 1024, height: 768 });
  await page.locator('section.vehicle-page').focus();
  await page.keyboard.press('/');
  await page.keyboard.type('hold tlr');
  const search = page.getByRole('searchbox', { name: /^Find vehicles/ });
  await expect(search).toBeFocused();
  for (const key of ['h', 't', 'Enter', 'Escape', 'Escape', 'k', 'Enter', ' ']) await page.keyboard.press(key);
  await expect(search).toBeFocused();
  await expect(page.getByTestId('targets')).toContainText('1 selected 3');
  await expect(page.getByTestId('count-all')).toHaveText(`${VEHICLES}`);
  expect(posts).toEqual([]);
});

test('the keyboard alone arms a vehicle and disarms it', { tag: '@long' }, async ({ page }) => {
  await button(page, /^Target 1,/).focus();
  await page.keyboard.press('Space');
  await expect(page.getByTestId('targets')).toContainText('1 selected');
  for (const [name, key, state] of [['Arm 1', 'Space', 'armed'], ['Disarm 1', 'Enter', 'disarmed']] as const) {
    await button(page, name).focus();
    const sent = page.waitForRequest((request) => request.method() === 'POST' && request.url().endsWith('/commands'));
    await page.keyboard.down(key);
    await sent;
    await page.keyboard.up(key);
    await expect(card(page, 1).getByTestId('armed')).toHaveText(state === 'armed' ? 'armed' : /^disarmed/);
    await expect(summary(page)).toContainText('1 of 1 done');
  }
});

test('the map pans, zooms and fits', { tag: '@long' }, async ({ page }) => {
  const before = (await plotted(page))[0]!;
  await page.getByRole('application').focus();
  await page.keyboard.press('ArrowRight');
  await expect.poll(async () => (await plotted(page))[0]!.x).toBeCloseTo(before.x - 60, 0);
  await button(page, 'Zoom in').click();
  await button(page, 'Zoom in').click();
  const spread = async (): Promise<number> => {
    const [a, b] = await plotted(page);
    return Math.hypot(a!.x - b!.x, a!.y - b!.y);
  };
  const near = await spread();
  await button(page, 'Keep all vehicles in view').click();
  await expect.poll(spread).toBeLessThan(near);
  const frame = (await page.locator('canvas').boundingBox())!;
  for (const v of await plotted(page)) {
    expect(v.x).toBeGreaterThan(0);
    expect(v.x).toBeLessThan(frame.width);
  }
});

test('a sheet over a page is over all of it, also over the head of a table', { tag: '@long' }, async ({ page }) => {
  for (const name of ['Map', 'Fleet', 'Preflight', 'Alerts', 'Plugins']) {
    await page.getByRole('navigation').getByRole('link', { name }).click();
    await button(page, 'Settings').click();
    const sheet = page.getByRole('dialog', { name: 'Settings' });
    const covered = await sheet.evaluate((dialog) => {
      const { left, top, width, height } = dialog.getBoundingClientRect();
      const at = (x: number, y: number): Element | null => document.elementFromPoint(left + (width * x) / 20, top + (height * y) / 40);
      const over = new Set<string>();
      for (let y = 1; y < 40; y++) for (let x = 1; x < 20; x++) if (!dialog.contains(at(x, y))) over.add(at(x, y)?.outerHTML.slice(0, 80) ?? 'nothing');
      return [...over];
    });
    expect(covered, name).toEqual([]);
    await page.keyboard.press('Escape');
  }
});

test('what a command says, however long, widens nothing: the map stays beside the panel', { tag: '@long' }, async ({ page }) => {
  const edges = () =>
    page.evaluate(() => {
      const box = (of: string): DOMRect => document.querySelector(of)!.getBoundingClientRect();
      return { map: box('section.map').right, tools: box('[aria-label="View in space"]').right, panel: box('aside.right').left };
    });
  await page.setViewportSize({ width: 1440, height: 900 });
  await expect(page.getByTestId('forecast')).toBeVisible();
  await page.getByTestId('forecast').evaluate((line) => line.append(', likely refused'.repeat(200)));
  const { map, tools, panel } = await edges();
  expect(map).toBeLessThanOrEqual(panel + 0.5);
  expect(tools).toBeLessThan(panel);
});
