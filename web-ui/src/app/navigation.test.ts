import { describe, expect, it } from 'vitest';
import { PAGES, pageIn, pageOf } from './navigation.svelte';

describe('the page in the address', () => {
  it('is read, and the map stands for whatever is not known', () => {
    expect(pageOf('#preflight')).toEqual({ page: 'preflight', vehicle: null });
    expect(pageOf('#video')).toEqual({ page: 'video', vehicle: null });
    expect(pageOf('#fleet')).toEqual({ page: 'fleet', vehicle: null });
    expect(pageOf('#vehicle/12')).toEqual({ page: 'vehicle', vehicle: 12 });
    expect(pageOf('#vehicle/12/parameters')).toEqual({ page: 'parameters', vehicle: 12 });
    expect(pageOf('#vehicle/12/logs')).toEqual({ page: 'logs', vehicle: 12 });
    for (const hash of ['', '#', '#map', '#nowhere', '#vehicle/', '#vehicle/x', '#vehicle/1234567', '#vehicle/1/nowhere', '#vehicle/parameters', '#vehicle/logs', '#vehicle/1/logs/0']) {
      expect(pageOf(hash)).toEqual({ page: 'map', vehicle: null });
    }
  });
});

describe('of a recorded flight', () => {
  it('only the pages are there that show what is recorded', () => {
    expect(PAGES.filter((page) => pageIn(true, page) === page)).toEqual(['map', 'fleet', 'alerts']);
    expect(pageIn(true, 'video')).toBe('map');
    expect(pageIn(true, 'parameters')).toBe('vehicle');
    expect(pageIn(true, 'logs')).toBe('vehicle');
    for (const page of PAGES) expect(pageIn(false, page)).toBe(page);
  });
});
