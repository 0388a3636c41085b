// The console open for an hour while fifty vehicles stream, operated now and then: what it holds stays the same, and nothing is said on the
// console of the browser.

import { expect, plotted, test } from '../e2e/console';
import { Program } from '../e2e/program';
import { GESTURES } from './gestures';
import { HEAD, PARTS, growth, part, row, sample } from './footprint';
import type { Sample } from './footprint';
import { SOAK_S, VEHICLES } from './soakLength';

/** From one gesture to the next. */
const TURN_S = 12;
/** Frames of the stream that are drawn on the map before it is looked what the page holds. */
const FRAMES = 10;
const SLOW_MS = 60_000;

test(`${VEHICLES} vehicles for ${SOAK_S} s`, async ({ page, watch }) => {
  watch.expected.push(/GPU stall due to ReadPixels/);
  const program = await Program.start(VEHICLES);
  try {
    await page.goto(program.url);
    await expect(page.getByTestId('count-all')).toHaveText(`${VEHICLES}`, { timeout: SLOW_MS });
    await expect(page.getByTestId('armed').filter({ hasText: 'disarmed, ready' })).toHaveCount(VEHICLES, { timeout: SLOW_MS });
    const cdp = await page.context().newCDPSession(page);
    // What is bounded has to fill first: a round is not counted.
    for (const [turn, gesture] of GESTURES.entries()) await test.step(`first ${gesture.name}`, () => gesture.does(page, turn));
    const samples: Sample[] = [];
    const began = performance.now();
    const elapsedS = (): number => (performance.now() - began) / 1000;
    let told = 0;
    console.log(HEAD);
    for (let turn = 0; elapsedS() < SOAK_S; turn++) {
      const gesture = GESTURES[turn % GESTURES.length]!;
      await test.step(gesture.name, () => gesture.does(page, turn));
      // The rest of the turn nobody touches it.
      await page.waitForTimeout(Math.max(0, (turn + 1) * TURN_S - elapsedS()) * 1000);
      const taken = await page.evaluate(() => window.__skein!.framesTaken());
      await page.waitForFunction((least) => window.__skein!.framesTaken() > least, taken + FRAMES, { timeout: SLOW_MS });
      samples.push(await sample(cdp, elapsedS()));
      for (; told < PARTS - 1 && elapsedS() > ((told + 1) * SOAK_S) / PARTS; told++) console.log(row(part(samples, told, SOAK_S)));
    }
    console.log(row(part(samples, PARTS - 1, SOAK_S)));
    await expect(page.getByTestId('count-all')).toHaveText(`${VEHICLES}`);
    expect((await plotted(page)).length).toBe(VEHICLES);
    expect(growth(samples, SOAK_S)).toEqual([]);
  } finally {
    // A page that is still there would say on the console that its program is not.
    await page.close();
    await program.stop();
  }
});
