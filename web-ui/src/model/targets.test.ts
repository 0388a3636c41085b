import { describe, expect, it } from 'vitest';
import { Targets } from './targets.svelte';

const fleet = (): Targets => new Targets(() => [{ id: 1 }, { id: 2 }, { id: 3 }]);

describe('whom a button acts on', () => {
  it('is nobody where nothing is selected, but for what brings all to safety', () => {
    const targets = fleet();
    expect(targets.reach('nobody')).toEqual({ ids: [], wire: { vehicles: [] }, all: false });
    expect(targets.reach('all')).toEqual({ ids: [1, 2, 3], wire: 'all', all: true });
  });

  it('is what is selected, for every button alike', () => {
    const targets = fleet();
    targets.add([3, 1]);
    const two = { ids: [1, 3], wire: { vehicles: [1, 3] }, all: false };
    expect([targets.reach('nobody'), targets.reach('all')]).toEqual([two, two]);
    targets.clear();
    expect(targets.reach('nobody').ids).toEqual([]);
  });

  it('is told as all where every vehicle is selected, and a lost one stays selected', () => {
    const targets = fleet();
    targets.only([1, 2, 3]);
    expect(targets.reach('nobody').all).toBe(true);
    targets.only([1, 2, 9]);
    expect(targets.reach('nobody')).toEqual({ ids: [1, 2, 9], wire: { vehicles: [1, 2, 9] }, all: false });
  });

  it('is one vehicle alone or not', () => {
    const targets = fleet();
    expect(targets.isOnly(2)).toBe(false);
    targets.toggle(2);
    expect([targets.isOnly(2), targets.isOnly(1)]).toEqual([true, false]);
    targets.toggle(1);
    expect(targets.isOnly(2)).toBe(false);
  });
});

describe('whom the map marks', () => {
  it('is whom the button before the finger acts on, and the targets again after it', () => {
    const targets = fleet();
    targets.only([2]);
    targets.point([1, 2, 3]);
    expect([...targets.marked]).toEqual([1, 2, 3]);
    targets.point(null);
    expect([...targets.marked]).toEqual([2]);
  });
});
