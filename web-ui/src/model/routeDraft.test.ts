import { describe, expect, it } from 'vitest';
import { RouteDraft } from './routeDraft.svelte';

describe('RouteDraft', () => {
  it('is flown at the height that was known with its first point', () => {
    let height: number | null = 12;
    const draft = new RouteDraft(() => height);
    draft.add({ north: 0, east: 0 });
    height = 30;
    draft.add({ north: 3, east: 4 });
    expect(draft.lengthM).toBe(5);
    expect(draft.route().waypoints).toEqual([{ north_m: 0, east_m: 0, down_m: -12 }, { north_m: 3, east_m: 4, down_m: -12 }]);
    draft.clear();
    expect(draft.heightOrStartM).toBe(30);
  });

  it('moves and takes away points', () => {
    const draft = new RouteDraft(() => null);
    draft.addTyped();
    draft.addTyped();
    draft.move(0, { north: 1, east: 2 });
    draft.remove(1);
    expect(draft.waypoints).toEqual([{ north: 1, east: 2 }]);
    expect(draft.route().waypoints[0]!.down_m).toBe(-10);
  });
});
