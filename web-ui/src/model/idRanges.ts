// Lists of vehicle numbers in short. Pure.

/** Ids as people write them: 1–4, 7. */
export function idRanges(ids: readonly number[]): string {
  const parts: string[] = [];
  for (let k = 0; k < ids.length; k++) {
    const from = ids[k] ?? 0;
    let to = from;
    while (ids[k + 1] === to + 1) to = ids[++k] ?? to;
    parts.push(to - from >= 2 ? `${from}–${to}` : to > from ? `${from}, ${to}` : `${from}`);
  }
  return parts.join(', ');
}
