// The log of what happened: repeats are counted instead of repeated, warnings stay until acknowledged, length is bounded. Pure.

import type { EventRecord, Severity } from '../protocol/types';

export type LogEntry = {
  /** Unique within the page. */
  key: string;
  /** What makes two records the same. */
  signature: string;
  vehicle: number | null;
  severity: Severity;
  kind: string;
  text: string;
  /** How often it happened in a row. */
  count: number;
  /** Wall-clock ms of the first and the last time. */
  firstAt: number;
  lastAt: number;
  /** Wall-clock ms from which on it holds no more by itself; null for what stays until somebody has seen it. */
  endsAt: number | null;
  acknowledged: boolean;
  /** Of a former run of the server: of vehicles that are no more. */
  former: boolean;
};

export type EventLog = {
  /** Newest last time first. */
  entries: readonly LogEntry[];
  /** Greatest sequence number taken. */
  lastSeq: number;
};

export const EMPTY_LOG: EventLog = { entries: [], lastSeq: 0 };
export const KEPT_ENTRIES = 400;
/** The same thing within this time counts as a repeat. */
export const REPEAT_WITHIN_MS = 60_000;

export const SEVERITY_RANK: Record<Severity, number> = { info: 0, advisory: 1, warning: 2, critical: 3 };

/** What an entry is made of, whether it came from the server or from this page. */
export type Happening = {
  key: string;
  vehicle: number | null;
  severity: Severity;
  kind: string;
  text: string;
  at: number;
  endsAt: number | null;
};

export function happening(record: EventRecord, at: number): Happening {
  const { vehicle, severity, text } = record;
  const unlockedS = record.kind.kind === 'emergency_stop' ? /unlocked for (\d+) s$/.exec(text)?.[1] : undefined;
  const endsAt = unlockedS === undefined ? null : at + Number(unlockedS) * 1000;
  return { key: `s${record.seq}`, vehicle, severity, kind: record.kind.kind, text, at, endsAt };
}

/** The server began anew, its sequence numbers too. What was said before is kept to be read, wants nobody's look and is repeated by nothing. */
export function restarted(log: EventLog, run: number): EventLog {
  const before = (e: LogEntry): LogEntry => ({ ...e, key: `o${run}-${e.key}`, signature: `${run}|${e.signature}`, acknowledged: true, former: true });
  return { entries: log.entries.map((e) => (e.former ? e : before(e))), lastSeq: 0 };
}

/** Adds one; a repeat is counted on the entry it repeats and moves that to the top. */
export function add(log: EventLog, h: Happening, seq = 0): EventLog {
  const lastSeq = Math.max(log.lastSeq, seq);
  const signature = `${h.vehicle ?? ''}|${h.kind}|${h.severity}|${withoutMeasures(h.text)}`;
  const acknowledged = SEVERITY_RANK[h.severity] < SEVERITY_RANK.warning;
  const at = log.entries.findIndex((e) => e.signature === signature);
  const former = at >= 0 ? log.entries[at] : undefined;
  if (former && h.at - former.lastAt <= REPEAT_WITHIN_MS) {
    // A warning that comes again after it was acknowledged wants a new look.
    const again: LogEntry = { ...former, text: h.text, count: former.count + 1, lastAt: Math.max(former.lastAt, h.at), endsAt: h.endsAt, acknowledged };
    return { lastSeq, entries: [again, ...log.entries.slice(0, at), ...log.entries.slice(at + 1)] };
  }
  const entry: LogEntry = {
    key: h.key, signature, vehicle: h.vehicle, severity: h.severity, kind: h.kind, text: h.text,
    count: 1, firstAt: h.at, lastAt: h.at, endsAt: h.endsAt, acknowledged, former: false,
  };
  return { lastSeq, entries: bounded([entry, ...log.entries]) };
}

/** The same thing measured again is the same thing: what has a unit does not count, what numbers a vehicle or a node does. */
function withoutMeasures(text: string): string {
  return text.replace(/\d+(\.\d+)?(?= ?(?:(?:ms|m\/s|s|m|V|Hz)\b|%))/g, '#');
}

/** Over the bound the oldest goes, but what still wants acknowledging goes last. */
function bounded(entries: LogEntry[]): LogEntry[] {
  if (entries.length <= KEPT_ENTRIES) return entries;
  const at = entries.findLastIndex((e) => e.acknowledged);
  entries.splice(at > 0 ? at : entries.length - 1, 1);
  return entries;
}

export function acknowledge(log: EventLog, key: string): EventLog {
  return { ...log, entries: log.entries.map((e) => (e.key === key ? { ...e, acknowledged: true } : e)) };
}

export function acknowledgeAll(log: EventLog): EventLog {
  return { ...log, entries: log.entries.map((e) => (e.acknowledged ? e : { ...e, acknowledged: true })) };
}

/** What is over by `now` wants no more acknowledging. The same log where nothing is. */
export function pass(log: EventLog, now: number): EventLog {
  const over = (e: LogEntry): boolean => !e.acknowledged && e.endsAt !== null && e.endsAt <= now;
  if (!log.entries.some(over)) return log;
  return { ...log, entries: log.entries.map((e) => (over(e) ? { ...e, acknowledged: true } : e)) };
}

/** The emergency stop was locked again: an unlocking until `at` is over. One after that is somebody else's. */
export function locked(log: EventLog, at: number): EventLog {
  const over = (e: LogEntry): boolean => e.endsAt !== null && e.lastAt <= at;
  return { ...log, entries: log.entries.map((e) => (over(e) ? { ...e, endsAt: e.lastAt, acknowledged: true } : e)) };
}

/** Not acknowledged, worst first, then newest. */
export function outstanding(log: EventLog): LogEntry[] {
  return log.entries
    .filter((e) => !e.acknowledged)
    .sort((a, b) => SEVERITY_RANK[b.severity] - SEVERITY_RANK[a.severity] || b.lastAt - a.lastAt);
}
