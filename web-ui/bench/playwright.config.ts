// The dashboard measured in a real Chromium against the real program. Prints figures and judges nothing.
import { defineConfig } from '@playwright/test';
import e2e from '../e2e/playwright.config';

export default defineConfig({
  ...e2e,
  testDir: '.',
  testMatch: ['bench.ts', 'video.ts'],
  timeout: 1_800_000,
  retries: 0,
  reporter: [['line']],
  use: { ...e2e.use, trace: 'off', screenshot: 'off' },
});
