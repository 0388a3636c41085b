// Takes up the measuring tool and puts it away. Who has chosen some vehicles and takes it up measures between them: so it works without a
// pointer too.

import type { Console } from '../../app/console.svelte';

/** Between more than these one does not want all distances. */
const MOST_TARGETS = 6;

export function toggleMeasuring({ map, targets }: Console): void {
  if (map.tool === 'measure') {
    map.tool = 'pan';
    return;
  }
  map.tool = 'measure';
  map.measure.clear();
  if (targets.ids.length < 2 || targets.ids.length > MOST_TARGETS) return;
  for (const id of targets.ids) map.measure.add({ kind: 'vehicle', id });
}
