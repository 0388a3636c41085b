// What is said of recordings. Pure.

import { t } from '../../language/language.svelte';
import type { RecordedFlight, RecorderStatus } from '../../protocol/types';

/** Recordings of vehicles that stood are named so when they are ended. */
const STOOD = '_ground.mcap';

type Recorder = Pick<RecorderStatus, 'file' | 'in_flight'>;

export function isFlown({ file }: Pick<RecordedFlight, 'file'>, recorder: Recorder): boolean {
  return file === recorder.file ? recorder.in_flight : !file.endsWith(STOOD);
}

/** How logs of autopilots are named beside a recording: `<recording>_<vehicle>_<number>.ulg`. */
const LOG = /^(.+)_(\d+)\.ulg$/;

/** A log beside a recording, in short: whose, and which. */
export function logText(log: string, { file }: Pick<RecordedFlight, 'file'>): string {
  const stem = `${file.replace(STOOD, '').replace(/\.mcap$/, '')}_`;
  const [, vehicle, number] = (log.startsWith(stem) ? LOG.exec(log.slice(stem.length)) : null) ?? [];
  return vehicle === undefined || number === undefined ? log : t('{vehicle}, log {number}', { vehicle, number });
}

/** Names in the order in which they are counted: `uav-2` before `uav-10`. */
export function byName(names: readonly string[]): string[] {
  return [...names].sort(new Intl.Collator('en', { numeric: true }).compare);
}

/** Whether it is whole. */
export function stateText({ file, finished }: Pick<RecordedFlight, 'file' | 'finished'>, recorder: Recorder): string {
  if (file === recorder.file) return t('is being written');
  return finished ? '' : t('cut off');
}
