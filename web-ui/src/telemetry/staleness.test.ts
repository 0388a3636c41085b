import { describe, expect, it } from 'vitest';
import { ageText, classify } from './staleness';

describe('classify', () => {
  it.each([
    [0, 'live'],
    [999, 'live'],
    [1000, 'delayed'],
    [2999, 'delayed'],
    [3000, 'stale'],
    [9999, 'stale'],
    [10_000, 'lost'],
  ] as const)('%d ms on a link that stands is %s', (age, expected) => {
    expect(classify(age, true)).toBe(expected);
  });

  it("the server's word that the link is lost outranks a young age", () => {
    expect(classify(10, false)).toBe('lost');
  });
});

describe('ageText', () => {
  it.each([
    [-5, '0.0 s'],
    [340, '0.3 s'],
    [9940, '9.9 s'],
    [61_000, '61 s'],
    [150_000, '2 min'],
    [7_300_000, '2 h'],
  ])('%d ms is %s', (age, expected) => {
    expect(ageText(age)).toBe(expected);
  });
});
