import { describe, expect, it } from 'vitest';
import { LOW_PX, LabelRoom, toolsBox } from './labelRoom';

describe('LabelRoom', () => {
  it('a taken place is not free, one beside it is', () => {
    const room = new LabelRoom();
    room.take({ x: 10, y: 10, w: 40, h: 16 });
    expect(room.isFree({ x: 45, y: 20, w: 40, h: 16 })).toBe(false);
    expect(room.isFree({ x: 50, y: 10, w: 40, h: 16 })).toBe(true);
    expect(room.isFree({ x: 10, y: 26, w: 40, h: 16 })).toBe(true);
  });

  it('finds what lies over several cells, left of zero too', () => {
    const room = new LabelRoom();
    room.take({ x: -500, y: -3, w: 900, h: 6 });
    expect(room.isFree({ x: -130, y: -10, w: 5, h: 12 })).toBe(false);
    expect(room.isFree({ x: 350, y: -90, w: 10, h: 200 })).toBe(false);
    expect(room.isFree({ x: 401, y: -90, w: 10, h: 200 })).toBe(true);
  });

  it('says the same as comparing with all of them', () => {
    const room = new LabelRoom();
    const taken = Array.from({ length: 200 }, (_, k) => ({ x: (k * 137) % 900, y: (k * 61) % 500, w: 30 + (k % 50), h: 16 }));
    for (const box of taken) room.take(box);
    for (let k = 0; k < 400; k++) {
      const box = { x: (k * 53) % 950, y: (k * 97) % 520, w: 25, h: 16 };
      const free = !taken.some((t) => box.x < t.x + t.w && t.x < box.x + box.w && box.y < t.y + t.h && t.y < box.y + box.h);
      expect(room.isFree(box)).toBe(free);
    }
  });
});

describe('toolsBox', () => {
  it.each([LOW_PX, LOW_PX + 300])('on a map %d high the tools are at the upper right and within it', (height) => {
    const box = toolsBox({ width: 390, height });
    expect(box.x + box.w).toBe(390);
    expect(box.y + box.h).toBeLessThanOrEqual(height);
  });
});
