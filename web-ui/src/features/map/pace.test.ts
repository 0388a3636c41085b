// When pictures come, on a clock of the test's own with a screen of 60 Hz.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Pace, stepMs } from './pace';

const SCREEN_MS = 1000 / 60;

beforeEach(() => {
  // Node has no screen: its animation frames are those of the clock that stands in.
  vi.stubGlobal('window', globalThis);
  vi.stubGlobal('requestAnimationFrame', (then: () => void) => setTimeout(then, SCREEN_MS - (performance.now() % SCREEN_MS)));
  vi.stubGlobal('cancelAnimationFrame', (id: number) => clearTimeout(id));
  vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout', 'setInterval', 'clearInterval', 'performance'] });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

function drawn(underWay: boolean): { pace: Pace; pictures: () => number } {
  let count = 0;
  const pace = new Pace(() => {
    count++;
    return underWay;
  });
  return { pace, pictures: () => count };
}

describe('pictures', () => {
  it('of what stands come with the news, and without any there are none', () => {
    const { pace, pictures } = drawn(false);
    const news = setInterval(pace.news, 100);
    vi.advanceTimersByTime(10_050);
    expect(pictures()).toBe(100);
    clearInterval(news);
    vi.advanceTimersByTime(10_000);
    expect(pictures()).toBe(100);
  });

  it('of what is under way come twenty times a second, however often there are news', () => {
    const { pace, pictures } = drawn(true);
    setInterval(pace.news, 100);
    setInterval(pace.news, 250);
    vi.advanceTimersByTime(10_050);
    expect(pictures()).toBeGreaterThanOrEqual(195);
    expect(pictures()).toBeLessThanOrEqual(201);
  });

  it('come as often as they should where that is no whole number of frames of the screen', () => {
    // A clock on which drawing takes its time.
    const now = performance.now.bind(performance);
    let taken = 0;
    vi.spyOn(performance, 'now').mockImplementation(() => now() + taken);
    let pictures = 0;
    const pace = new Pace(() => {
      pictures++;
      taken += 1.75;
      return true;
    });
    pace.soon();
    vi.advanceTimersByTime(10_000);
    const wanted = (10_000 + taken) / stepMs(1.75);
    expect(Math.abs(pictures - wanted)).toBeLessThan(4);
    vi.restoreAllMocks();
  });

  it('come for a hand with the next frame of the screen, and then in steps from there', () => {
    const { pace, pictures } = drawn(true);
    pace.soon();
    vi.advanceTimersByTime(20);
    expect(pictures()).toBe(1);
    pace.soon();
    pace.soon();
    vi.advanceTimersByTime(20);
    expect(pictures()).toBe(2);
    vi.advanceTimersByTime(20);
    expect(pictures()).toBe(2);
  });

  it('come at once where they must, and then not a second time', () => {
    const { pace, pictures } = drawn(false);
    pace.soon();
    pace.now();
    expect(pictures()).toBe(1);
    vi.advanceTimersByTime(1000);
    expect(pictures()).toBe(1);
  });

  it('end when it is stopped', () => {
    const { pace, pictures } = drawn(true);
    pace.now();
    pace.stop();
    pace.soon();
    pace.news();
    pace.now();
    vi.advanceTimersByTime(1000);
    expect(pictures()).toBe(1);
  });
});

it('what takes long to draw is drawn more seldom, but never seldomer than sixteen times a second', () => {
  expect(stepMs(0.1)).toBe(50);
  expect(stepMs(1.5)).toBe(50);
  expect(stepMs(1.75)).toBe(56);
  expect(stepMs(200)).toBe(62);
});
