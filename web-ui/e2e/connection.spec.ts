// The server goes away and comes back: the page says so at once, blocks commands, shows how old everything is, and recovers alone.

import { button, card, expect, open, test } from './console';
import { Program } from './program';

const VEHICLES = 2;

let program: Program;
test.beforeAll(async () => {
  program = await Program.start(VEHICLES);
});
test.afterAll(() => program.stop());

test('a lost server is seen at once, and found again without a reload', async ({ page, watch }) => {
  // The browser itself reports every attempt that finds nobody.
  watch.expected.push(/WebSocket connection to .* failed/, /ERR_CONNECTION_REFUSED/, /Failed to load resource/);
  await open(page, program.url, VEHICLES);
  await expect(page.getByTestId('server-link')).toHaveText('live');
  await expect(card(page, 1).getByTestId('staleness')).toContainText('live');
  const banner = page.getByRole('alert');
  await expect(banner).toHaveCount(0);
  await button(page, /^Target 1,/).click();
  const port = program.port;

  await program.stop('SIGKILL');
  await expect(banner).toHaveText('Connection to the server lost', { timeout: 1500 });
  await expect(button(page, /^HOLD ALL/)).toBeDisabled();
  for (const name of [/^Arm/, /^Take off/, /^Hold 1$/, /^Land/, /^Return/, /^Form/]) await expect(button(page, name)).toBeDisabled();
  await expect(page.getByText(/next try in|trying now/)).toBeVisible();
  await expect(card(page, 1).getByTestId('staleness')).toContainText('stale', { timeout: 8000 });
  await expect(card(page, 1).getByTestId('staleness')).toContainText('lost', { timeout: 15_000 });

  program = await Program.start(VEHICLES, port);
  await expect(banner).toHaveCount(0);
  await expect(page.getByTestId('server-link')).toHaveText('live');
  await expect(page.getByTestId('armed').filter({ hasText: 'disarmed, ready' })).toHaveCount(VEHICLES, { timeout: 60_000 });
  await expect(card(page, 1).getByTestId('staleness')).toContainText('live');
  await expect(button(page, `HOLD ALL ${VEHICLES}`)).toBeEnabled();
  await expect(page.getByRole('log')).toContainText('the server was restarted');
  // What was selected, and what wanted to be seen, was of other vehicles.
  await expect(page.getByTestId('targets')).toContainText('nothing selected');
  await expect(page.getByRole('button', { name: /^Seen: connection to the server lost/ })).toHaveCount(0);
  const before = await page.evaluate(() => window.__skein!.framesTaken());
  await expect.poll(() => page.evaluate(() => window.__skein!.framesTaken())).toBeGreaterThan(before + 5);
});
