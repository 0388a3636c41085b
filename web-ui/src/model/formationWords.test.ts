import { describe, expect, it } from 'vitest';
import type { FormationSnapshot } from '../protocol/types';
import { doingText, flownText, pathHeading, placed, requestOf, whyNobody } from './formationWords';
import type { FormationForm } from './formationWords';

const FORM: FormationForm = {
  shape: 'wedge', spacing_m: 5, heading: { kind: 'auto' }, altitude_step_m: 0, rotation_deg: 10, scale: 1, arcDeg: 90, layers: 3, pitchM: 12,
  offsets: [{ forward_m: 0, right_m: 0, down_m: 0 }], anchor: { kind: 'leader' }, control: 'slots', leader: 2, members: null,
};
const PLACE = { kind: 'place', position: { north_m: 1, east_m: 2, down_m: -10 }, heading_deg: null } as const;

describe('requestOf', () => {
  const extras = (form: Partial<FormationForm>) => {
    const { arc_deg, layers, pitch_m, offsets } = requestOf({ ...FORM, ...form });
    return [arc_deg, layers, pitch_m, offsets?.length ?? null];
  };

  it('sends the parameters that the shape has and no other', () => {
    expect(extras({})).toEqual([null, null, null, null]);
    expect(extras({ shape: 'arc' })).toEqual([90, null, null, null]);
    expect(extras({ shape: 'box' })).toEqual([null, 3, null, null]);
    expect(extras({ shape: 'helix' })).toEqual([null, null, 12, null]);
    expect(extras({ shape: 'free' })).toEqual([null, null, null, 1]);
  });

  it('zero leaves layers and pitch to the server', () => {
    expect(extras({ shape: 'box', layers: 0 })).toEqual([null, null, null, null]);
    expect(extras({ shape: 'helix', pitchM: 0 })).toEqual([null, null, null, null]);
  });

  it('names a leader only where one leads', () => {
    expect(requestOf(FORM).leader).toBe(2);
    expect(requestOf({ ...FORM, anchor: PLACE }).leader).toBeNull();
  });
});

describe('placed', () => {
  it('forward is east when the heading is east; up is what is not down', () => {
    const [slot] = placed([{ forward_m: 2, right_m: 1, down_m: -3 }], { north: 10, east: 20 }, Math.PI / 2);
    expect(slot!.north).toBeCloseTo(9, 9);
    expect(slot!.east).toBeCloseTo(22, 9);
    expect(slot!.upM).toBe(3);
  });
});

it('a path looks along its first leg, a single point nowhere', () => {
  expect(pathHeading([{ north: 0, east: 0 }, { north: 0, east: 5 }])).toBeCloseTo(Math.PI / 2, 9);
  expect(pathHeading([{ north: 0, east: 0 }])).toBeNull();
});

const flown = (part: Partial<FormationSnapshot>): FormationSnapshot => ({
  request: requestOf(FORM), leader: 2, anchor: null, keeps_itself: false, max_speed_m_s: 5, members: [2, 3, 4], view_blocked: [], route: null,
  route_finished: false, settled_at: 0, planned_min_distance_m: 4, intent_version: 1, ...part,
});

describe('flownText', () => {
  it('names the leader, or what is gone by without one', () => {
    expect(flownText(flown({}))).toEqual({ shape: 'Wedge', rest: ' of 3, 5 m apart, behind 2' });
    const about = (anchor: FormationForm['anchor']) => flownText(flown({ leader: null, request: requestOf({ ...FORM, anchor }) })).rest;
    expect(about(PLACE)).toBe(' of 3, 5 m apart, about a fixed place');
    expect(about({ kind: 'reference', name: 'car' })).toBe(' of 3, 5 m apart, about car');
    expect(about({ kind: 'path', route: { waypoints: [], speed_m_s: 5, corner_radius_m: 0 } })).toBe(' of 3, 5 m apart, along a path');
  });

  it('says whose camera sees nothing but the others', () => {
    expect(flownText(flown({ view_blocked: [3, 4] })).rest).toBe(' of 3, 5 m apart, behind 2; no free view for 3, 4');
  });

  it('says scale and control where they are not as usual', () => {
    const request = requestOf({ ...FORM, scale: 2, control: 'bearings' });
    expect(flownText(flown({ request, keeps_itself: true })).rest).toBe(
      ' of 3, 5 m apart, 2 times as large, behind 2, keeps itself by bearings',
    );
  });
});

describe('what the formation does now', () => {
  const route = { waypoints: [1, 2, 3].map((north_m) => ({ north_m, east_m: 0, down_m: -10 })), speed_m_s: 4, corner_radius_m: 8 };
  const does = (part: Partial<FormationSnapshot>, nowMs: number): string => doingText(flown(part), nowMs);

  it('is to form for some time, then to stand in its places', () => {
    expect(does({ settled_at: 12_500_000 }, 10_000)).toBe('Wedge of 3, 5 m apart, behind 2: forming, 3 s more');
    expect(does({ settled_at: 12_500_000 }, 12_500)).toBe('Wedge of 3, 5 m apart, behind 2: in its places');
  });

  it('is to fly its route until it has', () => {
    expect(does({ route }, 1)).toBe('Wedge of 3, 5 m apart, behind 2: flies a route of 3 points at 4 m/s');
    expect(does({ route, route_finished: true }, 1)).toBe('Wedge of 3, 5 m apart, behind 2: has flown its route of 3 points');
  });
});

describe('why nobody can take part', () => {
  const one = (airborne: boolean, flightState: string, staleness = 'live') => ({ airborne, flightState, staleness });

  it('is that nobody is selected, or is in the air, or is free', () => {
    expect(whyNobody([])).toBe('Select vehicles first');
    expect(whyNobody([one(false, 'idle'), one(false, 'arming')])).toBe('None of the 2 selected is in the air yet');
    expect(whyNobody([one(true, 'taking_off'), one(true, 'taking_off'), one(true, 'following', 'lost'), one(false, 'idle')])).toBe(
      'None of the 3 selected in the air is free: taking off, not heard',
    );
  });
});
