// When a picture is frozen, how many come in a second, how long they were under way, what is lost.

import { describe, expect, it } from 'vitest';
import { DelayLog, LossLog, PictureLog, isFrozen, together } from './pictureLog';

function logged(count: number, everyMs: number, fromMs = 0): PictureLog {
  const log = new PictureLog();
  for (let k = 0; k < count; k++) log.note(fromMs + k * everyMs);
  return log;
}

describe('a frozen picture', () => {
  it('is one that has been shown for more than half a second, or for three periods where they are longer', () => {
    expect([isFrozen(500, 33), isFrozen(501, 33), isFrozen(501, null)]).toEqual([false, true, true]);
    expect([isFrozen(3000, 1000), isFrozen(3001, 1000)]).toEqual([false, true]);
  });

  it('is none before the first picture', () => {
    expect(new PictureLog().frozen(1e6)).toBe(false);
  });

  it('is told by how pictures mostly came, whatever pauses there were', () => {
    const log = logged(5, 33);
    log.note(10_000);
    for (let k = 1; k < 5; k++) log.note(10_000 + 33 * k);
    expect(log.periodMs).toBe(33);
    expect([log.frozen(10_632), log.frozen(10_633)]).toEqual([false, true]);
    const slow = logged(5, 1000);
    expect([slow.frozen(7000), slow.frozen(7001)]).toEqual([false, true]);
  });
});

describe('the rate', () => {
  it('is that of the last three seconds', () => {
    const log = logged(301, 1000 / 30);
    expect(log.rateHz(10_000)).toBeCloseTo(30, 0);
    expect(log.rateHz(11_500)).toBeCloseTo(15, 0);
    expect(log.rateHz(13_500)).toBe(0);
    expect(log.shown).toBe(301);
  });

  it('is right from the second picture on', () => {
    expect(new PictureLog().rateHz(0)).toBe(0);
    expect(logged(1, 33).rateHz(10)).toBe(0);
    expect(logged(16, 1000 / 30).rateHz(500)).toBeCloseTo(30, 5);
  });

  it('holds no more than it needs', () => {
    const log = logged(100_000, 10);
    expect(log.rateHz(999_990)).toBeLessThanOrEqual(100);
    expect(log.periodMs).toBe(10);
  });
});

describe('from glass to glass', () => {
  it('are the half and all but one in a hundred of the last ten seconds', () => {
    const log = new DelayLog();
    expect(log.of(0)).toBeNull();
    log.note(0, 9999);
    for (let k = 1; k <= 100; k++) log.note(5000 + k, k);
    expect(log.of(10_000)).toEqual({ p50Ms: 50, p99Ms: 99 });
    expect(log.list(10_000)).toHaveLength(100);
    expect(log.of(20_000)).toBeNull();
    log.note(20_000, 5);
    log.clear();
    expect(log.list(20_000)).toEqual([]);
  });

  it('is not what cannot be', () => {
    const log = new DelayLog();
    log.note(0, 2e9);
    log.note(0, -3);
    expect(log.of(1)).toEqual({ p50Ms: -3, p99Ms: -3 });
  });
});

describe('loss', () => {
  it('is the share of what did not come, in the last ten seconds', () => {
    const log = new LossLog();
    expect(log.share).toBe(0);
    log.note(0, 100, 0);
    log.note(1000, 190, 10);
    expect(log.share).toBeCloseTo(0.1);
    for (let k = 2; k <= 12; k++) log.note(1000 * k, 190 + 100 * k, 10);
    expect(log.share).toBe(0);
  });

  it('begins anew with another connection', () => {
    const log = new LossLog();
    log.note(0, 100, 50);
    log.note(1000, 10, 0);
    expect(log.share).toBe(0);
  });

  it('of two parts of the way is not their sum', () => {
    expect([together(0, 0.1), together(0.5, 0.5), together(1, 0.3)].map((share) => Number(share.toFixed(6)))).toEqual([0.1, 0.75, 1]);
  });
});
