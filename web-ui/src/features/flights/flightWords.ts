// What is said of recordings. Pure.

import { t } from '../../language/language.svelte';
import type { RecordedFlight, RecorderStatus } from '../../protocol/types';

/** Recordings of vehicles that stood are named so when they are ended. */
const STOOD = '_ground.mcap';

type Recorder = Pick<RecorderStatus, 'file' | 'in_flight'>;

export function isFlown({ file }: Pick<RecordedFlight, 'file'>, recorder: Recorder): boolean {
  return file === recorder.file ? recorder.in_flight : !file.endsWith(STOOD);
}

/** Whether it is whole. */
export function stateText({ file, finished }: Pick<RecordedFlight, 'file' | 'finished'>, recorder: Recorder): string {
  if (file === recorder.file) return t('is being written');
  return finished ? '' : t('cut off');
}
