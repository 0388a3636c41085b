// Layout of the binary telemetry frame (little-endian: 16 B header, then 64 B per vehicle) and reading it without garbage.
// Must never interpret: scaled numbers go out as they came in; what they mean is the telemetry store's part.

/** "SKN1" read as a little-endian u32. */
export const FRAME_MAGIC = 0x314e4b53;
export const HEADER_BYTES = 16;
export const RECORD_BYTES = 64;

/** Bits of the flags byte. */
export const FLAG = {
  armed: 1,
  linkConnected: 2,
  hasPosition: 4,
  hasSlot: 8,
  readyToArm: 16,
  leader: 32,
  pilotControl: 64,
  faulted: 128,
} as const;

/** Values that stand for "not known". */
export const UNKNOWN_U8 = 255;
export const UNKNOWN_U16 = 65535;

/** Byte offsets within a record. */
export const OFFSET = {
  id: 0,
  mode: 2,
  flags: 3,
  latitude: 4,
  longitude: 8,
  altitude: 12,
  velocityNorth: 16,
  velocityEast: 18,
  velocityDown: 20,
  roll: 22,
  pitch: 24,
  yaw: 26,
  battery: 28,
  loss: 29,
  satellites: 30,
  fix: 31,
  batteryVoltage: 32,
  age: 34,
  measured: 36,
  slotLatitude: 40,
  slotLongitude: 44,
  slotAltitude: 48,
  flightState: 52,
  landed: 53,
  trackingError: 54,
  roundTrip: 56,
  setpointRate: 58,
  actorIncarnation: 60,
  modelIncarnation: 62,
} as const;

export type FrameHeader = { sequence: number; count: number; serverTimeMs: number };

/** Why a frame was not taken. */
export class FrameError extends Error {
  override name = 'FrameError';
}

/** Checks magic and length and gives the header. */
export function readHeader(view: DataView): FrameHeader {
  if (view.byteLength < HEADER_BYTES) throw new FrameError(`frame of ${view.byteLength} bytes is shorter than its header`);
  const magic = view.getUint32(0, true);
  if (magic !== FRAME_MAGIC) throw new FrameError(`frame begins with 0x${magic.toString(16)}: another protocol version`);
  const count = view.getUint32(8, true);
  const expected = HEADER_BYTES + count * RECORD_BYTES;
  if (view.byteLength !== expected) {
    throw new FrameError(`frame of ${count} vehicles has ${view.byteLength} bytes instead of ${expected}`);
  }
  return { sequence: view.getUint32(4, true), count, serverTimeMs: view.getUint32(12, true) };
}
