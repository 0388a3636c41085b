// What is said of the logs that an autopilot keeps itself, and in which order they are listed. Pure.
// Must never guess: a reason that is not known here is shown as the server says it.

import { t } from '../../language/language.svelte';
import { ApiError } from '../../protocol/rest';
import type { AutopilotLog, LogFetch, Refusal } from '../../protocol/types';
import { refusalText } from '../../protocol/words';
import { bytesText } from '../video/videoWords';

// The node gives these reasons in words. The two that are met in use are said in the language of the page.
const ARMED = /\bit is armed\b/;
const BUSY = /\ba log of it is being fetched\b/;

/** The newest first; those without a time at the end. */
export function newestFirst(logs: readonly AutopilotLog[]): AutopilotLog[] {
  return [...logs].sort((a, b) => (b.written_unix_s ?? 0) - (a.written_unix_s ?? 0) || b.number - a.number);
}

/** Whether a log is still on its way. */
export function isUnderWay(fetch: LogFetch | null): fetch is LogFetch {
  return fetch !== null && fetch.end === null;
}

/** How much of it is there, 0 to 1. */
export function shareOf({ log, received_bytes: received }: LogFetch): number {
  return log.size_bytes > 0 ? Math.min(1, received / log.size_bytes) : 1;
}

/** `92 kB of 200 kB`. */
export function receivedText({ log, received_bytes: received }: LogFetch): string {
  return t('{received} of {size}', { received: bytesText(received), size: bytesText(log.size_bytes) });
}

/** How the fetching of a log stands, or how it ended. */
export function fetchText({ log, end }: LogFetch): string {
  const of = { number: log.number, size: bytesText(log.size_bytes) };
  if (end === null) return t('Fetching log {number}', of);
  if (end.end === 'fetched') return t('Log {number} was fetched, {size}', of);
  const why = ARMED.test(end.why) ? t('the vehicle was armed') : end.why;
  return t('Log {number} was not fetched: {why}', { ...of, why });
}

/** Why the logs were not listed, or the fetching of one was not begun. */
export function errorText(error: ApiError): string {
  const fact = error.detail as Partial<Refusal> | null;
  if (fact === null || typeof fact !== 'object' || typeof fact.reason !== 'string') return error.message;
  if (ARMED.test(error.message)) return t('the vehicle is armed');
  return BUSY.test(error.message) ? t('another log of it is being fetched') : refusalText(fact as Refusal);
}
