// A free shape as a file: read within bounds, written as a table that is read back to the last digit. Must never take part of a file, nor
// touch the shape that is there: what cannot be read is said, and that is all.

import { t } from '../../language/language.svelte';
import { parseOffsets } from '../../model/offsets';
import type { OffsetFrd } from '../../protocol/types';

export const MOST_BYTES = 1_000_000;
/** As many as the program reads; more are a mistake. */
export const MOST_PLACES = 10_000;
export const FILE_NAME = 'shape.csv';

const HEADING = 'forward_m,right_m,down_m';

/** The offsets as a table with a heading. A number is written with as many digits as it needs to be the same one when it is read. */
export function offsetsText(offsets: readonly OffsetFrd[]): string {
  const lines = offsets.map(({ forward_m, right_m, down_m }) => [forward_m, right_m, down_m].join(','));
  return `${[HEADING, ...lines].join('\n')}\n`;
}

export type Named = { name: string; size: number; text(): Promise<string> };
export type ReadShape = { text: string; count: number } | { fault: string };

export async function readShape(file: Named): Promise<ReadShape> {
  if (file.size > MOST_BYTES) return { fault: t('it is larger than 1 MB') };
  let text: string;
  try {
    text = await file.text();
  } catch {
    return { fault: t('the browser cannot open it') };
  }
  const read = parseOffsets(text);
  if ('fault' in read) return read;
  const count = read.offsets.length;
  return count > MOST_PLACES ? { fault: t('it has more than {most} places', { most: MOST_PLACES }) } : { text, count };
}
