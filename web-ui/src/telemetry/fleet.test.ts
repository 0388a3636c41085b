// The binary decoder against bytes written by hand from the layout, and against the frames the server's own encoder made.

import { describe, expect, it } from 'vitest';
import { FLAG, FrameError, UNKNOWN_U16 } from '../protocol/frame';
import golden from '../protocol/generated/frame.golden.json';
import { Fleet } from './fleet';

const ORIGIN = { latitude_deg: 47.397742, longitude_deg: 8.545594, altitude_amsl_m: 488 };

function bytes(hex: string): ArrayBuffer {
  const pairs = hex.replace(/\s+/g, '').match(/../g) ?? [];
  return Uint8Array.from(pairs, (pair) => parseInt(pair, 16)).buffer;
}

/** One vehicle, every field with another value, byte by byte. */
const BY_HAND = `
  53 4b 4e 31  2a 00 00 00  01 00 00 00  e8 03 00 00
  07 00  06  2f
  ac 51 40 1c  c4 f8 17 05  08 90 07 00
  f4 01  9c ff  0a 00
  e8 03  18 fc  28 23
  57  05  11  06
  40 06  23 00  e4 03 00 00
  ac 51 40 1c  c4 f8 17 05  e0 97 07 00
  05  02  0c 00  7d 00  f4 01  02 00  03 00`;

describe('a frame written by hand', () => {
  const fleet = new Fleet();
  fleet.setOrigin(ORIGIN);
  const header = fleet.take(bytes(BY_HAND), 5000);

  it('gives its header', () => {
    expect(header).toEqual({ sequence: 42, count: 1, serverTimeMs: 1000 });
    expect(fleet.presentCount).toBe(1);
  });

  it('gives every field in its unit', () => {
    const i = fleet.indexOf(7);
    expect(i).toBe(0);
    expect(fleet.mode[i]).toBe(6);
    expect(fleet.latitudeDeg[i]).toBeCloseTo(47.397726, 7);
    expect(fleet.longitudeDeg[i]).toBeCloseTo(8.5457092, 7);
    expect(fleet.altitudeM[i]).toBeCloseTo(495.624, 6);
    expect(fleet.velocityNorth[i]).toBeCloseTo(5, 5);
    expect(fleet.velocityEast[i]).toBeCloseTo(-1, 5);
    expect(fleet.velocityDown[i]).toBeCloseTo(0.1, 5);
    expect(fleet.rollRad[i]).toBeCloseTo((10 * Math.PI) / 180, 5);
    expect(fleet.pitchRad[i]).toBeCloseTo((-10 * Math.PI) / 180, 5);
    expect(fleet.yawRad[i]).toBeCloseTo(Math.PI / 2, 5);
    expect(fleet.batteryPercent[i]).toBe(87);
    expect(fleet.lossPercent[i]).toBe(5);
    expect(fleet.satellites[i]).toBe(17);
    expect(fleet.fix[i]).toBe(6);
    expect(fleet.batteryV[i]).toBeCloseTo(16, 5);
    expect(fleet.ageMs(i, 5000)).toBe(35);
    expect(fleet.slotAltitudeM[i]).toBeCloseTo(497.632, 6);
    expect(fleet.flightState[i]).toBe(5);
    expect(fleet.landed[i]).toBe(2);
    expect(fleet.trackingErrorM[i]).toBeCloseTo(0.12, 5);
    expect(fleet.roundTripMs[i]).toBeCloseTo(12.5, 5);
    expect(fleet.setpointHz[i]).toBeCloseTo(50, 5);
    expect(fleet.actorIncarnation[i]).toBe(2);
    expect(fleet.modelIncarnation[i]).toBe(3);
  });

  it('gives its flags', () => {
    const set = Object.entries(FLAG).filter(([, bit]) => fleet.has(0, bit));
    expect(set.map(([name]) => name)).toEqual(['armed', 'connected', 'position', 'slot', 'leader']);
  });

  it('puts place and slot into metres about the origin', () => {
    expect(fleet.northM[0]).toBeCloseTo(-1.779, 2);
    expect(fleet.eastM[0]).toBeCloseTo(8.671, 2);
    expect(fleet.slotNorthM[0]).toBeCloseTo(fleet.northM[0] ?? NaN, 6);
  });
});

