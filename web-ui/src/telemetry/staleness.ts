// How old what we know of a vehicle is, in words. The server's clock decides; the browser only adds the time since the frame came.

export type Staleness = 'live' | 'delayed' | 'stale' | 'lost';

/** Younger than this is live. */
export const LIVE_BELOW_MS = 1000;
/** Older than this is stale: the values are shown hollow, with their age. */
export const STALE_FROM_MS = 3000;
/** Older than this counts as lost even where the server has not said so. */
export const LOST_FROM_MS = 10_000;

/** Class of a vehicle by age; the server's word that the link is lost outranks the age. */
export function classify(ageMs: number, linkConnected: boolean): Staleness {
  if (!linkConnected || ageMs >= LOST_FROM_MS) return 'lost';
  if (ageMs >= STALE_FROM_MS) return 'stale';
  if (ageMs >= LIVE_BELOW_MS) return 'delayed';
  return 'live';
}

/** An age for people: tenths below ten seconds, then seconds, minutes, hours. */
export function ageText(ageMs: number): string {
  const seconds = Math.max(0, ageMs) / 1000;
  if (seconds < 10) return `${seconds.toFixed(1)} s`;
  if (seconds < 120) return `${Math.floor(seconds)} s`;
  if (seconds < 7200) return `${Math.floor(seconds / 60)} min`;
  return `${Math.floor(seconds / 3600)} h`;
}
