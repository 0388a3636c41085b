// What is said of a track, as an operator reads it. Pure. Must never call a guessed range known.

import { t } from '../../language/language.svelte';
import { figureText, lengthText, placeText } from '../../language/units.svelte';
import { ApiError } from '../../protocol/rest';
import { refusalText, spoken } from '../../protocol/words';
import type { ObserverProposal, Refusal, TrackEstimate } from '../../protocol/types';
import { errorEllipse, heightErrorM } from './errorShape';

/** What it is called, or its number. */
export function trackName({ name, track }: Pick<TrackEstimate, 'name' | 'track'>): string {
  return name === '' ? t('Track {track}', { track }) : name;
}

/** Beside its sign on the map: what it is called, and what it is. */
export function signText(track: Pick<TrackEstimate, 'name' | 'track' | 'class'>): string {
  return track.class === '' ? trackName(track) : `${trackName(track)} ${spoken(track.class)}`;
}

export const percentText = (share: number): string => `${Math.round(share * 100)} %`;

/** Less likely than this is not worth a word. */
const LEAST_SHARE = 0.01;

/** What it may be, the likeliest first. */
export function classLines({ classes, class: likeliest }: Pick<TrackEstimate, 'classes' | 'class'>): { word: string; share: number | null }[] {
  const all = Object.entries(classes).filter(([, share]) => share >= LEAST_SHARE).sort(([, a], [, b]) => b - a);
  if (all.length === 0 && likeliest !== '') return [{ word: spoken(likeliest), share: null }];
  return all.map(([word, share]) => ({ word: spoken(word), share }));
}

/** `12.0 m N, 5.0 m W, 20.0 m up`: about the swarm's origin. */
export function positionText({ north_m, east_m, down_m }: TrackEstimate['position']): string {
  const part = (metres: number, positive: string, negative: string): string => `${placeText(metres)} ${metres >= 0 ? positive : negative}`;
  return `${part(north_m, 'N', 'S')}, ${part(east_m, 'E', 'W')}, ${t('height {height}', { height: figureText('height', -down_m) })}`;
}

/** Below this it stands still as far as anybody can tell, in metres per second. */
const STILL_M_S = 0.2;

/** `3.2 m/s to 045°, climbs 1.0 m/s`. */
export function velocityText({ north_m_s, east_m_s, down_m_s }: TrackEstimate['velocity']): string {
  const ground = Math.hypot(north_m_s, east_m_s);
  const degrees = (Math.round((Math.atan2(east_m_s, north_m_s) * 180) / Math.PI) + 360) % 360;
  const over = ground < STILL_M_S ? figureText('speed', ground) : t('{speed} to {bearing}', { speed: figureText('speed', ground), bearing: bearingText(degrees) });
  if (Math.abs(down_m_s) < STILL_M_S) return over;
  const rate = figureText('climb', Math.abs(down_m_s));
  return `${over}, ${down_m_s < 0 ? t('climbs {rate}', { rate }) : t('descends {rate}', { rate })}`;
}

/** `045°` */
export const bearingText = (degrees: number): string => `${String(degrees).padStart(3, '0')}°`;

/** How well its place is known: two standard deviations, the worse way on the ground, and in height. */
export function knownText({ covariance_m2, guessed_range }: Pick<TrackEstimate, 'covariance_m2' | 'guessed_range'>): string {
  const ellipse = errorEllipse(covariance_m2);
  const heightM = heightErrorM(covariance_m2);
  if (!ellipse || heightM === null) return t('nobody says');
  const text = t('± {ground}, height ± {height}', { ground: lengthText(ellipse.longM), height: figureText('height', heightM) });
  return guessed_range ? `${text}; ${t('range only guessed from its size')}` : text;
}

/** Why something was not done. Of a value that is not allowed the reason alone: no value was typed. */
export function whyText(error: unknown): string {
  if (!(error instanceof ApiError)) return error instanceof Error ? error.message : String(error);
  const { detail } = error;
  if (typeof detail !== 'object' || detail === null || !('reason' in detail)) return error.message;
  const refusal = detail as Refusal;
  return refusal.reason === 'invalid_value' || refusal.reason === 'not_permitted' ? refusal.detail : refusalText(refusal);
}

/** Why a vehicle is proposed where it is in the row: `120 m away, 85 % charge, flies, camera on a gimbal`. */
export function proposalText({ distance_m, battery, flies, gimbal_camera, busy }: ObserverProposal): string {
  return [
    distance_m === null ? t('place not known') : t('{distance} away', { distance: lengthText(distance_m) }),
    battery === null ? t('charge not known') : t('{share} charge', { share: percentText(battery) }),
    flies ? spoken('in_air') : spoken('on_ground'),
    gimbal_camera ? t('camera on a gimbal') : t('no camera on a gimbal'),
    busy ?? t('not busy'),
  ].join(', ');
}