describe("the server's own frames", () => {
  it.each(golden)('$name', (vector) => {
    const fleet = new Fleet();
    fleet.setOrigin(ORIGIN);
    const header = fleet.take(bytes(vector.hex), 100_000);
    expect(header.sequence).toBe(vector.sequence);
    expect(header.serverTimeMs).toBe(vector.server_time_ms);
    expect(fleet.size).toBe(vector.records.length);
    for (const record of vector.records) {
      const i = fleet.indexOf(record.id);
      expect(i).toBeGreaterThanOrEqual(0);
      expect(fleet.mode[i]).toBe(record.mode);
      expect(fleet.flags[i]).toBe(record.flags);
      if (record.flags & FLAG.position) {
        expect(fleet.latitudeDeg[i]).toBeCloseTo(record.latitude_e7 / 1e7, 9);
        expect(fleet.longitudeDeg[i]).toBeCloseTo(record.longitude_e7 / 1e7, 9);
        expect(fleet.altitudeM[i]).toBeCloseTo(record.altitude_amsl_mm / 1000, 6);
      }
      expect(fleet.velocityNorth[i]).toBeCloseTo(record.velocity_north_cm_s / 100, 3);
      expect(fleet.velocityDown[i]).toBeCloseTo(record.velocity_down_cm_s / 100, 3);
      expect(fleet.yawRad[i]).toBeCloseTo((record.yaw_cdeg / 100) * (Math.PI / 180), 5);
      if (record.battery_percent === 255) expect(fleet.batteryPercent[i]).toBeNaN();
      else expect(fleet.batteryPercent[i]).toBe(record.battery_percent);
      expect(fleet.ageMs(i, 100_000)).toBe(record.age_ms);
      expect(fleet.flightState[i]).toBe(record.flight_state);
      expect(fleet.landed[i]).toBe(record.landed);
      if (record.tracking_error_cm === UNKNOWN_U16) expect(fleet.trackingErrorM[i]).toBeNaN();
      else expect(fleet.trackingErrorM[i]).toBeCloseTo(record.tracking_error_cm / 100, 2);
      expect(fleet.actorIncarnation[i]).toBe(record.actor_incarnation);
      expect(fleet.modelIncarnation[i]).toBe(record.model_incarnation);
    }
  });
});

describe('what is not a frame', () => {
  it.each([
    ['too short', '53 4b 4e 31', /shorter than its header/],
    ['another magic', '53 4b 4e 32 00000000 00000000 00000000', /another protocol version/],
    ['a record missing', '53 4b 4e 31 00000000 01000000 00000000', /1 vehicles has 16 bytes instead of 80/],
  ])('%s is refused and changes nothing', (_, hex, why) => {
    const fleet = new Fleet();
    fleet.take(bytes(BY_HAND), 0);
    expect(() => fleet.take(bytes(hex), 1)).toThrow(FrameError);
    expect(() => fleet.take(bytes(hex), 1)).toThrow(why);
    expect(fleet.sequence).toBe(42);
    expect(fleet.present[0]).toBe(1);
  });
});

describe('over many frames', () => {
  /** A frame of `ids`, all zero but for the flags and the age. */
  function frame(ids: number[], age = 0, flags: number = FLAG.connected): ArrayBuffer {
    const view = new DataView(new ArrayBuffer(16 + 64 * ids.length));
    view.setUint32(0, 0x314e4b53, true);
    view.setUint32(8, ids.length, true);
    ids.forEach((id, k) => {
      view.setUint16(16 + 64 * k, id, true);
      view.setUint8(19 + 64 * k, flags);
      view.setUint16(50 + 64 * k, age, true);
    });
    return view.buffer;
  }

  it('a vehicle keeps its index, and one that is gone is not present', () => {
    const fleet = new Fleet();
    fleet.take(frame([3, 9]), 0);
    fleet.take(frame([9]), 100);
    expect([fleet.indexOf(3), fleet.indexOf(9)]).toEqual([0, 1]);
    expect([fleet.present[0], fleet.present[1]]).toEqual([0, 1]);
    expect(fleet.presentCount).toBe(1);
  });

  it('there is room for more vehicles than at the start, and nothing is forgotten', () => {
    const fleet = new Fleet();
    const ids = Array.from({ length: 1000 }, (_, k) => k + 1);
    fleet.take(frame(ids.slice(0, 10), 7), 50);
    fleet.take(frame(ids), 60);
    expect(fleet.size).toBe(1000);
    expect(fleet.ids[999]).toBe(1000);
    expect(fleet.indexOf(1000)).toBe(999);
    expect(fleet.present[999]).toBe(1);
  });

  it('an age that is saturated does not make a vehicle younger', () => {
    const fleet = new Fleet();
    fleet.take(frame([1], 60_000), 60_000);
    fleet.take(frame([1], UNKNOWN_U16), 200_000);
    expect(fleet.ageMs(0, 200_000)).toBe(200_000);
  });

  it('a place that is not known is never taken for one', () => {
    const fleet = new Fleet();
    fleet.take(frame([1]), 0);
    expect(fleet.projection).toBeNull();
    expect(fleet.trails.length(0)).toBe(0);
  });
});
