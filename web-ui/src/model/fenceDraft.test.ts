import { describe, expect, it } from 'vitest';
import type { FencePlan, FenceZone } from '../protocol/types';
import { SwarmProjection } from '../telemetry/geodesy';
import { FenceDraft } from './fenceDraft.svelte';
import { placeFences } from './fences';

const ORIGIN = { latitude_deg: 47.4, longitude_deg: 8.5, altitude_amsl_m: 488 };
const PROJECTION = new SwarmProjection(ORIGIN);
const NONE: FencePlan = { zones: [], breach_return: null };
const CORNERS = [{ north: 0, east: 0 }, { north: 40, east: 0 }, { north: 40, east: 30 }];

function drawn(): FenceDraft {
  const draft = new FenceDraft();
  for (const corner of CORNERS) draft.add(corner);
  return draft;
}

describe('a drawn zone', () => {
  it('comes out on the map where it was drawn', () => {
    const draft = drawn();
    draft.ceilingM = 60;
    const [zone] = placeFences(draft.planOn(NONE, PROJECTION), ORIGIN).zones;
    zone!.corners.forEach((corner, k) => {
      expect(corner.north).toBeCloseTo(CORNERS[k]!.north, 4);
      expect(corner.east).toBeCloseTo(CORNERS[k]!.east, 4);
    });
    expect([zone!.floorM, zone!.ceilingM, zone!.kind]).toEqual([null, 60, 'inclusion']);
  });

  it('gets a name that no other has, and leaves the others and the place to return to as they are', () => {
    const named = (name: string): FenceZone => ({ ...drawn().planOn(NONE, PROJECTION).zones[0]!, name });
    const back = { place: { latitude_deg: 47, longitude_deg: 8 }, height_m: 20 };
    const plan = drawn().planOn({ zones: [named('zone 2')], breach_return: back }, PROJECTION);
    expect(plan.zones.map((zone) => zone.name)).toEqual(['zone 2', 'zone 3']);
    expect(plan.breach_return).toEqual(back);
  });

  it('taken up again takes the place of what it was, once, with heights above the origin', () => {
    const amsl: FenceZone = { ...drawn().planOn(NONE, PROJECTION).zones[0]!, name: 'field', ceiling_m: 548, altitude_reference: 'amsl' };
    const inForce = { zones: [amsl, { ...amsl, name: 'mast' }], breach_return: null };
    const draft = new FenceDraft();
    draft.take(amsl, placeFences(inForce, ORIGIN).zones[0]!);
    draft.move(1, { north: 50, east: 0 });
    const after = draft.planOn(inForce, PROJECTION);
    expect(after.zones.map((zone) => zone.name)).toEqual(['mast', 'field']);
    expect(after.zones[1]).toMatchObject({ ceiling_m: 60, altitude_reference: 'origin' });
    expect(placeFences(after, ORIGIN).zones[1]!.corners[1]!.north).toBeCloseTo(50, 4);
  });

  it('leaves a zone alone that somebody else has changed meanwhile, and one of the same name', () => {
    const field: FenceZone = { ...drawn().planOn(NONE, PROJECTION).zones[0]!, name: 'field' };
    const draft = new FenceDraft();
    draft.take(field, placeFences({ zones: [field], breach_return: null }, ORIGIN).zones[0]!);
    expect(draft.others({ zones: [{ ...field, ceiling_m: 40 }, field, field], breach_return: null })).toEqual([{ ...field, ceiling_m: 40 }, field]);
    expect(draft.others({ zones: [{ ...field, ceiling_m: 40 }], breach_return: null })).toHaveLength(1);
  });

  it('has a corner less where the file repeats the first one', () => {
    const draft = new FenceDraft();
    const zone = drawn().planOn(NONE, PROJECTION).zones[0]!;
    draft.take(zone, { name: 'a', kind: 'inclusion', text: '', corners: [...CORNERS, CORNERS[0]!], floorM: null, ceilingM: null });
    expect(draft.waypoints).toEqual(CORNERS);
  });
});
