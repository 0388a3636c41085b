// The dead-man's switch through the page: a sign of life goes out while somebody is there, and the strip says how it stands.

import { expect, test } from './console';
import { Program } from './program';

let program: Program;
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
  await program.stop();
});

test('where the node asks for signs of life, a page in use gives them', async ({ page }) => {
  program = await Program.node([
    '[safety.failsafe.operator_dead_man]', 'mode = "react"', 'steps = [{ after_s = 3.0, reaction = "warn" }]',
  ]);
  const signs: number[] = [];
  page.on('request', (request) => {
    if (request.url().endsWith('/api/v1/operator/alive')) signs.push(Date.now());
  });
  await page.goto(program.url);
  const sign = page.getByTestId('dead-man');
  await expect(sign).toContainText('Operator heard');
  // Again and again, within the time after which vehicles would react.
  await expect.poll(() => signs.length, { timeout: 20_000 }).toBeGreaterThan(4);
  await expect(sign).toContainText('Operator heard');

  // Nobody has touched the page for long: the clock of the page is moved on, not the server's.
  await page.evaluate(() => {
    const real = performance.now.bind(performance);
    performance.now = () => real() + 45_000;
  });
  await expect(sign).toContainText('Are you there?');
  await page.evaluate(() => {
    const before = performance.now.bind(performance);
    performance.now = () => before() + 45_000;
  });
  await expect(sign).toContainText('No operator heard', { timeout: 20_000 });
  const silent = signs.length;
  await sign.getByRole('button', { name: 'I am here' }).click();
  await expect(sign).toContainText('Operator heard');
  expect(signs.length).toBeGreaterThan(silent);
});

test('where it does not, nothing is said and nothing is sent', { tag: '@long' }, async ({ page }) => {
  program = await Program.node([]);
  let signs = 0;
  page.on('request', (request) => {
    if (request.url().endsWith('/api/v1/operator/alive')) signs++;
  });
  await page.goto(program.url);
  await expect(page.getByTestId('count-all')).toHaveText('0');
  await page.mouse.move(200, 300);
  await page.waitForTimeout(2500);
  expect(signs).toBe(0);
  await expect(page.getByTestId('dead-man')).toHaveCount(0);
});
