import { describe, expect, it } from 'vitest';
import type { EndpointReport, LinkReport } from '../../protocol/types';
import { endpointLines } from './linkRates';

const endpoint = (name: string, bytes_in: number, frames_in: number): EndpointReport => ({
  name, address: null, bytes_in, frames_in, bytes_out: bytes_in / 2, frames_out: frames_in / 2, damaged: 0, foreign: 0, unadopted: 0, dropped: 0,
});
const report = (seconds: number, ...endpoints: EndpointReport[]): LinkReport => ({ time: seconds * 1e6, endpoints, vehicles: [] });

describe('rates of endpoints', () => {
  it('follow from two answers', () => {
    const [one] = endpointLines(report(10, endpoint('sitl', 1000, 10)), report(12, endpoint('sitl', 5000, 50)));
    expect(one!.rates).toEqual({ inBytes: 2000, inFrames: 20, outBytes: 1000, outFrames: 10 });
  });

  it('are not known at first, for a new endpoint, nor over a restart', () => {
    expect(endpointLines(null, report(1, endpoint('a', 1, 1)))[0]!.rates).toBeNull();
    expect(endpointLines(report(1, endpoint('a', 1, 1)), report(2, endpoint('b', 5, 5)))[0]!.rates).toBeNull();
    expect(endpointLines(report(1, endpoint('a', 900, 9)), report(2, endpoint('a', 5, 1)))[0]!.rates).toBeNull();
    expect(endpointLines(report(5, endpoint('a', 1, 1)), report(2, endpoint('a', 5, 5)))[0]!.rates).toBeNull();
  });
});
