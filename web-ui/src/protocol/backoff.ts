// How long to wait before the next attempt to reach the server. Pure: the random number comes in.

/** Waits in ms by number of failed attempts; the last one repeats. */
export const WAITS_MS: readonly number[] = [250, 500, 1000, 2000, 4000];

/** Wait before attempt number `failures` (0 = first retry), spread by up to a fifth so that many pages do not come at once. */
export function waitMs(failures: number, random: number): number {
  const base = WAITS_MS[Math.min(failures, WAITS_MS.length - 1)] ?? 4000;
  return base * (0.9 + 0.2 * random);
}
