// Takes pictures of the dashboard: node screenshot.mjs ADDRESS SECONDS FOLDER, run in web-ui. Every page and panel that there is, at three
// widths, light and dark, some in sunlight and in German, as small WebP files in FOLDER/pages; two PNG files of the whole console; and the
// flight itself as a moving picture, FOLDER/flight.webp.
import { createRequire } from 'node:module';
import { mkdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { setTimeout as wait } from 'node:timers/promises';

const [address, seconds, folder] = process.argv.slice(2);
const { chromium } = createRequire(join(process.cwd(), 'package.json'))('@playwright/test');
const pages = join(folder, 'pages');
const QUALITY = Number(process.env.SKEIN_PICTURE_QUALITY ?? 32);
const SIZES = [[1920, 1080], [1024, 768], [390, 844]];
/** What a page shows is complete some time after it was opened: trails, pictures, reports. */
const SETTLE_MS = 1500;
const PANEL_MS = 700;
let total = 0;

async function picture(page, cdp, name) {
  const { data } = await cdp.send('Page.captureScreenshot', { format: 'webp', quality: QUALITY });
  const bytes = Buffer.from(data, 'base64');
  total += bytes.length;
  writeFileSync(join(pages, `${name}.webp`), bytes);
  // For whoever wants to look at them with a tool that knows no WebP.
  if (process.env.SKEIN_PICTURE_PNG) await page.screenshot({ path: join(process.env.SKEIN_PICTURE_PNG, `${name}.png`) });
  console.log(`${name} ${(bytes.length / 1000).toFixed(0)} kB`);
}

const press = (page, name) => page.getByRole('button', { name, exact: true }).click();

/** Every tab there is, whatever it is called. */
async function panels(page, cdp, prefix) {
  const tabs = page.getByRole('tab');
  for (let k = 0; k < (await tabs.count()); k++) {
    const tab = tabs.nth(k);
    const words = ((await tab.textContent()) ?? '').replace(/[\d\s]+$/, '').trim().toLowerCase().replace(/\W+/g, '-');
    await tab.click();
    // On a phone what is chosen is below the map.
    await page.locator(`#${await tab.getAttribute('aria-controls')}`).scrollIntoViewIfNeeded();
    await wait(PANEL_MS);
    await picture(page, cdp, `${prefix}-${words}`);
  }
}

/** The map with all its layers, then from space. */
async function maps(page, cdp, prefix) {
  await page.locator('section[aria-label="Map"]').scrollIntoViewIfNeeded();
  await press(page, 'Layers');
  await page.getByRole('checkbox', { name: 'Links', exact: true }).check();
  await page.getByRole('checkbox', { name: 'Way of the next 3 s', exact: true }).check();
  await page.getByRole('checkbox', { name: 'What cameras see', exact: true }).check();
  await wait(PANEL_MS);
  await picture(page, cdp, `${prefix}-map-layers`);
  await press(page, 'Layers');
  await press(page, 'View in space');
  await page.waitForFunction(() => (window.__skeinSpace?.frames() ?? 0) > 3);
  await wait(SETTLE_MS);
  await picture(page, cdp, `${prefix}-space`);
}

/** Every page of the rail, and those of a vehicle. */
async function pagesOf(page, cdp, prefix) {
  const links = await page.locator('nav a[href^="#"]').evaluateAll((all) => all.map((link) => link.getAttribute('href').slice(1)));
  for (const name of [...links.filter((name) => name !== 'map'), 'vehicle/1', 'vehicle/1/parameters', 'vehicle/1/logs']) {
    await page.goto(`${address}#${name}`);
    await wait(SETTLE_MS);
    await picture(page, cdp, `${prefix}-page-${name.replace('/1', '').replace('/', '-')}`);
  }
  await page.goto(`${address}#map`);
  await wait(PANEL_MS);
}

/** What this browser can be set to. */
async function settings(browser) {
  const page = await browser.newPage({ viewport: { width: 1024, height: 768 } });
  const cdp = await page.context().newCDPSession(page);
  await page.goto(address);
  await wait(SETTLE_MS);
  await press(page, 'Settings');
  await page.getByRole('radio', { name: /^Sunlight/ }).check();
  await wait(PANEL_MS);
  await picture(page, cdp, '1024-sunlight-settings');
  await press(page, 'Close the settings');
  await picture(page, cdp, '1024-sunlight-map');
  await page.goto(`${address}#fleet`);
  await wait(SETTLE_MS);
  await picture(page, cdp, '1024-sunlight-page-fleet');
  await press(page, 'Settings');
  await page.getByRole('radio', { name: 'Deutsch' }).check();
  await wait(SETTLE_MS);
  await picture(page, cdp, '1024-sunlight-german');
  await page.close();
}

async function emergency(page, cdp, prefix) {
  await page.getByRole('button', { name: /^EMERGENCY STOP/ }).click();
  await page.getByRole('alertdialog').waitFor();
  await picture(page, cdp, `${prefix}-emergency-stop`);
  await page.keyboard.press('Escape');
}

async function call(method, path, body) {
  const answer = await fetch(new URL(`api/v1/${path}`, address), { method, headers: { 'content-type': 'application/json' }, body: body && JSON.stringify(body) });
  const text = await answer.text();
  if (!answer.ok) throw new Error(`${method} ${path}: ${answer.status} ${text}`);
  return text === '' ? null : JSON.parse(text);
}

const vehicles = async () => (await call('GET', 'vehicles')).vehicles;

async function until(what, done) {
  for (let k = 0; k < 240; k++) {
    if (done(await vehicles())) return;
    await wait(500);
  }
  throw new Error(`${what}: not within two minutes`);
}

/** Fences, then all in the air, then a wedge on a long way: something to be seen for as long as the pictures take. */
async function fly() {
  const zone = (name, kind, corners_m, floor_m, ceiling_m) => ({
    name, kind, outline: { shape: 'local_polygon', corners_m }, floor_m, ceiling_m, altitude_reference: 'origin', action: 'hold',
  });
  await until('ready', (all) => all.length > 0 && all.every((v) => v.ready_to_arm));
  await call('PUT', 'fences', {
    plan: {
      breach_return: null,
      zones: [
        zone('field', 'inclusion', [[-70, -90], [-70, 130], [130, 130], [150, 20], [130, -90]], null, 60),
        zone('mast', 'exclusion', [[60, 20], [60, 34], [74, 34], [74, 20]], 0, 45),
      ],
    },
  });
  await call('POST', 'commands', { targets: 'all', command: { command: 'take_off', height_m: 15 } });
  await until('in the air', (all) => all.every((v) => v.flight_state === 'holding'));
  await call('PUT', 'formation', {
    shape: 'wedge', spacing_m: 6, heading: { kind: 'auto' }, altitude_step_m: 1.5, rotation_deg: 0, scale: 1, arc_deg: null, layers: null,
    pitch_m: null, offsets: null, anchor: { kind: 'leader' }, control: 'slots', leader: 1, members: null,
  });
  // The cameras look ahead and down, so that what they see of the ground is near.
  for (const { id, payloads } of await vehicles()) {
    if (!payloads.some((one) => one.kind === 'gimbal')) continue;
    for (const command of [{ command: 'take_control' }, { command: 'angles', pitch_rad: -0.7, yaw_rad: 0 }]) {
      await call('POST', `vehicles/${id}/payloads/gimbal/command`, command);
    }
  }
  await wait(12_000);
  const round = [[40, -40], [100, -40], [100, 80], [0, 90], [-30, 60], [-30, -40]];
  const waypoints = Array.from({ length: 6 }, () => round).flat().map(([north_m, east_m]) => ({ north_m, east_m, down_m: -15 }));
  await call('PUT', 'formation/route', { route: { waypoints, speed_m_s: 3, corner_radius_m: 12 } });
}

async function console_(browser, name, width, height) {
  const page = await browser.newPage({ viewport: { width, height } });
  await page.goto(address);
  await page.getByRole('tab', { name: 'Payloads' }).click();
  await page.getByTestId('payload-panel').getByRole('button', { name: /^2 / }).click();
  await wait(2 * SETTLE_MS);
  await page.screenshot({ path: join(folder, `${name}.png`) });
  await page.close();
}

const MOVING = { frames: 45, every_ms: 400, shown_ms: 150, width: 1200, height: 752, scale: 0.75, quality: 20 };

const number = (value, bytes) => {
  const into = Buffer.alloc(bytes);
  into.writeUIntLE(value, 0, bytes);
  return into;
};

/** A chunk of a WebP file; of odd length it is padded. */
const chunk = (name, ...parts) => {
  const data = Buffer.concat(parts);
  return Buffer.concat([Buffer.from(name), number(data.length, 4), data, Buffer.alloc(data.length % 2)]);
};

/** What is drawn in a WebP file of one picture: its lossy or lossless chunk. */
function drawn(file) {
  for (let at = 12; at < file.length; at += 8 + file.readUInt32LE(at + 4) + (file.readUInt32LE(at + 4) % 2)) {
    const name = file.toString('latin1', at, at + 4);
    if (name === 'VP8 ' || name === 'VP8L') return chunk(name, file.subarray(at + 8, at + 8 + file.readUInt32LE(at + 4)));
  }
  throw new Error('no picture in a WebP file');
}

/** Pictures one after another, over and over: https://developers.google.com/speed/webp/docs/riff_container. */
function animation(files, width, height, shown_ms) {
  const size = [number(width - 1, 3), number(height - 1, 3)];
  const frames = files.map((file) => chunk('ANMF', number(0, 6), ...size, number(shown_ms, 3), number(2, 1), drawn(file)));
  const body = Buffer.concat([Buffer.from('WEBP'), chunk('VP8X', number(2, 4), ...size), chunk('ANIM', number(0, 6)), ...frames]);
  return Buffer.concat([Buffer.from('RIFF'), number(body.length, 4), body]);
}

/** The swarm on its route, faster than it flies. */
async function moving(browser) {
  const { frames, every_ms, shown_ms, width, height, scale, quality } = MOVING;
  const page = await browser.newPage({ viewport: { width, height }, colorScheme: 'dark' });
  const cdp = await page.context().newCDPSession(page);
  await page.goto(address);
  await page.waitForFunction(() => (window.__skein?.positions().length ?? 0) > 0);
  await wait(SETTLE_MS);
  const files = [];
  for (let k = 0; k < frames; k++) {
    const next = wait(every_ms);
    const { data } = await cdp.send('Page.captureScreenshot', { format: 'webp', quality, clip: { x: 0, y: 0, width, height, scale } });
    files.push(Buffer.from(data, 'base64'));
    await next;
  }
  const file = animation(files, width * scale, height * scale, shown_ms);
  writeFileSync(join(folder, 'flight.webp'), file);
  console.log(`flight.webp ${(file.length / 1000).toFixed(0)} kB`);
  await page.close();
}

const browser = await chromium.launch({
  executablePath: process.env.SKEIN_CHROMIUM,
  args: ['--enable-unsafe-swiftshader', '--no-sandbox'],
});
try {
  rmSync(pages, { recursive: true, force: true });
  mkdirSync(pages, { recursive: true });
  await fly();
  await wait(Number(seconds) * 1000);
  await moving(browser);
  await console_(browser, 'console', 1440, 900);
  await console_(browser, 'console-tablet', 820, 1180);
  for (const [width, height] of SIZES) {
    for (const colorScheme of ['light', 'dark']) {
      const page = await browser.newPage({ viewport: { width, height }, colorScheme });
      const cdp = await page.context().newCDPSession(page);
      const prefix = `${width}-${colorScheme}`;
      await page.goto(address);
      await page.waitForFunction(() => (window.__skein?.positions().length ?? 0) > 0);
      await wait(SETTLE_MS);
      await picture(page, cdp, `${prefix}-map`);
      await panels(page, cdp, prefix);
      await emergency(page, cdp, prefix);
      await maps(page, cdp, prefix);
      await pagesOf(page, cdp, prefix);
      await page.close();
    }
  }
  await settings(browser);
  for (const name of ['console', 'console-tablet']) total += statSync(join(folder, `${name}.png`)).size;
  console.log(`${(total / 1e6).toFixed(2)} MB together`);
} finally {
  await browser.close();
}
