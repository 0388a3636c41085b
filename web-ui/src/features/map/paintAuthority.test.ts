// Whom the map marks as being under another's control, and what it takes to draw it.

import { describe, expect, it } from 'vitest';
import type { VehicleControl } from '../../protocol/types';
import type { Fleet } from '../../telemetry/fleet';
import { HeldCache, heldByOthers } from './heldByOthers';
import { paintAuthority } from './paintAuthority';
import type { Palette } from './palette';

const ME = 'a';
const control = (vehicle: number, id: string, heard = true): VehicleControl => ({ vehicle, console: { id, name: 'Anna' }, since: 0, is_heard: heard, requests: [] });
const known = (...all: VehicleControl[]) => new Map(all.map((one) => [one.vehicle, one]));

describe('who is marked', () => {
  it('is under the control of another console, also of one with the same name', () => {
    expect([...heldByOthers(known(control(1, ME), control(2, 'b'), control(3, 'c', false)), ME)]).toEqual([[2, 'heard'], [3, 'silent']]);
  });

  it('is nobody where nobody has anything, or all is ours', () => {
    expect(heldByOthers(known(), ME).size).toBe(0);
    expect(heldByOthers(known(control(1, ME), control(2, ME, false)), ME).size).toBe(0);
  });

  it('is worked out again only when the node has said so anew', () => {
    let said = known(control(1, 'b'));
    const cache = new HeldCache(() => said, ME);
    const first = cache.get();
    expect(cache.get()).toBe(first);
    said = known(control(1, ME), control(2, 'b'));
    expect([...cache.get().keys()]).toEqual([2]);
    said = known();
    expect(cache.get().size).toBe(0);
  });
});

/** What is called on a canvas, by name. */
function canvas(): { ctx: CanvasRenderingContext2D; calls: string[] } {
  const calls: string[] = [];
  const ctx = new Proxy({} as Record<string, unknown>, {
    get: (_, name: string) => () => void calls.push(name),
    set: () => true,
  });
  return { ctx: ctx as unknown as CanvasRenderingContext2D, calls };
}

/** Vehicles 1 to `count`, all of them placed. */
const fleetOf = (count: number): Fleet =>
  ({ size: count, presentCount: count, ids: Array.from({ length: count }, (_, i) => i + 1), present: new Array(count).fill(1), has: () => true }) as unknown as Fleet;
const SIZE = { width: 800, height: 600 };
const PALETTE = {} as Palette;
const inView = (index: number) => ({ x: 10 + (index % 70) * 10, y: 10 + Math.floor(index / 70) * 10 });

function painted(count: number, held: ReturnType<typeof heldByOthers>, at = inView): (name: string) => number {
  const { ctx, calls } = canvas();
  paintAuthority(ctx, SIZE, PALETTE, fleetOf(count), held, at);
  return (name) => calls.filter((call) => call === name).length;
}

describe('the signs', () => {
  it('are not even looked for where nobody else has anything', () => {
    const untouched = { x: NaN, y: NaN };
    let asked = 0;
    painted(3, heldByOthers(known(control(1, ME)), ME), () => ((asked += 1), untouched));
    expect(asked).toBe(0);
  });

  it('stand at the vehicles of others and at no other', () => {
    const asked: number[] = [];
    const count = painted(4, heldByOthers(known(control(2, 'b'), control(3, ME), control(9, 'b')), ME), (index) => (asked.push(index), inView(index)));
    expect(asked).toEqual([1]);
    // Plate, head and shoulders of one.
    expect(count('arc')).toBe(3);
  });

  it('are struck through where who has the vehicle is not heard: not by colour alone', () => {
    const heard = painted(1, heldByOthers(known(control(1, 'b')), ME));
    const silent = painted(1, heldByOthers(known(control(1, 'b', false)), ME));
    expect([heard('lineTo'), heard('fill'), heard('stroke')]).toEqual([0, 2, 1]);
    expect([silent('lineTo'), silent('fill'), silent('stroke')]).toEqual([1, 1, 2]);
  });

  it('are left out where they would not be seen', () => {
    const held = heldByOthers(known(control(1, 'b')), ME);
    for (const at of [{ x: NaN, y: 10 }, { x: -40, y: 10 }, { x: 10, y: 640 }]) expect(painted(1, held, () => at)('arc')).toBe(0);
  });

  it('of a thousand vehicles are drawn in as few strokes as those of two', () => {
    const all = (count: number) => heldByOthers(known(...Array.from({ length: count }, (_, i) => control(i + 1, 'b', i % 2 === 0))), ME);
    const [two, thousand] = [painted(2, all(2)), painted(1000, all(1000))];
    for (const name of ['fill', 'stroke', 'beginPath', 'save']) expect(thousand(name), name).toBe(two(name));
    expect(thousand('lineTo')).toBe(500);
  });
});
