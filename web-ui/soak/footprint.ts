// What the page holds after everything that can be let go was let go, and whether that stays the same. Must never count what a collection
// would have taken.

import type { CDPSession } from '@playwright/test';

export type Sample = {
  /** Seconds since the soak began. */
  atS: number;
  /** JavaScript's heap. */
  heapBytes: number;
  /** What the document's objects and array buffers hold besides. */
  besideBytes: number;
  listeners: number;
  nodes: number;
  documents: number;
};

/** Parts of a soak that are compared. */
export const PARTS = 5;

/** As Chromium answers; older types know the first only. */
type Heap = { usedSize: number; embedderHeapUsedSize?: number; backingStorageSize?: number };

export async function sample(cdp: CDPSession, atS: number): Promise<Sample> {
  // What the first round frees may be what held the rest: weak references, and what is told when something was collected.
  for (let round = 0; round < 2; round++) await cdp.send('HeapProfiler.collectGarbage');
  const heap: Heap = await cdp.send('Runtime.getHeapUsage');
  const counters = await cdp.send('Memory.getDOMCounters');
  return {
    atS,
    heapBytes: heap.usedSize,
    besideBytes: (heap.embedderHeapUsedSize ?? 0) + (heap.backingStorageSize ?? 0),
    listeners: counters.jsEventListeners,
    nodes: counters.nodes,
    documents: counters.documents,
  };
}

export type Figure = Exclude<keyof Sample, 'atS'>;
export const FIGURES: readonly Figure[] = ['heapBytes', 'besideBytes', 'listeners', 'nodes', 'documents'];

/** What a figure may have grown by between the medians of the second and the last part: a share of it, and some on top. */
export const MAY_GROW: Record<Figure, { share: number; by: number }> = {
  heapBytes: { share: 0.05, by: 500_000 },
  besideBytes: { share: 0.05, by: 500_000 },
  listeners: { share: 0.02, by: 10 },
  nodes: { share: 0.02, by: 50 },
  documents: { share: 0, by: 0 },
};

export function median(values: readonly number[]): number {
  const sorted = [...values].sort((a, b) => a - b);
  const middle = sorted.length >> 1;
  return sorted.length % 2 === 1 ? sorted[middle]! : (sorted[middle - 1]! + sorted[middle]!) / 2;
}

/** The samples of one part of the soak, counted from nought. */
export function part(samples: readonly Sample[], which: number, soakS: number): Sample[] {
  return samples.filter(({ atS }) => Math.min(PARTS - 1, Math.floor((atS / soakS) * PARTS)) === which);
}

/** What grew by more than it may, in words; empty if the line is flat. */
export function growth(samples: readonly Sample[], soakS: number): string[] {
  const [before, after] = [part(samples, 1, soakS), part(samples, PARTS - 1, soakS)];
  return FIGURES.flatMap((figure) => {
    const [from, to] = [before, after].map((some) => median(some.map((one) => one[figure]))) as [number, number];
    const { share, by } = MAY_GROW[figure];
    // Also when there was nothing to compare.
    return to <= from * (1 + share) + by ? [] : [`${figure} went from ${from} to ${to}`];
  });
}

export const HEAD = 'minutes        samples   heap, least and most       beside    listeners   nodes   documents';

export function row(samples: readonly Sample[]): string {
  const of = (figure: Figure): number[] => samples.map((one) => one[figure]);
  const mb = (bytes: number): string => (bytes / 1e6).toFixed(2);
  const heap = of('heapBytes');
  const from = (samples[0]?.atS ?? 0) / 60;
  const to = (samples.at(-1)?.atS ?? 0) / 60;
  return [
    `${from.toFixed(1)} to ${to.toFixed(1)}`.padEnd(15), `${samples.length}`.padStart(7),
    `${mb(median(heap))}, ${mb(Math.min(...heap))} to ${mb(Math.max(...heap))} MB`.padStart(28), `${mb(median(of('besideBytes')))} MB`.padStart(11),
    ...(['listeners', 'nodes', 'documents'] as const).map((figure) => `${median(of(figure))}`.padStart(10)),
  ].join('');
}
