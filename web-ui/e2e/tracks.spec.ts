// Tracks on the page: what another sensor tells over the API becomes a track with an ellipse, which is named, pinned, observed and dropped.

import type { ChildProcess } from 'node:child_process';
import { findings } from './accessibility';
import { button, expect, hold, open, selectAll, summary, test } from './console';
import { Program, freePort } from './program';

const VEHICLES = 2;
/** What the radar sees: 40 m north of the vehicles, moving east. */
const [NORTH_M, EAST_M, DOWN_M] = [40, 0, -30] as const;
const SPEED_M_S = 1;

let program: Program;
let vehicles: ChildProcess;
let radar: ReturnType<typeof setInterval>;
test.beforeAll(async () => {
  const port = await freePort();
  program = await Program.node([
    // The one track here is true: it may steer.
    '[tracking]', 'steer_by_fused = true', '[[endpoints]]', 'name = "swarm"', `address = "udp-listen://127.0.0.1:${port}"`,
    '[[adopt]]', 'name = "uav-{system_id}"', 'model = "observation-uav"',
  ]);
  vehicles = Program.vehicles(VEHICLES, 1, `127.0.0.1:${port}`);
});
test.afterAll(async () => {
  clearInterval(radar);
  vehicles.kill('SIGKILL');
  await program.stop();
});

/** A radar tells five times a second what it sees; a question that is not answered is a radar that misses once. */
function startRadar(): void {
  const began = Date.now();
  radar = setInterval(() => {
    const east_m = EAST_M + ((Date.now() - began) / 1000) * SPEED_M_S;
    const seen = { id: 4, class: 'drone', score: 0.8, position: { north_m: NORTH_M, east_m, down_m: DOWN_M }, covariance_m2: [9, 0, 0, 4, 0, 16] };
    void fetch(`${program.url}/api/v1/detections`, {
      method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify({ source: 'radar', detections: [seen] }),
    }).catch(() => undefined);
  }, 200);
}

test('a track is seen, named, pinned, observed and dropped', async ({ page, watch }) => {
  await open(page, program.url, VEHICLES);
  const seen = () => page.evaluate(() => window.__skein!.tracksSeen());
  await expect(page.getByRole('tab', { name: 'Tracks' })).toHaveCount(0);
  expect(await seen()).toEqual([]);
  await selectAll(page);
  await hold(page, `Take off ${VEHICLES}`);
  await expect(summary(page)).toContainText(`${VEHICLES} of ${VEHICLES} done`, { timeout: 60_000 });
  startRadar();
  const panel = page.getByTestId('track-panel');
  const track = panel.getByTestId('track');

  await test.step('it is on the map with its ellipse and where it was, and a tap on it shows what is known', async () => {
    await expect.poll(async () => (await seen())[0]?.text).toMatch(/^Track \d+ drone$/);
    await expect.poll(async () => (await seen())[0]?.longM ?? 0).toBeGreaterThan(0.1);
    await expect.poll(async () => (await seen())[0]?.spots ?? 0).toBeGreaterThan(2);
    // Vehicles alone are kept in view; a wider look has both.
    for (let k = 0; k < 4; k++) await button(page, 'Zoom out').click();
    await expect(async () => {
      const box = (await page.locator('canvas').boundingBox())!;
      const at = await page.evaluate(() => {
        const [one] = window.__skein!.tracksSeen();
        return window.__skein!.toCanvas(one!.north, one!.east);
      });
      await page.mouse.click(box.x + at.x, box.y + at.y);
      await expect(track).toBeVisible({ timeout: 2000 });
    }).toPass();
    await expect(track).toContainText('drone');
    await expect(track).toContainText('radar');
    await expect(track).toContainText('fused from what is seen');
    await expect(track.getByTestId('track-place')).toContainText(' N, ');
    expect(await findings(page)).toEqual([]);
  });

  await test.step('it is named and pinned', async () => {
    await track.getByRole('textbox', { name: 'Name of the track' }).fill('Ghost');
    await track.getByRole('button', { name: 'Set name' }).click();
    await expect(track.getByRole('heading', { name: 'Ghost' })).toBeVisible();
    await track.getByRole('button', { name: 'Pin', exact: true }).click();
    await expect(track.getByRole('button', { name: 'Unpin' })).toBeVisible();
    await expect.poll(async () => (await seen()).map(({ text, pinned }) => [text, pinned])).toEqual([['Ghost drone', true]]);
  });

  await test.step('observers are proposed with reasons, and answer', async () => {
    const observers = track.getByTestId('observers');
    await expect(observers.locator('[data-observer]')).toHaveCount(VEHICLES);
    await expect(observers.locator('[data-observer="1"]')).toContainText(' away, ');
    await expect(observers.getByRole('button', { name: /^Observe: 1, 2$/ })).toBeEnabled();
    await observers.getByRole('button', { name: 'One less' }).click();
    await observers.getByRole('button', { name: /^Observe: \d$/ }).click();
    await expect(observers.getByTestId('observe-answers')).toContainText(/\d uav-\d: looks from \d{3}°/);
    await expect(observers.locator('[data-observer]').filter({ hasText: 'observ' })).not.toHaveCount(0);
  });

  await test.step('what is told does not ask for itself: it is as it was told', async () => {
    const { time } = (await (await page.request.get(`${program.url}/api/v1/tracks`)).json()) as { time: number };
    const told = { track: 7, position: { north_m: -80, east_m: 0, down_m: -20 }, velocity: { north_m_s: 0, east_m_s: 0, down_m_s: 0 }, time };
    expect((await page.request.put(`${program.url}/api/v1/tracks`, { data: { tracks: [told] } })).ok()).toBe(true);
    // Who could observe it may just be asked for when it ends.
    watch.expected.push(/404/);
    await panel.locator('[data-track="7"]').click();
    await expect(track.getByRole('button', { name: 'Pin', exact: true })).toBeDisabled();
    await expect(track).toContainText('told over the API');
    expect((await page.request.put(`${program.url}/api/v1/tracks`, { data: { tracks: [] } })).ok()).toBe(true);
    await expect(panel).toContainText('Track 7 has ended.');
  });

  await test.step('it is dropped, and its sensor begins no new one', async () => {
    await panel.getByRole('button', { name: /^Ghost/ }).click();
    await hold(page, track.getByRole('button', { name: 'Drop' }));
    await expect(track).toHaveCount(0);
    await expect.poll(seen).toEqual([]);
    await expect(panel).toContainText('Nothing is tracked now.');
  });
});
