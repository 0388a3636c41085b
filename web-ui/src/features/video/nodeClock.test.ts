import { describe, expect, it } from 'vitest';
import { NodeClock } from './nodeClock';

describe("the node's clock", () => {
  it('is not known before a ping was answered', () => {
    const clock = new NodeClock();
    expect([clock.nodeMs(1000), clock.tripMs]).toEqual([null, null]);
  });

  it('is what the answer says in the middle of its way', () => {
    const clock = new NodeClock();
    clock.take(100, 120, 5_000_000);
    expect(clock.nodeMs(110)).toBe(5000);
    expect(clock.nodeMs(1110)).toBe(6000);
    expect(clock.tripMs).toBe(20);
  });

  it('is taken from the quickest of the last ten', () => {
    const clock = new NodeClock();
    // The true offset is 7000 ms; what takes long takes it on the way back.
    const trip = (sent: number, there: number, back: number) => clock.take(sent, sent + there + back, (sent + there + 7000) * 1000);
    trip(0, 5, 95);
    expect(clock.nodeMs(0)).toBeCloseTo(6955, 6);
    trip(200, 5, 5);
    expect(clock.nodeMs(0)).toBeCloseTo(7000, 6);
    for (let k = 0; k < 9; k++) trip(400 + 200 * k, 5, 35);
    expect(clock.nodeMs(0)).toBeCloseTo(7000, 6);
    // With the eleventh it is forgotten: a clock that drifts is followed.
    trip(4000, 5, 35);
    expect(clock.nodeMs(0)).toBeCloseTo(6985, 6);
  });

  it('takes no answer from before the question, and none without a time', () => {
    const clock = new NodeClock();
    clock.take(100, 90, 5_000_000);
    clock.take(100, 110, NaN);
    expect(clock.nodeMs(0)).toBeNull();
  });
});
