// The same fleet in feet and knots: what the page words from figures says the same in both systems, and what is sent does not change.

import { afterEach, beforeEach, describe, expect, it } from 'vitest';
import { OFFERS, commandOf } from '../features/commands/commandSet';
import { forecast } from '../features/commands/forecast';
import { ladderTop } from '../features/map/paintLadder';
import { upsText } from '../features/map/paintPlan';
import { leg, legText } from '../features/measure/measure';
import { stateLines } from '../features/payloads/stateLines';
import { schemaLines } from '../features/payloads/schemaState';
import { units } from '../language/units.svelte';
import type { Avoidance, FenceZone, FormationSnapshot, PreflightItem, Refusal } from '../protocol/types';
import { refusalText } from '../protocol/words';
import { bandText } from '../model/fences';
import { flownText } from '../model/formationWords';
import { limitText, valueText } from '../model/preflight';
import { RouteDraft } from '../model/routeDraft.svelte';
import { avoidanceText, quantity } from '../model/vehicleSafety';

beforeEach(() => {
  units.name = 'aviation';
});
afterEach(() => {
  units.name = 'metric';
});

const spot = (north: number, east: number, up: number | null = null) => ({ north, east, up, words: '' });

describe('in feet and knots', () => {
  it('a forecast says the height as its field does, and the command stays metric', () => {
    const offer = OFFERS.find(({ verb }) => verb === 'take_off')!;
    expect(forecast([], offer, 30.48).text).toBe('Arm if need be, climb to 100 ft and hold there: nobody');
    expect(commandOf('take_off', 30.48)).toEqual({ command: 'take_off', height_m: 30.48 });
  });

  it('a measured leg', () => {
    expect(legText(leg(spot(0, 0, 3), spot(0, 20, 1.5)))).toBe('65.6 ft, 090°, −5 ft up');
    expect(legText(leg(spot(0, 0), spot(3704, 0)))).toBe('2.00 NM, 000°');
  });

  it('a refusal', () => {
    expect(refusalText({ reason: 'too_fast', speed_m_s: 10, limit_m_s: 5 } as Refusal)).toBe('19.4 kn is over the limit of 9.7 kn');
    expect(refusalText({ reason: 'too_close', distance_m: 1.5, other: 3, limit_m: 3 } as Refusal)).toBe('4.9 ft from vehicle 3, under the limit of 9.8 ft');
  });

  it('what the safety functions say of a length or a speed, and of nothing else', () => {
    expect([quantity(3, 'm'), quantity(5, 'm/s'), quantity(5, 's'), quantity(0, 'm'), quantity(null, 'm')]).toEqual(['9.8 ft', '9.7 kn', '5 s', '0 ft', 'not known']);
    const avoiding: Avoidance = { by_m_s: 1, because: 'uav-3', distance_m: 4, predicted_m: 2, feasible: true };
    expect(avoidanceText(avoiding)).toBe('Gives way to uav-3, 13.1 ft away');
  });

  it('the band of a fence', () => {
    const zone: FenceZone = {
      name: 'field', kind: 'inclusion', outline: { shape: 'local_polygon', corners_m: [] }, floor_m: 0, ceiling_m: 60, altitude_reference: 'origin', action: 'hold',
    };
    expect(bandText(zone)).toBe('0 to 197 ft');
    expect(bandText({ ...zone, floor_m: null, altitude_reference: 'amsl' })).toBe('up to 197 ft AMSL');
  });

  it('the formation that is flown', () => {
    const flown = {
      request: { shape: 'wedge', spacing_m: 6.096, scale: 1, anchor: { kind: 'leader' } }, leader: 1, keeps_itself: false, members: [1, 2], view_blocked: [],
    } as unknown as FormationSnapshot;
    expect(flownText(flown).rest).toBe(' of 2, 20 ft apart, behind 1');
  });

  it('heights of previewed places, and the scale beside the map', () => {
    expect(upsText([3.048, -0.3048, 0])).toBe('-1 +0 +10 ft');
    expect([0, 10, 30, 300].map(ladderTop)).toEqual([50, 50, 200, 2000]);
  });

  it('a route that was drawn is sent in metres', () => {
    const draft = new RouteDraft(() => 12);
    draft.add({ north: 3, east: 4 });
    expect(draft.route()).toEqual({ waypoints: [{ north_m: 3, east_m: 4, down_m: -12 }], speed_m_s: 5, corner_radius_m: 8 });
  });

  it('the radio by hand, but a panel made from a schema in the units that its names say', () => {
    const state = { connected: true, fault: null, warning: false, range_m: 3000, distance_m: 100 };
    expect(stateLines('radio', state).filter(({ name }) => name === 'Range' || name === 'Distance').map(({ value }) => value)).toEqual(['1.62 NM', '328 ft']);
    expect(schemaLines(null, { range_m: 812 })).toEqual([{ name: 'Range', value: '812 m' }]);
  });
});

describe('a preflight item', () => {
  const item = (value: string, number: number | null, unit: string): PreflightItem => ({
    id: 'x', title: 'x', status: 'red', value, number, unit, limit: 3, why: '', may_be_overridden: false,
  });

  it('has its value and its limit in the same unit', () => {
    const near = item('1.5 m between 1 and 2', 1.52, 'm');
    expect([valueText(near), limitText(near)]).toEqual(['5 ft between 1 and 2', 'limit 9.8 ft']);
    expect(valueText(item('0.5 m/s', 0.514444, 'm/s'))).toBe('1 kn');
    units.name = 'metric';
    expect([valueText(near), limitText(near)]).toEqual(['1.5 m between 1 and 2', 'limit 3 m']);
  });

  it('is left as the node words it where that is no length and no speed', () => {
    expect(valueText(item('not known', null, 'm'))).toBe('not known');
    expect(valueText(item('0.020 s', 0.02, 's'))).toBe('0.020 s');
    expect(valueText(item('9 min', 9, 'm'))).toBe('9 min');
    expect(valueText(item('about 1.5 m', 1.5, 'm'))).toBe('about 1.5 m');
  });
});
