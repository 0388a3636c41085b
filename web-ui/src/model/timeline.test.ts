import { describe, expect, it } from 'vitest';
import type { Severity, TimelineMark } from '../protocol/types';
import { clustersOf, isDone, markAfter, markAt, markBefore } from './timeline';

const mark = (position_s: number, severity: Severity = 'info', who: string | null = null): TimelineMark => ({ position_s, severity, vehicle: null, who, text: `at ${position_s}` });

describe('marks on a line', () => {
  it('are put together where they would lie over each other, the worst of them for all', () => {
    const found = clustersOf([mark(0), mark(1, 'warning'), mark(1.9), mark(50, 'critical'), mark(100)], 100, 1000, 20);
    expect(found.map(({ at, marks, worst }) => [at, marks.length, worst])).toEqual([[0, 3, 'warning'], [500, 1, 'critical'], [1000, 1, 'info']]);
  });

  it('are counted from the first of a cluster: a row of near ones is not all one', () => {
    const found = clustersOf([0, 1, 2, 3, 4, 5].map((s) => mark(s)), 100, 1000, 25);
    expect(found.map(({ at, marks }) => [at, marks.length])).toEqual([[0, 3], [30, 3]]);
  });

  it('never stand out of it, and never hide a mark', () => {
    const found = clustersOf([mark(-1), mark(200)], 100, 300, 20);
    expect(found.map(({ at }) => at)).toEqual([0, 300]);
    const many = Array.from({ length: 5000 }, (_, k) => mark(k / 10));
    const all = clustersOf(many, 500, 640, 26);
    expect(all.length).toBeLessThanOrEqual(25);
    expect(all.reduce((sum, { marks }) => sum + marks.length, 0)).toBe(5000);
    expect(clustersOf([mark(0), mark(0)], 0, 100, 20)).toHaveLength(1);
  });

  it('are somebody\'s doing also where nobody says whose', () => {
    expect([mark(0), mark(0, 'info', ''), mark(0, 'info', 'Ann')].map(isDone)).toEqual([false, true, true]);
  });
});

describe('from a moment on', () => {
  const marks = [mark(5), mark(10), mark(10), mark(20)];

  it('the next and the last before it, but not the one that is stood at', () => {
    expect([markAfter(marks, 0), markAfter(marks, 5.05), markAfter(marks, 10.05), markAfter(marks, 20.05)].map((one) => one?.position_s)).toEqual([5, 10, 20, undefined]);
    expect([markBefore(marks, 30), markBefore(marks, 20.05), markBefore(marks, 10.05), markBefore(marks, 5.05)].map((one) => one?.position_s)).toEqual([20, 10, 5, undefined]);
  });

  it('going on does not keep one at the same mark', () => {
    expect(markBefore(marks, 10.9, 1)?.position_s).toBe(5);
    expect(markBefore(marks, 11.5, 1)?.position_s).toBe(10);
  });

  it('what has just happened', () => {
    expect([markAt(marks, 4, 6), markAt(marks, 10, 6), markAt(marks, 15, 6), markAt(marks, 17, 6)].map((one) => one?.position_s)).toEqual([undefined, 10, 10, undefined]);
  });
});
