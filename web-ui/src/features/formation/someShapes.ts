// Shapes for tests: made by a generator with a fixed seed, so that a failure comes again. Must never be used by the page.

import type { OffsetFrd } from '../../protocol/types';

/** Numbers from 0 up to 1, always the same ones (mulberry32). */
export function numbers(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** A hundred shapes of up to twelve places, from a few metres to nearly a kilometre across, with figures as awkward as there are. */
export function someShapes(): OffsetFrd[][] {
  const next = numbers(7);
  const shape = (): OffsetFrd[] => {
    const reachM = 10 ** (0.5 + next() * 2.2);
    const figure = (): number => (next() - 0.5) * reachM;
    const count = 1 + Math.floor(next() * 11);
    return [{ forward_m: 0, right_m: 0, down_m: 0 }, ...Array.from({ length: count }, () => ({ forward_m: figure(), right_m: figure(), down_m: figure() / 10 }))];
  };
  return Array.from({ length: 100 }, shape);
}
