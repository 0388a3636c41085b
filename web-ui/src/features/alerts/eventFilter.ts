// Which events the log shows. Pure.

import { SEVERITY_RANK } from '../../model/eventLog';
import type { LogEntry } from '../../model/eventLog';
import type { Severity } from '../../protocol/types';

export type EventFilter = {
  /** This urgent at least. */
  least: Severity;
  /** One kind of event, or all. */
  kind: string;
  /** `targets`: of the targets; `swarm`: of no vehicle in particular. */
  about: 'all' | 'targets' | 'swarm';
  search: string;
};

export const EVERYTHING: EventFilter = { least: 'info', kind: 'all', about: 'all', search: '' };

/** Every word of the search has to be found, in the text, the kind, the urgency, or as the number of the vehicle. */
export function shows(entry: LogEntry, filter: EventFilter, targets: ReadonlySet<number>): boolean {
  if (SEVERITY_RANK[entry.severity] < SEVERITY_RANK[filter.least]) return false;
  if (filter.kind !== 'all' && entry.kind !== filter.kind) return false;
  if (filter.about === 'swarm' && entry.vehicles.length > 0) return false;
  if (filter.about === 'targets' && (entry.vehicles.length === 0 || (targets.size > 0 && !entry.vehicles.some((id) => targets.has(id))))) return false;
  const text = `${entry.text} ${entry.kind.replaceAll('_', ' ')} ${entry.severity}`.toLowerCase();
  return filter.search
    .toLowerCase()
    .split(/\s+/)
    .every((word) => word === '' || (/^\d+$/.test(word) && entry.vehicles.includes(Number(word))) || text.includes(word));
}

/** The kinds there are, by name. */
export function kindsOf(entries: readonly LogEntry[]): string[] {
  return [...new Set(entries.map((entry) => entry.kind))].sort();
}
