import { describe, expect, it } from 'vitest';
import { SHAPES, slotOffsets, turned } from './slotPreview';

describe('slotOffsets', () => {
  it.each(SHAPES)('%s: the leader is at zero and nobody comes closer than the spacing', (shape) => {
    for (const count of [1, 2, 3, 6, 7, 20, 50]) {
      const slots = slotOffsets(shape, count, 5, 0);
      expect(slots).toHaveLength(count);
      expect(Math.hypot(slots[0]!.forward, slots[0]!.right)).toBeCloseTo(0, 9);
      for (let a = 0; a < count; a++) {
        for (let b = a + 1; b < count; b++) {
          const distance = Math.hypot(slots[a]!.forward - slots[b]!.forward, slots[a]!.right - slots[b]!.right);
          expect(distance).toBeGreaterThan(5 - 1e-9);
        }
      }
    }
  });

  it('a wedge opens to the rear, right side first', () => {
    const [, right, left] = slotOffsets('wedge', 3, Math.SQRT2, 0);
    expect(right).toMatchObject({ forward: expect.closeTo(-1, 9), right: expect.closeTo(1, 9) });
    expect(left).toMatchObject({ forward: expect.closeTo(-1, 9), right: expect.closeTo(-1, 9) });
  });

  it('each next slot is a step higher', () => {
    expect(slotOffsets('column', 3, 5, 0.5).map((s) => s.up)).toEqual([0, 0.5, 1]);
  });
});

describe('turned', () => {
  it('forward is east when the heading is east', () => {
    const by = turned({ forward: 2, right: 1, up: 0 }, Math.PI / 2);
    expect(by.north).toBeCloseTo(-1, 9);
    expect(by.east).toBeCloseTo(2, 9);
  });
});
