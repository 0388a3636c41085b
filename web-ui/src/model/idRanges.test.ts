import { describe, expect, it } from 'vitest';
import { idRanges } from './idRanges';

describe('idRanges', () => {
  it.each([
    [[], ''],
    [[4], '4'],
    [[1, 2], '1, 2'],
    [[1, 2, 3], '1–3'],
    [[1, 2, 3, 7, 9, 10, 20, 21, 22], '1–3, 7, 9, 10, 20–22'],
  ])('%o', (ids, expected) => {
    expect(idRanges(ids)).toBe(expected);
  });
});
