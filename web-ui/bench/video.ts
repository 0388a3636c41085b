// How long a picture takes from the camera's glass to the screen's, on each of the three ways into the browser: by the clock that the simulated
// camera draws into its pictures, read back from what is shown. And what it takes where the page shows a wall of cameras.

import type { Page } from '@playwright/test';
import { expect, test } from '@playwright/test';
import type { StreamTruth } from '../src/features/video/hook';
import { Program, freePort } from '../e2e/program';

const SECONDS = Number(process.env.SKEIN_BENCH_SECONDS ?? 20);
const START_MS = 60_000;
/** The page keeps what it has read for so long. */
const KEPT_S = 10;
/** So long a way runs before it is measured. */
const SETTLE_MS = 5000;
const WAYS = ['webcodecs', 'webrtc', 'jpeg'] as const;
const WALL = 4;

const streams = (page: Page): Promise<StreamTruth[]> => page.evaluate(() => window.__skeinVideo?.streams() ?? []);

async function node(): Promise<{ program: Program; stop(): Promise<void> }> {
  const sendTo = `127.0.0.1:${await freePort()}`;
  const program = await Program.node([
    '[[endpoints]]', 'name = "bench"', `address = "udp-listen://${sendTo}"`,
    '[[adopt]]', 'name = "uav-{system_id}"', 'model = "generic-uav"',
    '[[adopt.payloads]]', 'name = "camera"', 'plugin = "camera"',
    'config = { source = "synthetic", width_px = 640, height_px = 480, rate_hz = 30.0, clock = true }',
  ]);
  const vehicles = Program.vehicles(WALL, 1, sendTo);
  const stop = async (): Promise<void> => {
    vehicles.kill('SIGKILL');
    await program.stop();
  };
  return { program, stop };
}

function row(what: string, all: StreamTruth[][]): string {
  const delays = all.flatMap((sample) => sample.flatMap(({ glassToGlassMs }) => glassToGlassMs)).sort((a, b) => a - b);
  const quantile = (q: number): string => `${(delays[Math.min(delays.length - 1, Math.floor(delays.length * q))] ?? NaN).toFixed(0)} ms`;
  const rates = all.flatMap((sample) => sample.map(({ rateHz }) => rateHz));
  const rate = rates.reduce((sum, one) => sum + one, 0) / rates.length;
  return [what.padEnd(26), quantile(0.5).padStart(8), quantile(0.99).padStart(8), quantile(1).padStart(9), `${rate.toFixed(1)}/s`.padStart(9)].join('');
}

/** What is read of each stream that is shown in these ways and qualities, over the time of the measurement. */
async function measure(page: Page, shown: number): Promise<StreamTruth[][]> {
  const all = [];
  await page.waitForTimeout(SETTLE_MS);
  for (let passed = 0; passed < SECONDS; passed += KEPT_S) {
    await page.waitForTimeout(Math.min(KEPT_S, SECONDS) * 1000);
    const now = (await streams(page)).sort((a, b) => b.widthPx - a.widthPx).slice(0, shown);
    all.push(now);
  }
  return all;
}

test('glass to glass', async ({ page }) => {
  const { program, stop } = await node();
  try {
    await page.goto(`${program.url}/#video`);
    await expect(page.locator('[data-stream]')).toHaveCount(WALL, { timeout: START_MS });
    console.log(`\nglass to glass, loopback, ${SECONDS} s a row`);
    console.log('way, picture                 p50     p99  longest     rate');
    for (const wall of [false, true]) {
      await page.getByRole('button', { name: wall ? 'Wall' : 'One large', exact: true }).click();
      for (const way of WAYS) {
        await page.getByRole('combobox', { name: 'Way' }).selectOption(way);
        const taken = async (): Promise<boolean> => {
          const now = await streams(page);
          return now.length > 0 && now.every((one) => one.way === way && one.lastClockMs !== null);
        };
        await expect.poll(taken, { timeout: START_MS }).toBe(true);
        const all = await measure(page, wall ? WALL : 1);
        const { widthPx, heightPx } = all[0]![0]!;
        console.log(row(`${way}, ${wall ? `${WALL} of ` : ''}${widthPx}x${heightPx}`, all));
      }
    }
  } finally {
    // A page that is still there would ask for its program for ever.
    await page.close();
    await stop();
  }
});
