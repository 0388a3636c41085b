// Takes pictures of the dashboard: node screenshot.mjs ADDRESS SECONDS FOLDER, run in web-ui.
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { setTimeout as wait } from 'node:timers/promises';

const [address, seconds, folder] = process.argv.slice(2);
const { chromium } = createRequire(join(process.cwd(), 'package.json'))('@playwright/test');
const browser = await chromium.launch({
  executablePath: process.env.SKEIN_CHROMIUM,
  args: ['--enable-unsafe-swiftshader', '--no-sandbox'],
});
try {
  const pages = [];
  for (const [name, width, height] of [
    ['console', 1440, 900],
    ['console-tablet', 820, 1180],
  ]) {
    const page = await browser.newPage({ viewport: { width, height } });
    await page.goto(address);
    pages.push([name, page]);
  }
  await pages[0][1].getByRole('tab', { name: 'Payloads' }).click();
  await wait(Number(seconds) * 1000);
  for (const [name, page] of pages) {
    const path = join(folder, `${name}.png`);
    await page.screenshot({ path });
    console.log(path);
  }
} finally {
  await browser.close();
}
