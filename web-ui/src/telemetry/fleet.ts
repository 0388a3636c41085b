// The live fleet as a struct of arrays: binary frames go in, the map and the 4 Hz list read it. No framework, no objects per
// message. A vehicle keeps its index as long as the page lives; `present` says whether the last frame still had it.

import { FLAG, HEADER_BYTES, RECORD, RECORD_BYTES, UNKNOWN_U16, UNKNOWN_PERCENT, readHeader } from '../protocol/frame';
import type { FrameHeader } from '../protocol/frame';
import type { Geodetic } from '../protocol/types';
import { SwarmProjection } from './geodesy';
import { Trails } from './trails';

const GROW_BY = 64;

export class Fleet {
  /** Vehicles ever seen; indices 0..size are valid. */
  size = 0;
  /** Vehicles in the last frame. */
  presentCount = 0;
  /** Header of the last frame taken. */
  sequence = 0;
  serverTimeMs = 0;
  framesTaken = 0;
  /** `performance.now()` when the last frame came. */
  receivedAt = 0;

  ids = new Uint16Array(GROW_BY);
  present = new Uint8Array(GROW_BY);
  mode = new Uint8Array(GROW_BY);
  flags = new Uint8Array(GROW_BY);
  latitudeDeg = new Float64Array(GROW_BY);
  longitudeDeg = new Float64Array(GROW_BY);
  altitudeM = new Float64Array(GROW_BY);
  /** Where it said it is, about the swarm's origin; figures are made of these. */
  northM = new Float64Array(GROW_BY);
  eastM = new Float64Array(GROW_BY);
  /** Where it is drawn and picked: what it said, carried forward (see `carry`). */
  shownNorthM = new Float64Array(GROW_BY);
  shownEastM = new Float64Array(GROW_BY);
  shownAltitudeM = new Float64Array(GROW_BY);
  /** On the `performance.now()` clock: when it said another place than before. */
  placedAt = new Float64Array(GROW_BY);
  velocityNorth = new Float32Array(GROW_BY);
  velocityEast = new Float32Array(GROW_BY);
  velocityDown = new Float32Array(GROW_BY);
  rollRad = new Float32Array(GROW_BY);
  pitchRad = new Float32Array(GROW_BY);
  yawRad = new Float32Array(GROW_BY);
  /** Percent; NaN if not known. */
  batteryPercent = new Float32Array(GROW_BY);
  batteryV = new Float32Array(GROW_BY);
  lossPercent = new Uint8Array(GROW_BY);
  satellites = new Uint8Array(GROW_BY);
  fix = new Uint8Array(GROW_BY);
  /** On the `performance.now()` clock: when the vehicle was last heard by the server. */
  heardAt = new Float64Array(GROW_BY);
  slotNorthM = new Float64Array(GROW_BY);
  slotEastM = new Float64Array(GROW_BY);
  slotAltitudeM = new Float64Array(GROW_BY);
  flightState = new Uint8Array(GROW_BY);
  landed = new Uint8Array(GROW_BY);
  /** Metres; NaN if not known. */
  trackingErrorM = new Float32Array(GROW_BY);
  /** Milliseconds; NaN if not known. */
  roundTripMs = new Float32Array(GROW_BY);
  setpointHz = new Float32Array(GROW_BY);
  actorIncarnation = new Uint16Array(GROW_BY);
  modelIncarnation = new Uint16Array(GROW_BY);

  readonly trails = new Trails(GROW_BY);
  projection: SwarmProjection | null = null;
  #originFixed = false;
  #indexById = new Map<number, number>();

  /** Index of a vehicle, or -1. */
  indexOf(id: number): number {
    return this.#indexById.get(id) ?? -1;
  }

  has(index: number, flag: number): boolean {
    return ((this.flags[index] ?? 0) & flag) !== 0;
  }

  /** Age of what is known of a vehicle, in ms, at `now` on the `performance.now()` clock. */
  ageMs(index: number, now: number): number {
    return Math.max(0, now - (this.heardAt[index] ?? 0));
  }

  /** Takes the swarm's origin from the server; positions and slots are projected about it from the next frame on. */
  setOrigin(origin: Geodetic | null): void {
    if (!origin) return;
    const old = this.projection?.origin;
    this.#originFixed = true;
    if (old && old.latitude_deg === origin.latitude_deg && old.longitude_deg === origin.longitude_deg) return;
    this.#moveOrigin(origin);
  }

  /** Forgets everything of the server's former run. */
  reset(): void {
    this.size = 0;
    this.presentCount = 0;
    this.sequence = 0;
    this.serverTimeMs = 0;
    this.#indexById.clear();
    this.present.fill(0);
    this.trails.clear();
    this.projection = null;
    this.#originFixed = false;
  }

  /** Reads a frame into the arrays. Throws `FrameError` and changes nothing if it is not one. */
  take(buffer: ArrayBuffer, now: number): FrameHeader {
    const view = new DataView(buffer);
    const header = readHeader(view);
    this.sequence = header.sequence;
    this.serverTimeMs = header.serverTimeMs;
    this.receivedAt = now;
    this.framesTaken++;
    this.present.fill(0);
    for (let k = 0; k < header.count; k++) this.#takeRecord(view, HEADER_BYTES + k * RECORD_BYTES, now);
    this.presentCount = header.count;
    return header;
  }

