// The page in a real Chromium against the real program. Nothing here stands in for either.
//
// Journeys that a user cannot do without are flown in every run. What is tagged `@long` (further widths, themes, languages and units, long
// flights, two hundred vehicles) runs with `cargo xtask test ui`, and with `--all`.
import { defineConfig } from '@playwright/test';

// Only a failure ever takes so long: the browser draws on the processor, which other programs may keep busy.
const SLOW_MACHINE_MS = 45_000;

export default defineConfig({
  testDir: '.',
  outputDir: '../../test-results/ui',
  // Every file starts a program with its own simulated vehicles; two at a time would starve each other on two cores.
  workers: 1,
  timeout: 240_000,
  expect: { timeout: SLOW_MACHINE_MS },
  // One that passes only when tried again is told as unsteady; `deploy/xtask/src/report.rs` says how many are no noise any more.
  retries: 1,
  forbidOnly: !!process.env.CI,
  reporter: [['list']],
  use: {
    viewport: { width: 1440, height: 900 },
    colorScheme: 'dark',
    actionTimeout: SLOW_MACHINE_MS,
    trace: 'retain-on-failure',
    screenshot: 'only-on-failure',
    launchOptions: {
      executablePath: process.env.SKEIN_CHROMIUM ?? '/usr/bin/chromium',
      args: [
        '--no-sandbox',
        '--disable-gpu',
        '--disable-quic',
        '--no-first-run',
        '--disable-background-networking',
        '--disable-component-update',
        '--disable-sync',
      ],
    },
  },
});
