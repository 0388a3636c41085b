// The page for a long time in a real Chromium, with the real program. SKEIN_SOAK_S says for how long, in seconds.
import { defineConfig } from '@playwright/test';
import e2e from '../e2e/playwright.config';
import { SOAK_S } from './soakLength';

/** In an hour something else on the machine takes it for itself once: that is no fault of the page. */
const PATIENCE_MS = 60_000;
/** For start, the round that is not counted, the last turn and the end. */
const AROUND_S = 1200;

export default defineConfig({
  ...e2e,
  testDir: '.',
  testMatch: 'soak.ts',
  timeout: (SOAK_S + AROUND_S) * 1000,
  // An hour is not tried again.
  retries: 0,
  expect: { timeout: PATIENCE_MS },
  // What a trace would hold grows, and is held in the page.
  use: { ...e2e.use, trace: 'off', actionTimeout: PATIENCE_MS },
});
