// Where a recording is, from the clock in the frames; what is asked of it, and when the page believes it is there.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { ReplayChange, ReplayState, Timeline } from '../protocol/types';
import { RATES, Replay, positionOf, ratesWith } from './replay.svelte';

const BEGIN_US = 5_000_000;
const state = (over: Partial<ReplayState> = {}): ReplayState => ({
  file: 'a.mcap', node: 'alpha', begun_unix_s: 1_700_000_000, begin: BEGIN_US, duration_s: 100, position_s: 0, rate: 1, playing: false, jumps: 1, finished: true, indexed: false, ...over,
});
const WHOLE: Timeline = { complete: true, left_out: 0, marks: [10, 20, 30].map((position_s) => ({ position_s, severity: 'info', vehicle: null, who: null, text: 'x' })) };

/** A replay whose calls are answered by hand. */
function replay(timelines: (Timeline | Error)[] = []) {
  const asked: ReplayChange[] = [];
  const answers: ((error?: Error) => void)[] = [];
  const one = new Replay({
    change: (change) => {
      asked.push(change);
      return new Promise<void>((resolve, reject) => answers.push((error) => (error ? reject(error) : resolve())));
    },
    timeline: async () => {
      const next = timelines.shift() ?? WHOLE;
      if (next instanceof Error) throw next;
      return next;
    },
  });
  const answer = async (error?: Error): Promise<void> => {
    answers.shift()?.(error);
    await vi.advanceTimersByTimeAsync(0);
  };
  /** A frame of a moment. */
  const frame = (positionS: number, arrived = false): void => one.heard(BEGIN_US / 1000 + positionS * 1000, performance.now(), arrived);
  return { one, asked, answer, frame };
}

beforeEach(() => vi.useFakeTimers());
afterEach(() => vi.useRealTimers());

describe('the place in a recording', () => {
  it('follows from the clock in the frame', () => {
    expect(positionOf(state(), 5000)).toBe(0);
    expect(positionOf(state(), 47_500)).toBe(42.5);
    // Thirty seconds after a beginning within a millisecond.
    expect(positionOf(state({ begin: 5_000_900 }), 35_000)).toBe(30);
  });

  it('stays inside of it', () => {
    expect(positionOf(state(), 4999)).toBe(0);
    expect(positionOf(state(), 500_000)).toBe(100);
  });

  it('goes on where the clock begins again at zero', () => {
    // 49.7 days of running.
    const begin = (2 ** 32 - 4000) * 1000;
    expect(positionOf({ begin, duration_s: 100 }, 2 ** 32 - 4000)).toBe(0);
    expect(positionOf({ begin, duration_s: 100 }, 6000)).toBe(10);
    // ... and where it had begun again before the recording did.
    expect(positionOf({ begin: begin + 2 ** 32 * 1000, duration_s: 100 }, 6000)).toBeCloseTo(10, 6);
  });
});

describe('what the server says', () => {
  it('without a recording everything is as ever', () => {
    const { one } = replay();
    expect([one.on, one.pace, one.wallClockMs(0), one.wallNowMs()]).toEqual([false, 1, null, null]);
  });

  it('gives pace and time of day', () => {
    const { one, frame } = replay();
    one.take(state());
    expect([one.on, one.pace]).toEqual([true, 0]);
    one.take(state({ playing: true, rate: 5 }));
    expect(one.pace).toBe(5);
    frame(42);
    expect(one.wallNowMs()).toBe(1_700_000_042_000);
    expect(one.wallClockMs(BEGIN_US + 2_000_000)).toBe(1_700_000_002_000);
    expect(one.timeOfDay(42).getTime()).toBe(1_700_000_042_000);
  });

  it('tells another moment from going on, and another recording from both', () => {
    const { one } = replay();
    expect([
      state(), state({ playing: true }), state({ jumps: 2 }), state({ jumps: 1 }), state({ jumps: 1, position_s: 5 }), state({ file: 'b.mcap' }),
    ].map((next) => one.take(next))).toEqual(['same', 'same', 'moment', 'moment', 'same', 'recording']);
    one.leave();
    expect([one.on, one.pace, one.timeline.complete]).toEqual([false, 1, false]);
  });

  it('the timeline is asked for when there is one, and again until it has come', async () => {
    const { one } = replay([new Error('gone'), { complete: false, marks: [], left_out: 0 }]);
    one.take(state());
    await vi.advanceTimersByTimeAsync(5000);
    expect(one.timeline.complete).toBe(false);
    one.take(state({ indexed: true, jumps: 2 }));
    await vi.advanceTimersByTimeAsync(500);
    expect(one.timeline.complete).toBe(false);
    await vi.advanceTimersByTimeAsync(2000);
    expect(one.timeline.marks).toHaveLength(3);
  });
});

