// How much processor time the browser's page takes, as the kernel counts it: a figure that other work on the machine does not change.

import { readFileSync, readdirSync } from 'node:fs';

/** Seconds of processor time that a thread has had. */
function threadSeconds(pid: number, thread: number): number {
  try {
    return Number(readFileSync(`/proc/${pid}/task/${thread}/schedstat`, 'utf8').split(' ')[0]) / 1e9;
  } catch {
    return 0; // it has ended
  }
}

/** Processes of Chromium that draw pages. */
function renderers(): number[] {
  return readdirSync('/proc')
    .filter((name) => /^\d+$/.test(name))
    .map(Number)
    .filter((pid) => {
      try {
        return readFileSync(`/proc/${pid}/cmdline`, 'utf8').includes('--type=renderer');
      } catch {
        return false;
      }
    });
}

/** Seconds of the main threads of all pages, by process. */
export function mainThreads(): Map<number, number> {
  return new Map(renderers().map((pid) => [pid, threadSeconds(pid, pid)]));
}

/** What the busiest of them had since then. */
export function busiest(before: ReadonlyMap<number, number>): number {
  return Math.max(0, ...[...mainThreads()].map(([pid, seconds]) => seconds - (before.get(pid) ?? 0)));
}
