// What the page takes with many vehicles: main-thread time, frame times, bytes on the socket, time to the first vehicle, sizes.
// The vehicles fly north all the while, so that they have trails; the page is asked for 10 frames a second, as on a tablet.

import { readFileSync, readdirSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { gzipSync } from 'node:zlib';
import { expect, test } from '@playwright/test';
import type { CDPSession, Page } from '@playwright/test';
import type {} from '../src/features/map/hook';
import type {} from '../src/features/view3d/hook';
import { feed } from './feed';
import type { Feed } from './feed';
import { busiest, mainThreads } from './processes';

const SWARMS = (process.env.SKEIN_BENCH_VEHICLES ?? '50,200,1000').split(',').map(Number);
const SECONDS = Number(process.env.SKEIN_BENCH_SECONDS ?? 15);
const START_MS = 120_000;
/** So long they fly before anything is measured; then map, map dragged and space, with some time to get from one to the other. */
const SETTLE_MS = 8000;
const SPEED_M_S = 3;
const WAY_M = SPEED_M_S * (SETTLE_MS / 1000 + 3 * SECONDS + 30);

test.use({ hasTouch: true });

type Figures = {
  mainThreadPercent: number; mapHz: number; frameP50Ms: number; frameP99Ms: number; socketKbS: number; socketHz: number; heapMb: number; longTasks: number;
};

/** With `stirred` the view is moved before every picture, as a hand does that drags it. */
async function measure(page: Page, cdp: CDPSession, frames: () => Promise<number>, stirred = false): Promise<Figures> {
  let bytes = 0;
  let messages = 0;
  const count = ({ response }: { response: { opcode: number; payloadData: string } }): void => {
    const binary = response.opcode === 2;
    bytes += binary ? (response.payloadData.length * 3) / 4 : response.payloadData.length;
    if (binary) messages++;
  };
  cdp.on('Network.webSocketFrameReceived', count);
  const [drawn, threads, from] = [await frames(), mainThreads(), performance.now()];
  const { times, longTasks } = await page.evaluate(async ({ ms, stirred }) => {
    const times: number[] = [];
    let longTasks = 0;
    const observer = new PerformanceObserver((list) => (longTasks += list.getEntries().length));
    observer.observe({ type: 'longtask' });
    const end = performance.now() + ms;
    let last = performance.now();
    await new Promise<void>((done) => {
      const step = (now: number): void => {
        const key = times.length % 60 < 30 ? 'ArrowLeft' : 'ArrowRight';
        if (stirred) document.querySelector('[role=application]:not([inert])')?.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
        times.push(now - last);
        last = now;
        if (now < end) requestAnimationFrame(step);
        else done();
      };
      requestAnimationFrame(step);
    });
    observer.disconnect();
    return { times: times.slice(1).sort((a, b) => a - b), longTasks };
  }, { ms: SECONDS * 1000, stirred });
  const seconds = (performance.now() - from) / 1000;
  const busy = busiest(threads);
  cdp.off('Network.webSocketFrameReceived', count);
  const heap = await cdp.send('Runtime.getHeapUsage');
  const quantile = (q: number): number => times[Math.min(times.length - 1, Math.floor(times.length * q))] ?? 0;
  return {
    mainThreadPercent: (busy / seconds) * 100, mapHz: ((await frames()) - drawn) / seconds, frameP50Ms: quantile(0.5), frameP99Ms: quantile(0.99),
    socketKbS: bytes / seconds / 1000, socketHz: messages / seconds, heapMb: heap.usedSize / 1e6, longTasks,
  };
}

/** Brings all into the air and sends each north. */
async function fly(page: Page, { url, isMadeUp }: Feed, vehicles: number): Promise<void> {
  type Listed = { vehicles: { ready_to_arm: boolean; flight_state: string }[] };
  const until = (wanted: (one: Listed['vehicles'][number]) => boolean) =>
    expect.poll(async () => ((await (await page.request.get(`${url}/api/v1/vehicles`)).json()) as Listed).vehicles.filter(wanted).length, { timeout: START_MS }).toBe(vehicles);
  const order = async (data: object): Promise<void> => expect((await page.request.post(`${url}/api/v1/commands`, { data })).ok()).toBe(true);
  if (!isMadeUp) await until((one) => one.ready_to_arm);
  await order({ targets: 'all', command: { command: 'take_off', height_m: 10 } });
  // The made-up swarm tells of a vehicle's state in its frames only.
  await expect(page.getByTestId('count-air')).toHaveText(`${vehicles}`, { timeout: START_MS });
  if (!isMadeUp) await until((one) => one.flight_state === 'holding');
  for (const { id, northM, eastM } of await page.evaluate(() => window.__skein!.positions())) {
    const position = { north_m: northM + WAY_M, east_m: eastM, down_m: -10 };
    await order({ targets: { vehicles: [id] }, command: { command: 'go_to', position, speed_m_s: SPEED_M_S } });
  }
}

function row(what: string, f: Figures): string {
  return [
    what.padEnd(22), `${f.mainThreadPercent.toFixed(1)} %`.padStart(8), `${f.mapHz.toFixed(1)} Hz`.padStart(9), `${f.frameP50Ms.toFixed(1)} ms`.padStart(9),
    `${f.frameP99Ms.toFixed(1)} ms`.padStart(9), `${f.socketHz.toFixed(1)} Hz`.padStart(9), `${f.socketKbS.toFixed(0)} kB/s`.padStart(10),
    `${f.heapMb.toFixed(0)} MB`.padStart(7), `${f.longTasks}`.padStart(6),
  ].join('');
}

const HEAD = 'vehicles, view          main    pictures    frame p50      p99   socket              heap  tasks > 50 ms';

for (const vehicles of SWARMS) {
  test(`${vehicles} vehicles`, async ({ page }) => {
    const program = await feed(vehicles);
    try {
      const cdp = await page.context().newCDPSession(page);
      await cdp.send('Network.enable');
      await page.goto(program.url);
      const counted = page.getByTestId('count-all');
      await counted.filter({ hasText: `${vehicles}` }).waitFor({ timeout: 60_000 });
      const cold = await page.evaluate(() => window.__skein!.firstVehicleMs() ?? NaN);
      await page.reload();
      await page.waitForFunction(() => window.__skein?.firstVehicleMs() != null);
      const first = await page.evaluate(() => window.__skein!.firstVehicleMs() ?? NaN);
      console.log(`\n${vehicles} vehicles of ${program.what}: the first is drawn ${first.toFixed(0)} ms after the page was asked for (at the program's start ${cold.toFixed(0)} ms)`);
      await fly(page, program, vehicles);
      await page.waitForTimeout(SETTLE_MS);
      console.log(HEAD);
      console.log(row(`${vehicles}, map`, await measure(page, cdp, () => page.evaluate(() => window.__skein!.framesDrawn()))));
      console.log(row(`${vehicles}, map dragged`, await measure(page, cdp, () => page.evaluate(() => window.__skein!.framesDrawn()), true)));
      await page.getByRole('button', { name: 'Keep all vehicles in view', exact: true }).click();
      await page.getByRole('button', { name: 'View in space', exact: true }).click();
      await page.waitForFunction(() => (window.__skeinSpace?.frames() ?? 0) > 2, undefined, { timeout: 60_000 });
      const kind = await page.evaluate(() => window.__skeinSpace!.drawer());
      console.log(row(`${vehicles}, space (${kind})`, await measure(page, cdp, () => page.evaluate(() => window.__skeinSpace!.frames()))));
    } finally {
      await program.stop();
    }
  });
}

test('sizes', () => {
  const folder = resolve(import.meta.dirname, '../dist/assets');
  console.log('\ncompressed with gzip:');
  for (const name of readdirSync(folder).sort()) console.log(`  ${name.padEnd(34)} ${(gzipSync(readFileSync(join(folder, name))).length / 1000).toFixed(1).padStart(7)} kB`);
});