describe('going elsewhere', () => {
  it('is shown at once, and until its first frame has come', async () => {
    const { one, asked, answer, frame } = replay();
    one.take(state());
    frame(5);
    one.seek(60);
    expect([asked, one.positionS]).toEqual([[{ position_s: 60 }], 60]);
    frame(5);
    expect(one.positionS).toBe(60);
    await answer();
    frame(5);
    expect(one.positionS).toBe(60);
    one.take(state({ jumps: 2, position_s: 60 }));
    frame(60, true);
    frame(61);
    expect(one.positionS).toBe(61);
  });

  it('may be told by the stream before it is answered', async () => {
    const { one, answer, frame } = replay();
    one.take(state());
    one.seek(60);
    one.take(state({ jumps: 2, position_s: 60 }));
    frame(60, true);
    await answer();
    frame(61);
    expect(one.positionS).toBe(61);
  });

  it('of many keys in a row only the last place is gone to', async () => {
    const { one, asked, answer } = replay();
    one.take(state());
    for (let k = 0; k < 5; k++) one.step(1);
    expect([asked, one.positionS]).toEqual([[{ position_s: 1 }], 5]);
    await answer();
    expect(asked).toEqual([{ position_s: 1 }, { position_s: 5 }]);
  });

  it('stays inside of the recording, and is not believed for ever', async () => {
    const { one, asked, answer, frame } = replay();
    one.take(state());
    one.step(Infinity);
    await answer();
    one.step(-Infinity);
    await answer();
    expect(asked).toEqual([{ position_s: 100 }, { position_s: 0 }]);
    frame(50);
    one.seek(70);
    await answer();
    await vi.advanceTimersByTimeAsync(10_000);
    expect(one.positionS).toBe(50);
  });

  it('that is refused says why, and is not gone to', async () => {
    const { one, answer, frame } = replay();
    one.take(state());
    frame(5);
    one.seek(60);
    await answer(new Error('it has ended'));
    expect([one.problem, one.positionS]).toEqual(['the replay did not obey: it has ended', 5]);
    one.setRate(2);
    await answer();
    expect(one.problem).toBe('');
  });

  it('to the marks, just behind them', async () => {
    const { one, asked, answer } = replay();
    one.take(state({ indexed: true }));
    await vi.advanceTimersByTimeAsync(0);
    one.toMark(1);
    await answer();
    one.toMark(1);
    await answer();
    one.toMark(-1);
    await answer();
    one.toMark(-1);
    expect(asked.map(({ position_s }) => position_s)).toEqual([10.05, 20.05, 10.05, 0]);
  });

  it('is none where nothing is recorded', () => {
    const { one, asked } = replay();
    one.seek(3);
    one.toggle();
    expect(asked).toEqual([]);
  });
});

describe('the paces', () => {
  it('are those that are offered, and the one that it has', () => {
    expect(ratesWith(5)).toEqual(RATES);
    expect(ratesWith(3)).toEqual([0.25, 0.5, 1, 2, 3, 5, 10, 20]);
  });
});
