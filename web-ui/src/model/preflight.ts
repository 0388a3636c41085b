// The preflight report in the order an operator needs it: red first, then amber; counted without what flies already. Pure.

import type { ItemStatus, PreflightAnswer, PreflightItem, PreflightOverride, PreflightReport } from '../protocol/types';
import { quantity } from './vehicleSafety';
import { t } from '../language/language.svelte';
import { inUnits } from '../language/units.svelte';

const RANK: Record<ItemStatus, number> = { red: 0, amber: 1, green: 2, not_applicable: 3 };

export type Counts = Record<ItemStatus, number>;

export type PreflightView = {
  /** The swarm's report first, then the vehicles' with the worst first. */
  reports: { report: PreflightReport; counts: Counts; items: readonly PreflightItem[]; flying: boolean }[];
  /** Over all reports of what does not fly yet. */
  counts: Counts;
};

export function countItems(items: readonly PreflightItem[]): Counts {
  const counts: Counts = { red: 0, amber: 0, green: 0, not_applicable: 0 };
  for (const item of items) counts[item.status]++;
  return counts;
}

/** `flying` says who is in the air: what is asked before arming means nothing of them. */
export function viewOf(answer: PreflightAnswer, flying: (vehicle: number) => boolean): PreflightView {
  const counts: Counts = { red: 0, amber: 0, green: 0, not_applicable: 0 };
  const reports = [answer.swarm, ...answer.vehicles].map((report) => {
    const inAir = report.vehicle !== null && flying(report.vehicle);
    const own = countItems(report.items);
    if (!inAir) for (const status of ['red', 'amber', 'green', 'not_applicable'] as const) counts[status] += own[status];
    const items = [...report.items].sort((a, b) => RANK[a.status] - RANK[b.status]);
    return { report, counts: own, items, flying: inAir };
  });
  const [swarm, ...vehicles] = reports;
  vehicles.sort(
    (a, b) =>
      Number(a.flying) - Number(b.flying) ||
      b.counts.red - a.counts.red ||
      b.counts.amber - a.counts.amber ||
      (a.report.vehicle ?? 0) - (b.report.vehicle ?? 0),
  );
  return { reports: swarm ? [swarm, ...vehicles] : vehicles, counts };
}

/** The limit of an item in words; empty if it has none. */
export function limitText(item: PreflightItem): string {
  return item.limit === null ? '' : `${t('limit')} ${quantity(item.limit, item.unit)}`;
}

/** The value of an item. The node words it; a number that it begins with is put into the units of the page, as its limit is. */
export function valueText({ value, number, unit }: PreflightItem): string {
  if (number === null || inUnits(number, unit).unit === unit) return value;
  return value.replace(/^-?\d+(\.\d+)? (m\/s|m)(?![\w/])/, (worded, _, named: string) => (named === unit ? quantity(number, unit) : worded));
}

/** The override that takes an item of a report upon somebody, if one holds. Times are the node's, in microseconds. */
export function overrideOf(
  item: PreflightItem, vehicle: number | null, overrides: readonly PreflightOverride[], nowUs: number,
): PreflightOverride | undefined {
  return overrides.find(
    (o) => o.items.includes(item.id) && o.vehicle === vehicle && nowUs <= o.given_at + o.valid_s * 1e6,
  );
}

/** Whether the server would let a permitted operator override an item. */
export function mayBeOverridden(item: PreflightItem): boolean {
  return item.status === 'red' && item.may_be_overridden;
}
