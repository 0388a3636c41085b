// A formation in words, whether a vehicle leads it or not, and where a previewed one lies on the ground. Pure.

import type { FormationAnchor, FormationRequest, FormationSnapshot, OffsetFrd, Shape } from '../protocol/types';
import { label, spoken } from '../protocol/words';
import { idRanges } from './idRanges';
import { said, t } from '../language/language.svelte';
import { setText } from '../language/units.svelte';

/** All shapes, in the order they are offered. */
export const SHAPES: readonly Shape[] = [
  'line', 'column', 'wedge', 'echelon_left', 'echelon_right', 'diamond', 'circle', 'arc', 'square', 'grid', 'box', 'sphere', 'helix',
  'free',
];

export type Place = { north: number; east: number };
export type Slot = Place & { upM: number };

/** What a formation goes by: `behind 3`, `about a fixed place`. */
export function anchorText(anchor: FormationAnchor, leader: number | null): string {
  if (leader !== null) return t('behind {leader}', { leader });
  switch (anchor.kind) {
    case 'leader':
      return t('without a leader');
    case 'place':
      return t('about a fixed place');
    case 'path':
      return t('along a path');
    case 'reference':
      return t('about {name}', { name: anchor.name });
  }
}

/** `Wedge of 4, 5 m apart, behind 1`, in two parts: the shape stands out. */
export function flownText(flown: FormationSnapshot): { shape: string; rest: string } {
  const { request } = flown;
  const scaled = request.scale === 1 ? '' : t(', {scale} times as large', { scale: request.scale });
  const kept = flown.keeps_itself ? t(', keeps itself by {control}', { control: said(request.control) }) : '';
  const blocked = flown.view_blocked.length === 0 ? '' : t('; no free view for {who}', { who: idRanges(flown.view_blocked) });
  const rest = `${t(' of {count}, {spacing} apart', { count: flown.members.length, spacing: setText('length', request.spacing_m) })}${scaled}, ${anchorText(request.anchor, flown.leader)}${kept}${blocked}`;
  return { shape: label(request.shape), rest };
}

/** What the formation does now, for the command bar: `Wedge of 4, 5 m apart, behind 1: in its places`. `nowMs` is on the node's clock. */
export function doingText(flown: FormationSnapshot, nowMs: number): string {
  const { shape, rest } = flownText(flown);
  return `${shape}${rest}: ${doesText(flown, nowMs)}`;
}

function doesText({ route, route_finished, settled_at }: FormationSnapshot, nowMs: number): string {
  const leftS = Math.ceil((settled_at / 1000 - nowMs) / 1000);
  if (leftS > 0) return t('forming, {seconds} s more', { seconds: leftS });
  if (!route) return t('in its places');
  const speed = setText('speed', route.speed_m_s);
  const count = route.waypoints.length;
  return route_finished ? t('has flown its route of {count} points', { count }) : t('flies a route of {count} points at {speed}', { count, speed });
}

/** What is looked at of a vehicle that could take part. */
export type Candidate = { airborne: boolean; flightState: string; staleness: string };

/** Why none of the selected can take part in a formation. */
export function whyNobody(selected: readonly Candidate[]): string {
  if (selected.length === 0) return t('Select vehicles first');
  const flying = selected.filter((one) => one.airborne);
  if (flying.length === 0) return t('None of the {count} selected is in the air yet', { count: selected.length });
  const states = new Set(flying.map((one) => (one.staleness === 'lost' ? t('not heard') : spoken(one.flightState))));
  return t('None of the {count} selected in the air is free: {states}', { count: flying.length, states: [...states].join(', ') });
}

/** An offset turned to a heading (radians clockwise from north): metres north and east. */
export function turned(offset: OffsetFrd, headingRad: number): Place {
  const sin = Math.sin(headingRad);
  const cos = Math.cos(headingRad);
  return { north: offset.forward_m * cos - offset.right_m * sin, east: offset.forward_m * sin + offset.right_m * cos };
}

/** Slots about an anchor on the ground. */
export function placed(slots: readonly OffsetFrd[], anchor: Place, headingRad: number): Slot[] {
  return slots.map((slot) => {
    const by = turned(slot, headingRad);
    return { north: anchor.north + by.north, east: anchor.east + by.east, upM: 0 - slot.down_m };
  });
}

/** Direction of the first leg of a path, or of what leads to a single point; null if it has none. */
export function pathHeading(points: readonly Place[]): number | null {
  const [first, second] = points;
  if (!first || !second) return null;
  return Math.atan2(second.east - first.east, second.north - first.north);
}

/** The parameters that only some shapes have. */
export function hasParameter(shape: Shape, parameter: 'arc_deg' | 'layers' | 'pitch_m' | 'offsets'): boolean {
  return { arc_deg: 'arc', layers: 'box', pitch_m: 'helix', offsets: 'free' }[parameter] === shape;
}

/** What an operator has set on the form, with the parameters of every shape. */
export type FormationForm = Omit<FormationRequest, 'offsets' | 'layers' | 'pitch_m' | 'arc_deg'> & {
  arcDeg: number;
  /** 0: as the server thinks best. */
  layers: number;
  pitchM: number;
  offsets: readonly OffsetFrd[];
};

/** As the server is told: without the parameters that the shape does not have. */
export function requestOf(form: FormationForm): FormationRequest {
  const { arcDeg, layers, pitchM, offsets, ...rest } = form;
  const { shape } = form;
  return {
    ...rest,
    leader: form.anchor.kind === 'leader' ? form.leader : null,
    arc_deg: hasParameter(shape, 'arc_deg') ? arcDeg : null,
    layers: hasParameter(shape, 'layers') && layers > 0 ? layers : null,
    pitch_m: hasParameter(shape, 'pitch_m') && pitchM > 0 ? pitchM : null,
    offsets: hasParameter(shape, 'offsets') ? [...offsets] : null,
  };
}
