// What a payload says of its state, as an operator reads it: the standard kinds in words and degrees, any other as it came. Pure.

import type { CameraState, GimbalState, PayloadKind, RadioState } from '../../protocol/types';
import { spoken } from '../../protocol/words';
import { wayText } from '../../language/units.svelte';
import { t } from '../../language/language.svelte';

export type Line = { name: string; value: string; warn?: boolean };

const degrees = (radians: number): string => `${((radians * 180) / Math.PI).toFixed(0)}°`;
const known = <T>(value: T | null | undefined, text: (value: T) => string): string => (value === null || value === undefined ? '–' : text(value));

/** The lines of a state; none while the payload has not reported. */
export function stateLines(kind: PayloadKind, state: unknown): Line[] {
  if (typeof state !== 'object' || state === null) return [];
  switch (kind) {
    case 'gimbal':
      return withFault(gimbal(state as GimbalState), state);
    case 'camera':
      return withFault(camera(state as CameraState), state);
    case 'radio':
      return withFault(radio(state as RadioState), state);
    default:
      return other(state);
  }
}

function withFault(lines: Line[], state: object): Line[] {
  const { connected, fault } = state as { connected?: boolean; fault?: string };
  const first: Line[] = [];
  if (connected === false) first.push({ name: t('Device'), value: t('not heard'), warn: true });
  if (fault) first.push({ name: t('Fault'), value: fault, warn: true });
  return [...first, ...lines];
}

function gimbal(s: GimbalState): Line[] {
  const owner = s.owner.kind === 'other' ? `${s.owner.system_id}/${s.owner.component_id}` : spoken(s.owner.kind);
  return [
    { name: t('Pitch'), value: degrees(s.pitch_rad) },
    { name: t('Yaw, vehicle'), value: degrees(s.yaw_vehicle_rad) },
    { name: t('Yaw, north'), value: known(s.yaw_north_rad, degrees) },
    { name: t('Does'), value: spoken(s.mode) },
    { name: t('Steered by'), value: owner, warn: s.owner.kind === 'other' },
  ];
}

function camera(s: CameraState): Line[] {
  return [
    { name: t('Mode'), value: spoken(s.mode) },
    { name: t('Pictures'), value: `${s.pictures}${s.capturing ? t(', taking') : ''}` },
    { name: t('Recording'), value: s.recording ? `${s.recording_s.toFixed(0)} s` : t('no') },
    { name: t('Zoom'), value: known(s.zoom, (zoom) => `${zoom.toFixed(1)}×`) },
    { name: t('Storage free'), value: known(s.storage_free_mib, (free) => `${(free / 1024).toFixed(1)} GiB`) },
    { name: t('Frames'), value: `${s.frames}` },
  ];
}

function radio(s: RadioState): Line[] {
  return [
    { name: t('Signal'), value: known(s.rssi_dbm, (dbm) => `${dbm.toFixed(0)} dBm`) },
    { name: t('Signal/noise'), value: known(s.snr_db, (db) => `${db.toFixed(0)} dB`) },
    { name: t('Loss'), value: known(s.loss, (loss) => `${(loss * 100).toFixed(0)} %`) },
    { name: t('Range'), value: known(s.range_m, wayText), warn: s.warning },
    { name: t('Distance'), value: known(s.distance_m, wayText) },
  ];
}

function other(state: object): Line[] {
  return Object.entries(state)
    .slice(0, 12)
    .map(([name, value]) => ({ name: spoken(name), value: typeof value === 'object' ? JSON.stringify(value) : String(value) }));
}
