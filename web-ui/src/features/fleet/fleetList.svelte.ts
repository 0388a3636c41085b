// The list's settings and what comes out of them; the counters in the header set the same filter.

import { createContext } from 'svelte';
import type { Session } from '../../model/session.svelte';
import type { Targets } from '../../model/targets.svelte';
import { compare, inCategory, matchesSearch } from './fleetFilter';
import type { ColumnKey, GroupKey } from './fleetColumns';
import type { FilterKey, SortKey } from './fleetFilter';

export class FleetList {
  search = $state('');
  filter = $state<FilterKey>('all');
  sort = $state<SortKey>('id');
  /** Of the table alone: the column it is sorted by, its groups, and whether cards are shown in its place. */
  column = $state<ColumnKey>('id');
  descending = $state(false);
  group = $state<GroupKey>('none');
  asCards = $state(false);
  readonly #session: Session;
  readonly #targets: Targets;

  constructor(session: Session, targets: Targets) {
    this.#session = session;
    this.#targets = targets;
  }

  shown = $derived.by(() =>
    this.#session.rows
      .filter((row) => inCategory(row, this.filter, this.#targets.selected) && matchesSearch(row, this.search))
      .sort(compare(this.sort)),
  );

  counts = $derived.by(() => {
    const counts = { all: 0, air: 0, ground: 0, attention: 0, critical: 0, warning: 0, lost: 0, armed: 0 };
    for (const row of this.#session.rows) {
      counts.all++;
      if (row.airborne) counts.air++;
      else counts.ground++;
      if (row.armed) counts.armed++;
      if (row.level >= 2) counts.attention++;
      if (row.level === 3) counts.critical++;
      if (row.level === 2) counts.warning++;
      if (row.staleness === 'lost') counts.lost++;
    }
    return counts;
  });
}

export const [useFleetList, provideFleetList] = createContext<FleetList>();
