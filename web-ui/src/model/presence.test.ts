import { describe, expect, it } from 'vitest';
import { ASK_MS, IN_USE_MS, everyMs, presence } from './presence.svelte';

describe('presence', () => {
  it('whoever touches the page is there, and is asked before the time is over', () => {
    expect(presence(0, true)).toBe('here');
    expect(presence(IN_USE_MS - ASK_MS, true)).toBe('here');
    expect(presence(IN_USE_MS - ASK_MS + 1, true)).toBe('asked');
    expect(presence(IN_USE_MS + 1, true)).toBe('away');
  });

  it('nobody is before a page that is not seen', () => {
    expect(presence(0, false)).toBe('away');
  });

  it('signs of life come several times within the time after which vehicles react, and not all the time', () => {
    expect(everyMs(20)).toBe(5000);
    expect(everyMs(8)).toBe(2000);
    expect(everyMs(1)).toBe(1000);
    expect(everyMs(null)).toBe(5000);
  });
});
