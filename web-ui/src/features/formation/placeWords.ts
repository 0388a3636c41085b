// A place of a free shape in words, for whoever cannot see the board. Pure.

import { t } from '../../language/language.svelte';
import { figureText } from '../../language/units.svelte';
import type { OffsetFrd } from '../../protocol/types';

/** `5.0 m back, 3.0 m right, level`. */
export function whereText({ forward_m, right_m, down_m }: OffsetFrd): string {
  const along = figureText('length', Math.abs(forward_m));
  const across = figureText('length', Math.abs(right_m));
  const height = figureText('height', Math.abs(down_m));
  const parts = [
    forward_m > 0 ? t('{distance} forward', { distance: along }) : forward_m < 0 ? t('{distance} back', { distance: along }) : '',
    right_m > 0 ? t('{distance} right', { distance: across }) : right_m < 0 ? t('{distance} left', { distance: across }) : '',
    down_m < 0 ? t('{distance} up', { distance: height }) : down_m > 0 ? t('{distance} down', { distance: height }) : t('level'),
  ];
  if (forward_m === 0 && right_m === 0) parts.unshift(t('at the origin'));
  return parts.filter((part) => part !== '').join(', ');
}

/** `Place 2: 5.0 m back, 3.0 m right, level, nearer than 1.0 m to another`. `which` counts from 0. */
export function placeText(which: number, place: OffsetFrd, near: string, empty: boolean): string {
  const where = t('Place {number}: {where}', { number: which + 1, where: whereText(place) });
  return [where, near, empty ? t('stays empty') : ''].filter((part) => part !== '').join(', ');
}
