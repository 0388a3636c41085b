// What the links carry in a second, from two answers of the program that only count. Must never call a counter that began anew a rate. Pure.

import type { EndpointReport, LinkReport } from '../../protocol/types';

const MICROSECONDS = 1e6;

/** What goes over one endpoint, per second; null as long as there is nothing to compare with. */
export type EndpointRates = { inBytes: number; inFrames: number; outBytes: number; outFrames: number } | null;

export type EndpointLine = EndpointReport & { rates: EndpointRates };

/** Every endpoint with its rates since the answer before. */
export function endpointLines(before: LinkReport | null, now: LinkReport): EndpointLine[] {
  const seconds = before === null ? 0 : (now.time - before.time) / MICROSECONDS;
  return now.endpoints.map((one) => {
    const earlier = before?.endpoints.find(({ name }) => name === one.name);
    return { ...one, rates: earlier && seconds > 0 ? rates(earlier, one, seconds) : null };
  });
}

function rates(before: EndpointReport, now: EndpointReport, seconds: number): EndpointRates {
  const perS = (key: 'bytes_in' | 'frames_in' | 'bytes_out' | 'frames_out'): number => (now[key] - before[key]) / seconds;
  const found = { inBytes: perS('bytes_in'), inFrames: perS('frames_in'), outBytes: perS('bytes_out'), outFrames: perS('frames_out') };
  // The node was started anew in between.
  return Object.values(found).some((value) => value < 0) ? null : found;
}
