// In sight or not: the browser's observer is stood in for, time is the test's.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { watchSight } from './sight';

let report: (isIntersecting: boolean) => void;
let page: EventTarget & { hidden: boolean };

beforeEach(() => {
  vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout'] });
  page = Object.assign(new EventTarget(), { hidden: false });
  vi.stubGlobal('document', page);
  vi.stubGlobal('IntersectionObserver', class {
    constructor(then: (entries: { isIntersecting: boolean }[]) => void) {
      report = (isIntersecting) => then([{ isIntersecting: !isIntersecting }, { isIntersecting }]);
    }
    observe(): void {}
    disconnect(): void {
      report = () => {};
    }
  });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

function watched() {
  const said: boolean[] = [];
  return { said, end: watchSight({} as Element, (inSight) => said.push(inSight)) };
}

function hide(hidden: boolean): void {
  page.hidden = hidden;
  page.dispatchEvent(new Event('visibilitychange'));
}

describe('what is in sight', () => {
  it('is on the screen', () => {
    const { said } = watched();
    report(false);
    expect(said).toEqual([]);
    report(true);
    report(true);
    expect(said).toEqual([true]);
    report(false);
    vi.advanceTimersByTime(400);
    expect(said).toEqual([true, false]);
  });

  it('is in a tab that is looked at', () => {
    const { said } = watched();
    report(true);
    hide(true);
    vi.advanceTimersByTime(400);
    hide(false);
    expect(said).toEqual([true, false, true]);
    hide(true);
    report(false);
    vi.advanceTimersByTime(400);
    hide(false);
    expect(said).toEqual([true, false, true, false]);
  });

  it('does not leave while one scrolls past', () => {
    const { said } = watched();
    report(true);
    report(false);
    vi.advanceTimersByTime(300);
    report(true);
    vi.advanceTimersByTime(1000);
    expect(said).toEqual([true]);
  });

  it('is not watched any more in the end', () => {
    const { said, end } = watched();
    report(true);
    report(false);
    end();
    hide(true);
    vi.advanceTimersByTime(1000);
    expect(said).toEqual([true]);
  });
});
