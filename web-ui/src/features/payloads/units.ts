// Units out of names: `pitch_rad` is a pitch, shown in degrees. Pure.

import { spoken } from '../../protocol/words';

export type Unit = {
  /** The name without its unit. */
  words: string;
  unit: string;
  /** A value of the wire times this is what is shown. */
  scale: number;
};

const DEGREES = 180 / Math.PI;

/** Longer endings first: `_m_s` before `_s`. */
const ENDINGS: readonly (readonly [string, string, number])[] = [
  ['_rad_s', '°/s', DEGREES], ['_m_s2', 'm/s²', 1], ['_m_s', 'm/s', 1], ['_bytes_per_s', 'B/s', 1], ['_rad', '°', DEGREES], ['_deg', '°', 1],
  ['_ms', 'ms', 1], ['_us', 'µs', 1], ['_dbm', 'dBm', 1], ['_db', 'dB', 1], ['_hz', 'Hz', 1], ['_mib', 'MiB', 1], ['_px', 'px', 1],
  ['_percent', '%', 1], ['_v', 'V', 1], ['_a', 'A', 1], ['_amsl_m', 'm above the sea', 1], ['_m', 'm', 1], ['_s', 's', 1],
];

/** `hint` is what the schema says itself; a hint is only shown, nothing is counted over for it. */
export function unitOf(name: string, hint = ''): Unit {
  const found = ENDINGS.find(([ending]) => name.endsWith(ending) && name.length > ending.length);
  if (!found) return { words: spoken(name), unit: hint, scale: 1 };
  const [ending, unit, scale] = found;
  return hint ? { words: spoken(name.slice(0, -ending.length)), unit: hint, scale: 1 } : { words: spoken(name.slice(0, -ending.length)), unit, scale };
}