  #takeRecord(v: DataView, at: number, now: number): void {
    const i = this.#indexFor(v.getUint16(at + RECORD.id, true));
    const flags = v.getUint8(at + RECORD.flags);
    this.present[i] = 1;
    this.flags[i] = flags;
    this.mode[i] = v.getUint8(at + RECORD.mode);
    this.flightState[i] = v.getUint8(at + RECORD.flight_state);
    this.landed[i] = v.getUint8(at + RECORD.landed);
    this.velocityNorth[i] = v.getInt16(at + RECORD.velocity_north_cm_s, true) / 100;
    this.velocityEast[i] = v.getInt16(at + RECORD.velocity_east_cm_s, true) / 100;
    this.velocityDown[i] = v.getInt16(at + RECORD.velocity_down_cm_s, true) / 100;
    this.rollRad[i] = centidegrees(v.getInt16(at + RECORD.roll_cdeg, true));
    this.pitchRad[i] = centidegrees(v.getInt16(at + RECORD.pitch_cdeg, true));
    this.yawRad[i] = centidegrees(v.getUint16(at + RECORD.yaw_cdeg, true));
    const battery = v.getUint8(at + RECORD.battery_percent);
    this.batteryPercent[i] = battery === UNKNOWN_PERCENT ? NaN : battery;
    this.batteryV[i] = v.getUint16(at + RECORD.battery_10_mv, true) / 100;
    this.lossPercent[i] = v.getUint8(at + RECORD.loss_percent);
    this.satellites[i] = v.getUint8(at + RECORD.satellites);
    this.fix[i] = v.getUint8(at + RECORD.fix);
    const age = v.getUint16(at + RECORD.age_ms, true);
    // A saturated age says only "at least": what was worked out before is the better figure.
    if (age < UNKNOWN_U16 || Number.isNaN(this.heardAt[i])) this.heardAt[i] = now - age;
    this.trackingErrorM[i] = orNaN(v.getUint16(at + RECORD.tracking_error_cm, true), 100);
    this.roundTripMs[i] = orNaN(v.getUint16(at + RECORD.round_trip_100_us, true), 10);
    this.setpointHz[i] = v.getUint16(at + RECORD.setpoint_rate_dhz, true) / 10;
    this.actorIncarnation[i] = v.getUint16(at + RECORD.actor_incarnation, true);
    this.modelIncarnation[i] = v.getUint16(at + RECORD.model_incarnation, true);
    if (flags & FLAG.position) this.#takePosition(v, at, i, now);
    if (flags & FLAG.slot && this.projection) {
      const p = this.projection.project(
        v.getInt32(at + RECORD.slot_latitude_e7, true) / 1e7,
        v.getInt32(at + RECORD.slot_longitude_e7, true) / 1e7,
      );
      this.slotNorthM[i] = p.north;
      this.slotEastM[i] = p.east;
      this.slotAltitudeM[i] = v.getInt32(at + RECORD.slot_altitude_amsl_mm, true) / 1000;
    }
  }

  #takePosition(v: DataView, at: number, i: number, now: number): void {
    const latitude = v.getInt32(at + RECORD.latitude_e7, true) / 1e7;
    const longitude = v.getInt32(at + RECORD.longitude_e7, true) / 1e7;
    const altitude = v.getInt32(at + RECORD.altitude_amsl_mm, true) / 1000;
    // A place that is only told again, from a vehicle that tells it more seldom than frames come, is as old as it was.
    const moved = latitude !== this.latitudeDeg[i] || longitude !== this.longitudeDeg[i] || altitude !== this.altitudeM[i];
    if (moved) this.placedAt[i] = now;
    this.latitudeDeg[i] = latitude;
    this.longitudeDeg[i] = longitude;
    this.altitudeM[i] = altitude;
    // Until the server says where the swarm's origin is, the first place seen serves.
    if (!this.projection && !this.#originFixed) {
      this.projection = new SwarmProjection({
        latitude_deg: latitude,
        longitude_deg: longitude,
        altitude_amsl_m: altitude,
      });
    }
    const p = this.projection?.project(latitude, longitude);
    if (!p) return;
    this.#place(i, p.north, p.east);
    this.trails.push(i, p.north, p.east, altitude);
  }

  #moveOrigin(origin: Geodetic): void {
    this.projection = new SwarmProjection(origin);
    this.trails.clear();
    for (let i = 0; i < this.size; i++) {
      if (!this.has(i, FLAG.position)) continue;
      const p = this.projection.project(this.latitudeDeg[i] ?? 0, this.longitudeDeg[i] ?? 0);
      this.#place(i, p.north, p.east);
    }
  }

  /** What is said is shown as it is until it is carried. */
  #place(i: number, north: number, east: number): void {
    this.northM[i] = north;
    this.eastM[i] = east;
    this.shownNorthM[i] = north;
    this.shownEastM[i] = east;
    this.shownAltitudeM[i] = this.altitudeM[i] ?? 0;
  }

  #indexFor(id: number): number {
    const known = this.#indexById.get(id);
    if (known !== undefined) return known;
    if (this.size === this.ids.length) this.#grow();
    const index = this.size++;
    this.#indexById.set(id, index);
    this.ids[index] = id;
    this.heardAt[index] = NaN;
    this.trails.clearOne(index);
    return index;
  }

  #grow(): void {
    const capacity = this.ids.length * 2;
    const fields = this as unknown as Record<string, unknown>;
    for (const [name, value] of Object.entries(fields)) {
      if (!isArray(value)) continue;
      const larger = new (value.constructor as new (n: number) => NumberArray)(capacity);
      larger.set(value);
      fields[name] = larger;
    }
    this.trails.grow(capacity);
  }
}

type NumberArray = Uint8Array | Uint16Array | Float32Array | Float64Array;

function isArray(value: unknown): value is NumberArray {
  return ArrayBuffer.isView(value) && !(value instanceof DataView);
}

function centidegrees(value: number): number {
  return (value / 100) * (Math.PI / 180);
}

function orNaN(value: number, scale: number): number {
  return value === UNKNOWN_U16 ? NaN : value / scale;
}
