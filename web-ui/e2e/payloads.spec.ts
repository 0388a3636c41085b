// Panels of payloads: made from a plugin's schema, and by hand where it helps; the gimbal follows a finger.

import { findings } from './accessibility';
import { expect, open, test } from './console';
import { Program } from './program';

const VEHICLES = 2;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

test.beforeEach(async ({ page }) => {
  await open(page, program.url, VEHICLES);
  await page.goto(`${program.url}/#vehicle/2`);
});

test('a panel made from the schema: fields with units, what is wrong is said, what is right is done', { tag: '@long' }, async ({ page }) => {
  const gimbal = page.locator('[data-instance="payload-2-gimbal"]');
  await gimbal.getByRole('button', { name: 'Take control' }).first().click();
  await gimbal.getByText('Everything it can be asked').click();
  const panel = gimbal.getByTestId('schema-panel');
  await expect(panel.getByRole('button', { name: 'Neutral' })).toBeVisible();
  await panel.getByText('Angles', { exact: true }).or(panel.locator('summary', { hasText: /^Angles/ })).first().click();
  const form = panel.getByRole('form', { name: 'Angles' });
  const posts: string[] = [];
  page.on('request', (request) => request.url().endsWith('/command') && posts.push(request.postData() ?? ''));
  await form.getByRole('spinbutton', { name: 'Pitch, °' }).fill('-30');
  await form.getByRole('button', { name: 'Send angles' }).click();
  await expect(form).toContainText('Yaw is needed');
  expect(posts).toEqual([]);
  await form.getByRole('spinbutton', { name: 'Yaw, °' }).fill('10');
  await form.getByRole('button', { name: 'Send angles' }).click();
  await expect.poll(() => posts.length).toBe(1);
  const sent = JSON.parse(posts[0]!) as { command: string; pitch_rad: number; yaw_rad: number; yaw_frame: string };
  expect(sent).toMatchObject({ command: 'angles', yaw_frame: 'vehicle' });
  expect(sent.pitch_rad).toBeCloseTo(-Math.PI / 6);
  await expect(gimbal).toContainText('-30°', { timeout: 20_000 });
  expect(await findings(page)).toEqual([]);
});

test('the gimbal follows a finger on its pad, the arrow keys, and the picture that is taken hold of', { tag: '@long' }, async ({ page }) => {
  const gimbal = page.locator('[data-instance="payload-2-gimbal"]');
  await gimbal.getByRole('button', { name: 'Take control' }).first().click();
  const pad = gimbal.getByRole('application');
  await pad.scrollIntoViewIfNeeded();
  const box = (await pad.boundingBox())!;
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 4);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height - 3, { steps: 6 });
  await page.mouse.up();
  await expect(gimbal).toContainText(/-8[5-9]°|-90°/, { timeout: 20_000 });
  await gimbal.getByRole('button', { name: 'Ahead' }).click();
  await expect(pad).toHaveAccessibleName(/Pitch -?0°, yaw -?0°/, { timeout: 20_000 });

  // One step of the keyboard goes out from where it was told to be last.
  const pressed = page.waitForRequest((request) => request.url().includes('gimbal/command'));
  await pad.focus();
  await page.keyboard.press('ArrowUp');
  expect((await pressed).postDataJSON()).toMatchObject({ command: 'angles' });

  const picture = page.getByRole('img', { name: /What camera of/ });
  await picture.scrollIntoViewIfNeeded();
  const seen = (await picture.boundingBox())!;
  const aimed = page.waitForRequest((request) => request.url().includes('gimbal/command'));
  // A place right of the middle comes to the middle: the gimbal turns to the right.
  await page.mouse.click(seen.x + seen.width * 0.8, seen.y + seen.height / 2);
  const command = (await aimed).postDataJSON() as { yaw_rad: number };
  expect(command.yaw_rad).toBeGreaterThan(0.1);
});
