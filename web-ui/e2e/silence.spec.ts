// A vehicle falls silent: its row, its page and the counters say so, it stays among the targets, and the others are what they were.

import type { ChildProcess } from 'node:child_process';
import { findings } from './accessibility';
import { button, expect, test } from './console';
import { Program, freePort } from './program';

let program: Program;
const vehicles: ChildProcess[] = [];
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
  for (const vehicle of vehicles.splice(0)) vehicle.kill('SIGKILL');
  await program.stop();
});

test('a vehicle gone silent looks so, and is found again', { tag: '@long' }, async ({ page }) => {
  const port = await freePort();
  const sendTo = `127.0.0.1:${port}`;
  program = await Program.node([
    '[[endpoints]]', 'name = "sitl"', `address = "udp-listen://${sendTo}"`, '[[adopt]]', 'model = "generic-uav"',
  ]);
  vehicles.push(Program.vehicles(1, 1, sendTo), Program.vehicles(1, 2, sendTo));
  await page.goto(`${program.url}/#fleet`);
  const row = (id: number) => page.locator(`[data-row="${id}"]`);
  await expect(page.getByTestId('count-all')).toHaveText('2', { timeout: 60_000 });
  await expect(row(2).getByTestId('row-link')).toContainText('live', { timeout: 60_000 });
  await button(page, /^Target 2,/).click();

  vehicles[1]!.kill('SIGKILL');
  await expect(row(2).getByTestId('row-link')).toContainText('lost');
  await expect(row(2)).toContainText('link lost');
  await expect(row(1).getByTestId('row-link')).toContainText('live');
  await expect(page.getByRole('group', { name: 'Fleet counters' })).toContainText('1 lost');
  await expect(page.getByTestId('targets')).toContainText('1 selected 2');
  await button(page, /^Return 1/).hover();
  await expect(page.getByTestId('forecast')).toContainText('likely refused: 1 not heard: 2');
  expect(await findings(page)).toEqual([]);

  await row(2).getByRole('link', { name: /^Page of 2/ }).click();
  await expect(page.getByRole('region', { name: 'Vehicle 2' }).getByRole('status').first()).toContainText('Not heard for');
  await page.getByRole('link', { name: 'Alerts' }).click();
  const alert = page.getByTestId('alert').filter({ hasText: /link lost|not heard/i });
  await expect(alert.first()).toBeVisible();
  expect(await findings(page)).toEqual([]);
  const open = await page.getByTestId('alert').count();
  await alert.first().getByRole('button', { name: /^Acknowledge/ }).click();
  await expect(page.getByTestId('alert')).toHaveCount(open - 1);

  vehicles.push(Program.vehicles(1, 2, sendTo));
  await page.goto(`${program.url}/#fleet`);
  await expect(row(2).getByTestId('row-link')).toContainText('live', { timeout: 60_000 });
});
