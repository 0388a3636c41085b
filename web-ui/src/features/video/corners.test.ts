import { describe, expect, it } from 'vitest';
import { nearestCorner, nextCorner } from './corners';

describe('a tile on the map', () => {
  it('comes to rest in the nearest corner', () => {
    expect([[10, 10], [390, 10], [210, 160], [190, 290]].map(([x, y]) => nearestCorner(x!, y!, 400, 300))).toEqual(['top-left', 'top-right', 'bottom-right', 'bottom-left']);
  });

  it('goes round by keys', () => {
    expect(nextCorner('top-left')).toBe('top-right');
    expect(nextCorner('bottom-left')).toBe('top-left');
  });
});
