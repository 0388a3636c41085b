// From the narrowest phone to the widest screen: nothing that is always visible is cut off, with everything to be counted there is.

import type { ChildProcess } from 'node:child_process';
import type { Locator } from '@playwright/test';
import { expect, test } from './console';
import { Program, freePort } from './program';

let program: Program;
const vehicles: ChildProcess[] = [];
test.afterEach(async ({ page }) => {
  // A page that is still there would say on the console that its program is not.
  await page.close();
  for (const vehicle of vehicles.splice(0)) vehicle.kill('SIGKILL');
  await program.stop();
});

/** What is wider or higher than the room it has, or stands out of the window, by its words. */
async function cutOff(place: Locator): Promise<string[]> {
  return place.evaluate((element) =>
    [...element.querySelectorAll<HTMLElement>('button, h1, dl')]
      .filter((part) => part.getClientRects().length > 0)
      .filter((part) => {
        const box = part.getBoundingClientRect();
        return box.left < 0 || box.right > innerWidth + 0.5 || part.scrollWidth > part.clientWidth + 1;
      })
      .map((part) => part.innerText),
  );
}

test('the counters are whole from 360 px to 4K', { tag: '@long' }, async ({ page }) => {
  const port = await freePort();
  const sendTo = `127.0.0.1:${port}`;
  program = await Program.node([
    '[[endpoints]]', 'name = "sitl"', `address = "udp-listen://${sendTo}"`, '[[adopt]]', 'model = "generic-uav"',
  ]);
  vehicles.push(Program.vehicles(11, 1, sendTo), Program.vehicles(1, 21, sendTo));
  await page.goto(program.url);
  await expect(page.getByTestId('count-all')).toHaveText('12', { timeout: 60_000 });
  // Vehicles of which nobody says that they are simulated count as real, wherever they are heard.
  await expect(page.getByTestId('reality')).toHaveText('REAL');
  vehicles[1]!.kill('SIGKILL');
  const counters = page.getByRole('group', { name: 'Fleet counters' });
  await expect(counters).toContainText('1 lost');

  for (const [width, height] of [[360, 740], [390, 844], [561, 900], [768, 1024], [901, 700], [1024, 768], [1241, 800], [1920, 1080], [3840, 2160]] as const) {
    await page.setViewportSize({ width, height });
    await expect(counters).toBeVisible();
    expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), `${width} px: page`).toBeLessThanOrEqual(0);
    expect(await cutOff(page.getByRole('banner')), `${width} px: top bar`).toEqual([]);
    expect(await cutOff(page.getByRole('region', { name: 'Safety' })), `${width} px: safety strip`).toEqual([]);
    const inside = await counters.evaluate((group) => {
      const { left, right } = group.getBoundingClientRect();
      return [...group.children].filter((part) => part.getClientRects().length > 0).every((part) => {
        const box = part.getBoundingClientRect();
        return box.left >= left - 0.5 && box.right <= right + 0.5;
      });
    });
    expect(inside, `${width} px: every counter inside of the group`).toBe(true);
  }
});
