// Where vehicles are drawn between frames, from frames made here.

import { describe, expect, it } from 'vitest';
import { FLAG, HEADER_BYTES, RECORD, RECORD_BYTES } from '../protocol/frame';
import { FRAME_MAGIC, HEADER } from '../protocol/generated/frame';
import { LANDED_STATES } from '../protocol/words';
import { CARRY_LIMIT_MS, carry } from './carry';
import { Fleet } from './fleet';
import { LIVE_BELOW_MS } from './staleness';

const ORIGIN = { latitude_deg: 47.4, longitude_deg: 8.5, altitude_amsl_m: 400 };
const FLYING = LANDED_STATES.indexOf('in_air');
const STANDING = LANDED_STATES.indexOf('on_ground');

type Said = { latitudeDeg?: number; north?: number; east?: number; down?: number; landed?: number; ageMs?: number; flags?: number };

function frame(said: Said): ArrayBuffer {
  const v = new DataView(new ArrayBuffer(HEADER_BYTES + RECORD_BYTES));
  v.setUint32(HEADER.magic, FRAME_MAGIC, true);
  v.setUint32(HEADER.count, 1, true);
  const at = HEADER_BYTES;
  v.setUint16(at + RECORD.id, 1, true);
  v.setUint8(at + RECORD.flags, said.flags ?? FLAG.connected | FLAG.position);
  v.setUint8(at + RECORD.landed, said.landed ?? FLYING);
  v.setInt32(at + RECORD.latitude_e7, (said.latitudeDeg ?? 47.4) * 1e7, true);
  v.setInt32(at + RECORD.longitude_e7, 8.5 * 1e7, true);
  v.setInt32(at + RECORD.altitude_amsl_mm, 420_000, true);
  v.setInt16(at + RECORD.velocity_north_cm_s, (said.north ?? 0) * 100, true);
  v.setInt16(at + RECORD.velocity_east_cm_s, (said.east ?? 0) * 100, true);
  v.setInt16(at + RECORD.velocity_down_cm_s, (said.down ?? 0) * 100, true);
  v.setUint16(at + RECORD.age_ms, said.ageMs ?? 10, true);
  return v.buffer;
}

function swarm(said: Said): Fleet {
  const fleet = new Fleet();
  fleet.setOrigin(ORIGIN);
  fleet.take(frame(said), 1000);
  return fleet;
}

const shown = (fleet: Fleet) => [fleet.shownNorthM[0]!, fleet.shownEastM[0]!, fleet.shownAltitudeM[0]!] as const;
const said = (fleet: Fleet) => [fleet.northM[0]!, fleet.eastM[0]!, fleet.altitudeM[0]!] as const;

describe('a place', () => {
  it('is carried forward by the velocity, in all three axes, and what was said stays', () => {
    const fleet = swarm({ north: 10, east: -4, down: 2 });
    const before = said(fleet);
    expect(shown(fleet)).toEqual(before);
    expect(carry(fleet, 1100)).toBe(true);
    const [north, east, altitude] = shown(fleet);
    expect(north - before[0]).toBeCloseTo(1, 5);
    expect(east - before[1]).toBeCloseTo(-0.4, 5);
    expect(altitude - before[2]).toBeCloseTo(-0.2, 5);
    expect(said(fleet)).toEqual(before);
    // Anew from what was said, not on top of the last time.
    carry(fleet, 1100);
    expect(shown(fleet)[0]).toBe(north);
  });

  it('goes on where it was carried to while the vehicle says no other', () => {
    const fleet = swarm({ north: 10 });
    carry(fleet, 1100);
    fleet.take(frame({ north: 10 }), 1100);
    carry(fleet, 1150);
    expect(shown(fleet)[0] - said(fleet)[0]).toBeCloseTo(1.5, 5);
    fleet.take(frame({ north: 10, latitudeDeg: 47.40002 }), 1200);
    carry(fleet, 1200);
    expect(shown(fleet)).toEqual(said(fleet));
  });

  it('is carried through a lost frame or two and no further', () => {
    const fleet = swarm({ north: 10 });
    carry(fleet, 1000 + CARRY_LIMIT_MS);
    const farthest = shown(fleet)[0];
    expect(farthest - said(fleet)[0]).toBeCloseTo((10 * CARRY_LIMIT_MS) / 1000, 5);
    carry(fleet, 1900);
    expect(shown(fleet)[0]).toBe(farthest);
  });

  it('is the last that was said once the vehicle is not live any more', () => {
    const silent = swarm({ north: 10 });
    expect(carry(silent, 1000 + LIVE_BELOW_MS)).toBe(false);
    expect(shown(silent)).toEqual(said(silent));
    const late = swarm({ north: 10, ageMs: LIVE_BELOW_MS });
    expect(carry(late, 1050)).toBe(false);
    expect(shown(late)).toEqual(said(late));
    const cut = swarm({ north: 10, flags: FLAG.position });
    expect(carry(cut, 1050)).toBe(false);
    expect(shown(cut)).toEqual(said(cut));
  });

  it('moves with the origin', () => {
    const fleet = swarm({ north: 10 });
    carry(fleet, 1100);
    fleet.setOrigin({ ...ORIGIN, latitude_deg: 47.41 });
    expect(shown(fleet)).toEqual(said(fleet));
    expect(shown(fleet)[0]).toBeLessThan(-1000);
  });
});

describe('under way', () => {
  it('is what flies, and what moves on the ground', () => {
    expect(carry(swarm({}), 1050)).toBe(true);
    expect(carry(swarm({ landed: STANDING }), 1050)).toBe(false);
    expect(carry(swarm({ landed: STANDING, east: 1 }), 1050)).toBe(true);
  });

  it('is nothing of which the place is not known', () => {
    expect(carry(swarm({ flags: FLAG.connected, north: 10 }), 1050)).toBe(false);
    expect(carry(new Fleet(), 0)).toBe(false);
  });
});

describe('in a recording', () => {
  it('a place is carried by the seconds of the flight, and not at all while it stands', () => {
    const fleet = swarm({ north: 10 });
    carry(fleet, 1100, 5);
    expect(fleet.shownNorthM[0]! - fleet.northM[0]!).toBeCloseTo(5, 3);
    expect(carry(fleet, 1200, 0)).toBe(false);
    expect(fleet.shownNorthM[0]).toBe(fleet.northM[0]);
  });

  it('it is carried no longer than through a lost frame, of the screen when it goes fast, of the flight when it goes slowly', () => {
    const fleet = swarm({ north: 10 });
    carry(fleet, 1000 + 2 * CARRY_LIMIT_MS, 2);
    expect(fleet.shownNorthM[0]! - fleet.northM[0]!).toBeCloseTo((10 * 2 * CARRY_LIMIT_MS) / 1000, 3);
    carry(fleet, 1000 + 2 * CARRY_LIMIT_MS, 0.25);
    expect(fleet.shownNorthM[0]! - fleet.northM[0]!).toBeCloseTo((10 * 0.5 * CARRY_LIMIT_MS) / 1000, 3);
    carry(fleet, 1000 + 900, 0.25);
    expect(fleet.shownNorthM[0]! - fleet.northM[0]!).toBeCloseTo(10 * 0.225, 3);
  });
});
