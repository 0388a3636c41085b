// What every test of the page shares: a page that is watched for errors and for requests to anywhere else, and the operator's
// gestures in words.

import { expect, test as base } from '@playwright/test';
import type { Locator, Page } from '@playwright/test';
import type { Hook } from '../src/features/map/hook';

type Watch = {
  /** Errors of the console that a test brings about on purpose. */
  expected: RegExp[];
};

/** `page`, watched: a console error, an exception or a request to another host fails the test. */
export const test = base.extend<{ watch: Watch }>({
  watch: [
    async ({ page }, use) => {
      const faults: string[] = [];
      const watch: Watch = { expected: [] };
      const hosts = new Set<string>();
      page.on('console', (message) => {
        if (message.type() === 'error' || message.type() === 'warning') faults.push(`console ${message.type()}: ${message.text()}`);
      });
      page.on('pageerror', (error) => faults.push(`exception: ${error.message}`));
      page.on('request', (request) => hosts.add(new URL(request.url()).hostname));
      page.on('websocket', (socket) => hosts.add(new URL(socket.url()).hostname));
      await use(watch);
      expect(faults.filter((fault) => !watch.expected.some((pattern) => pattern.test(fault)))).toEqual([]);
      expect([...hosts].filter((host) => host !== '127.0.0.1')).toEqual([]);
    },
    { auto: true },
  ],
});

export { expect };

export const button = (page: Page, name: string | RegExp): Locator => page.getByRole('button', { name, exact: true });
export const card = (page: Page, id: number): Locator => page.locator(`[data-vehicle="${id}"]`);
export const summary = (page: Page): Locator => page.getByTestId('command-summary');

/** Opens the dashboard and waits until `vehicles` are heard and would arm. */
export async function open(page: Page, url: string, vehicles: number): Promise<void> {
  await page.goto(url);
  await expect(page.getByTestId('count-all')).toHaveText(`${vehicles}`, { timeout: 60_000 });
  await expect(page.getByTestId('armed').filter({ hasText: 'disarmed, ready' })).toHaveCount(vehicles, { timeout: 60_000 });
}

/** Selects every vehicle: what moves them is offered for nobody else. */
export async function selectAll(page: Page): Promise<void> {
  await button(page, /^Select all \d+$/).click();
}

/** Holds a guarded button with the mouse until what it does goes out to the server. */
export async function hold(page: Page, which: string | RegExp | Locator): Promise<void> {
  const target = typeof which === 'string' || which instanceof RegExp ? button(page, which) : which;
  await expect(target).toBeEnabled();
  await target.hover();
  // What a preview asks goes out by itself, and may do so while the button is held.
  const sent = page.waitForRequest((request) => request.method() !== 'GET' && !request.url().endsWith('/preview'));
  await page.mouse.down();
  await sent;
  await page.mouse.up();
}

/** What is on the canvas. */
export async function plotted(page: Page): Promise<ReturnType<Hook['positions']>> {
  return page.evaluate(() => window.__skein?.positions() ?? []);
}

/** Smallest distance between any two vehicles on the map, in metres. */
export async function smallestDistance(page: Page): Promise<number> {
  const all = await plotted(page);
  let least = Infinity;
  for (const a of all) {
    for (const b of all) if (a.id < b.id) least = Math.min(least, Math.hypot(a.northM - b.northM, a.eastM - b.eastM));
  }
  return least;
}

/** Largest distance of a vehicle to its slot, in metres; infinite while not `followers` have one. */
export async function largestSlotError(page: Page, followers: number): Promise<number> {
  const slotted = (await plotted(page)).filter((v) => v.slot !== null);
  if (slotted.length < followers) return Infinity;
  return Math.max(...slotted.map((v) => Math.hypot(v.northM - v.slot!.northM, v.eastM - v.slot!.eastM)));
}
