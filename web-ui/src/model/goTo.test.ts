import { describe, expect, it } from 'vitest';
import { commandTo, waysTo } from './goTo.svelte';

const one = { id: 3, north: 10, east: 20, upM: 12 };

describe('waysTo', () => {
  it('leads one vehicle to the place itself', () => {
    expect(waysTo([one], { north: -5, east: 7 }, 30)).toEqual([{ id: 3, from: { north: 10, east: 20 }, to: { north: -5, east: 7 }, upM: 30 }]);
  });

  it('keeps the arrangement of several, in height as well', () => {
    const ways = waysTo([one, { id: 4, north: 14, east: 20, upM: 16 }], { north: 100, east: 0 }, 20);
    expect(ways.map((way) => [way.to.north, way.to.east, way.upM])).toEqual([[98, 0, 18], [102, 0, 22]]);
  });

  it('has no way for nobody', () => {
    expect(waysTo([], { north: 1, east: 1 }, 10)).toEqual([]);
  });
});

describe('commandTo', () => {
  it('counts down from the origin', () => {
    const [way] = waysTo([one], { north: -5, east: 7 }, 30);
    expect(commandTo(way!)).toEqual({ command: 'go_to', position: { north_m: -5, east_m: 7, down_m: -30 }, yaw_rad: null, speed_m_s: null });
  });
});
