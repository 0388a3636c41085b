import { describe, expect, it } from 'vitest';
import { faultText, qualityOf } from './links';
import type { LinkCondition } from './links';

const good: LinkCondition = { staleness: 'live', lossPercent: 0, roundTripMs: 4, nodeRoundTripMs: NaN };

describe('qualityOf', () => {
  it.each<[Partial<LinkCondition>, number, string]>([
    [{}, 0, ''],
    [{ roundTripMs: NaN }, 0, ''],
    [{ lossPercent: 5 }, 1, 'loss 5 %'],
    [{ lossPercent: 20 }, 2, 'loss 20 %'],
    [{ roundTripMs: 150 }, 1, 'round trip 150 ms'],
    [{ nodeRoundTripMs: 612.4 }, 2, 'round trip 612 ms'],
    [{ staleness: 'delayed' }, 1, 'nothing heard for 1 s'],
    [{ staleness: 'stale', lossPercent: 50 }, 2, 'nothing heard for 3 s'],
    [{ staleness: 'lost', lossPercent: 50 }, 3, 'link lost'],
  ])('%j is %d: %s', (change, quality, text) => {
    expect(qualityOf({ ...good, ...change })).toBe(quality);
    expect(faultText({ ...good, ...change })).toBe(text);
  });
});
