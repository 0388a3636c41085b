// The log of what happened: repeats are counted instead of repeated, what several vehicles complain of is one alert, warnings stay until
// acknowledged, length is bounded. Pure.

import type { EventRecord, Severity } from '../protocol/types';

export type LogEntry = {
  /** Unique within the page. */
  key: string;
  /** What makes two records the same. */
  signature: string;
  /** Whom it is about, by number; nobody in particular if empty. */
  vehicles: readonly number[];
  severity: Severity;
  kind: string;
  text: string;
  /** What brought it about, where that is known. */
  cause: string | null;
  /** How often it happened in a row. */
  count: number;
  /** The server's numbers of what is counted here, the newest last; none for what this page noticed itself. */
  numbers: readonly number[];
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
  /** The server's computer is late, or was a moment ago. */
  overrun: { text: string; at: number } | null;
};

export const EMPTY_LOG: EventLog = { entries: [], lastSeq: 0, overrun: null };
export const KEPT_ENTRIES = 400;
/** More numbers of one entry are not kept: the server keeps so many events. */
const KEPT_NUMBERS = 2000;
/** What several vehicles complain of so soon after the server's computer was late has that for a cause. */
export const CAUSED_WITHIN_MS = 3_000;
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
  /** The server's number. */
  seq: number | null;
};

/** `name` is that of its vehicle. An alert does not begin with it: its numbers say whom it is about, and it may be about several. */
export function happening(record: EventRecord, at: number, name = ''): Happening {
  const { vehicle, severity } = record;
  const begin = SEVERITY_RANK[severity] >= SEVERITY_RANK.warning && name !== '' ? `${name}: ` : '';
  const text = record.text.startsWith(begin) ? record.text.slice(begin.length) : record.text;
  const unlockedS = record.kind.kind === 'emergency_stop' ? /unlocked for (\d+) s$/.exec(text)?.[1] : undefined;
  const endsAt = unlockedS === undefined ? null : at + Number(unlockedS) * 1000;
  return { key: `s${record.seq}`, vehicle, severity, kind: record.kind.kind, text, at, endsAt, seq: record.seq };
}

/** The server began anew, its sequence numbers too. What was said before is kept to be read, wants nobody's look and is repeated by nothing. */
export function restarted(log: EventLog, run: number): EventLog {
  const before = (e: LogEntry): LogEntry => ({ ...e, key: `o${run}-${e.key}`, signature: `${run}|${e.signature}`, numbers: [], acknowledged: true, former: true });
  return { ...EMPTY_LOG, entries: log.entries.map((e) => (e.former ? e : before(e))) };
}

/** Takes what the server says, in the order of its numbers. */
export function take(log: EventLog, record: EventRecord, at: number, name = ''): EventLog {
  const taken = { ...add(log, happening(record, at, name)), lastSeq: record.seq };
  switch (record.kind.kind) {
    case 'acknowledged': return acknowledged(taken, new Set(record.kind.events));
    case 'overrun': return { ...taken, overrun: { text: record.text, at } };
    case 'overrun_ended': return overrunEnded(taken);
    default: return taken;
  }
}

/** Adds one; a repeat is counted on the entry it repeats and moves that to the top. An alert of another vehicle is a repeat too. */
export function add(log: EventLog, h: Happening): EventLog {
  const alert = SEVERITY_RANK[h.severity] >= SEVERITY_RANK.warning;
  const about = alert && h.vehicle !== null ? 'vehicles' : (h.vehicle ?? '');
  const signature = `${about}|${h.kind}|${h.severity}|${withoutMeasures(h.text)}`;
  const cause = alert && h.vehicle !== null && log.overrun && h.at - log.overrun.at <= CAUSED_WITHIN_MS ? log.overrun.text : null;
  const at = log.entries.findIndex((e) => e.signature === signature);
  const found = log.entries[at];
  const former = found && h.at - found.lastAt <= REPEAT_WITHIN_MS ? found : null;
  const entry: LogEntry = {
    key: former?.key ?? h.key,
    signature,
    vehicles: withNumber(former?.vehicles ?? [], h.vehicle).sort((a, b) => a - b),
    severity: h.severity,
    kind: h.kind,
    text: h.text,
    // What has happened without the cause as well is not explained by it.
    cause: former && !former.acknowledged && former.cause === null ? null : cause,
    count: (former?.count ?? 0) + 1,
    numbers: withNumber(former?.numbers ?? [], h.seq).slice(-KEPT_NUMBERS),
    firstAt: former?.firstAt ?? h.at,
    lastAt: Math.max(former?.lastAt ?? h.at, h.at),
    endsAt: h.endsAt,
    // A warning that comes again after it was acknowledged wants a new look.
    acknowledged: !alert,
    former: false,
  };
  return { ...log, entries: former ? [entry, ...log.entries.slice(0, at), ...log.entries.slice(at + 1)] : bounded([entry, ...log.entries]) };
}

function withNumber(numbers: readonly number[], one: number | null): number[] {
  return one === null || numbers.includes(one) ? [...numbers] : [...numbers, one];
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

/** Somebody has seen what the server knows by these numbers. What has come again since then is not seen. */
function acknowledged(log: EventLog, numbers: ReadonlySet<number>): EventLog {
  const seen = (e: LogEntry): boolean => numbers.has(e.numbers.at(-1) ?? -1);
  return { ...log, entries: log.entries.map((e) => (seen(e) ? { ...e, acknowledged: true } : e)) };
}

/** The server's computer is in time again: that is over, and so are the warnings that it brought about. What is critical wants a look all the same. */
function overrunEnded(log: EventLog): EventLog {
  const over = (e: LogEntry): boolean => !e.acknowledged && (e.kind === 'overrun' || (e.cause !== null && e.severity === 'warning'));
  return { ...log, overrun: null, entries: log.entries.map((e) => (over(e) ? { ...e, acknowledged: true } : e)) };
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
