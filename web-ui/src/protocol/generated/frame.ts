// Made from the Rust types by `SKEIN_REGENERATE=1 cargo test -p skein-api --test generated`. Do not edit.
import type { FlightMode, FlightState, GnssFix, LandedState } from "./types";

/** First number of a frame; another one is another protocol. */
export const FRAME_MAGIC = 0x314e4b53;

/** Bytes before the first record. */
export const HEADER_BYTES = 16;

/** Bytes of one record. */
export const RECORD_BYTES = 64;

/** Battery charge that is not known. */
export const UNKNOWN_PERCENT = 255;

/** Battery voltage that is not known. */
export const UNKNOWN_VOLTAGE = 0;

/** Tracking error or round trip that is not known. */
export const UNKNOWN_U16 = 65535;

/** Where the numbers of the header stand, in bytes from its start. Little-endian. */
export const HEADER = {
  /** u32 */
  magic: 0,
  /** u32 */
  sequence: 4,
  /** u32 */
  count: 8,
  /** u32 */
  server_time_ms: 12,
} as const;

/** Where the numbers of a record stand, in bytes from its start. Little-endian. */
export const RECORD = {
  /** u16 */
  id: 0,
  /** u8 */
  mode: 2,
  /** u8 */
  flags: 3,
  /** i32 */
  latitude_e7: 4,
  /** i32 */
  longitude_e7: 8,
  /** i32 */
  altitude_amsl_mm: 12,
  /** i16 */
  velocity_north_cm_s: 16,
  /** i16 */
  velocity_east_cm_s: 18,
  /** i16 */
  velocity_down_cm_s: 20,
  /** i16 */
  roll_cdeg: 22,
  /** i16 */
  pitch_cdeg: 24,
  /** u16 */
  yaw_cdeg: 26,
  /** u8 */
  battery_percent: 28,
  /** u8 */
  loss_percent: 29,
  /** u8 */
  satellites: 30,
  /** u8 */
  fix: 31,
  /** u16 */
  battery_10_mv: 32,
  /** u16 */
  age_ms: 34,
  /** u32 */
  measured_ms: 36,
  /** i32 */
  slot_latitude_e7: 40,
  /** i32 */
  slot_longitude_e7: 44,
  /** i32 */
  slot_altitude_amsl_mm: 48,
  /** u8 */
  flight_state: 52,
  /** u8 */
  landed: 53,
  /** u16 */
  tracking_error_cm: 54,
  /** u16 */
  round_trip_100_us: 56,
  /** u16 */
  setpoint_rate_dhz: 58,
  /** u16 */
  actor_incarnation: 60,
  /** u16 */
  model_incarnation: 62,
} as const;

/** The bits of a record's flags. */
export const FLAG = {
  armed: 1,
  connected: 2,
  position: 4,
  slot: 8,
  ready: 16,
  leader: 32,
  pilot: 64,
  faulted: 128,
} as const;

/** The word for each code. */
export const FLIGHT_MODES: readonly FlightMode[] = [
  "unknown",
  "manual",
  "altitude",
  "position",
  "acro",
  "stabilized",
  "offboard",
  "ready",
  "take_off",
  "hold",
  "mission",
  "return",
  "land",
  "descend",
  "termination",
];

/** The word for each code. */
export const LANDED_STATES: readonly LandedState[] = [
  "unknown",
  "on_ground",
  "in_air",
  "taking_off",
  "landing",
];

/** The word for each code. */
export const GNSS_FIXES: readonly GnssFix[] = [
  "unknown",
  "none",
  "two_d",
  "three_d",
  "dgps",
  "rtk_float",
  "rtk_fixed",
];

/** The word for each code. */
export const FLIGHT_STATES: readonly FlightState[] = [
  "idle",
  "arming",
  "taking_off",
  "holding",
  "going_to",
  "following",
  "leading",
  "returning",
  "landing",
  "pilot_control",
  "faulted",
];
