import { describe, expect, it } from 'vitest';
import { ladderTop } from './paintLadder';

describe('ladderTop', () => {
  it.each([
    [0, 10],
    [9.5, 10],
    [9.6, 20],
    [48, 50 * 2],
    [47, 50],
    [940, 1000],
  ])('the highest at %d m: the scale ends at %d m', (highest, expected) => {
    expect(ladderTop(highest)).toBe(expected);
  });
});
