import { afterEach, describe, expect, it } from 'vitest';
import { toField, units } from '../language/units.svelte';
import { entryOf } from './numberEntry';

const HEIGHT = { min: 1, max: 120 };
afterEach(() => {
  units.name = 'metric';
});

describe('a number that is typed', () => {
  it('is taken as it is where it is allowed', () => {
    expect(entryOf(12.5, HEIGHT, 'height')).toEqual({ value: 12.5, stands: false });
    expect(entryOf(90, { min: -180, max: 180 })).toEqual({ value: 90, stands: false });
  });

  it('that is too much gives way at once', () => {
    expect(entryOf(500, HEIGHT, 'height')).toEqual({ value: 120, stands: false });
    expect(entryOf(-30, { min: -20, max: 20 }, 'height')).toEqual({ value: -20, stands: false });
  });

  it('that is too little may be the beginning of more, and counts as the least meanwhile', () => {
    expect(entryOf(0, { min: 0.5, max: 20 }, 'speed')).toEqual({ value: 0.5, stands: true });
    units.name = 'aviation';
    expect(entryOf(2, HEIGHT, 'height')).toEqual({ value: 1, stands: true });
    expect(entryOf(20, HEIGHT, 'height')).toEqual({ value: expect.closeTo(6.096, 12), stands: false });
  });

  it('is in the units of the page, and what has none is not', () => {
    units.name = 'aviation';
    expect(toField('height', entryOf(1000, HEIGHT, 'height').value)).toBe(393.7);
    expect(entryOf(30, { min: -180, max: 180 })).toEqual({ value: 30, stands: false });
  });
});
