//! The binary telemetry frame: a 16-byte header, then 64 bytes per vehicle, little-endian, without gaps.
//!
//! One list of fields makes the encoder, the offsets the browser reads with and the tests. A change of the list is a new
//! protocol version: the magic carries it. Must never do: I/O, or read a clock (the time comes in).

use serde::Serialize;
use skein_domain::{FlightState, Geodetic, NodeTime, SwarmFrame};
use skein_view::{ActorStatus, FleetSnapshot, VehicleSnapshot};

/// "SKN1", read as a little-endian number.
pub const FRAME_MAGIC: u32 = 0x314E_4B53;
/// Bytes before the first record.
pub const HEADER_BYTES: usize = 16;
/// Bytes of one record.
pub const RECORD_BYTES: usize = 64;
/// More vehicles than this are not put into one frame (1 MiB of records).
pub const MAX_RECORDS: usize = 16_384;

/// Battery charge that is not known.
pub const UNKNOWN_PERCENT: u8 = u8::MAX;
/// Battery voltage that is not known.
pub const UNKNOWN_VOLTAGE: u16 = 0;
/// Tracking error or round trip that is not known.
pub const UNKNOWN_U16: u16 = u16::MAX;

/// One field of the header or of a record, as the browser has to read it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Its name, with the unit.
    pub name: &'static str,
    /// Bytes from the start of the header or record.
    pub offset: usize,
    /// Its number type in Rust's words.
    pub kind: &'static str,
}

/// A packed group of numbers: the struct, its encoder and the table of its fields from one list.
macro_rules! packed {
    ($(#[$doc:meta])* $name:ident { $($(#[$fdoc:meta])* $field:ident: $kind:ident),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
        pub struct $name { $($(#[$fdoc])* pub $field: $kind),+ }

        impl $name {
            /// The fields in the order in which they are written.
            pub const FIELDS: &'static [Field] = {
                const SIZES: &[usize] = &[$(size_of::<$kind>()),+];
                const NAMES: &[(&str, &str)] = &[$((stringify!($field), stringify!($kind))),+];
                const TABLE: [Field; SIZES.len()] = {
                    let mut table = [Field { name: "", offset: 0, kind: "" }; SIZES.len()];
                    let (mut at, mut offset) = (0, 0);
                    while at < SIZES.len() {
                        table[at] = Field { name: NAMES[at].0, offset, kind: NAMES[at].1 };
                        offset += SIZES[at];
                        at += 1;
                    }
                    table
                };
                &TABLE
            };

            /// Bytes it takes.
            pub const BYTES: usize = $(size_of::<$kind>() +)+ 0;

            /// Appends it in little-endian order.
            pub fn write(&self, out: &mut Vec<u8>) {
                $(out.extend_from_slice(&self.$field.to_le_bytes());)+
            }
        }
    };
}

packed!(
    /// What stands before the records.
    Header {
        /// Always [`FRAME_MAGIC`].
        magic: u32,
        /// Number of the snapshot, wrapping. A jump of more than one is normal: only the newest snapshot is sent.
        sequence: u32,
        /// How many records follow.
        count: u32,
        /// Node time at which the frame was made, in milliseconds, wrapping.
        server_time_ms: u32,
    }
);

packed!(
    /// One vehicle.
    Record {
        /// The vehicle's id.
        id: u16,
        /// Code of its flight mode.
        mode: u8,
        /// Bits, see [`flag`].
        flags: u8,
        /// Latitude in 1e-7 degrees.
        latitude_e7: i32,
        /// Longitude in 1e-7 degrees.
        longitude_e7: i32,
        /// Altitude above mean sea level in millimetres.
        altitude_amsl_mm: i32,
        /// Velocity north in cm/s.
        velocity_north_cm_s: i16,
        /// Velocity east in cm/s.
        velocity_east_cm_s: i16,
        /// Velocity down in cm/s.
        velocity_down_cm_s: i16,
        /// Roll in hundredths of a degree.
        roll_cdeg: i16,
        /// Pitch in hundredths of a degree.
        pitch_cdeg: i16,
        /// Yaw in hundredths of a degree clockwise from north, 0..36000.
        yaw_cdeg: u16,
        /// Battery charge in percent; 255 unknown.
        battery_percent: u8,
        /// Frames lost on the link in percent.
        loss_percent: u8,
        /// Satellites used.
        satellites: u8,
        /// Code of the satellite fix.
        fix: u8,
        /// Battery voltage in 10 mV; 0 unknown.
        battery_10_mv: u16,
        /// Milliseconds since the vehicle was last heard, at `server_time_ms`; 65535 also stands for more.
        age_ms: u16,
        /// Node time at which the position was measured, in milliseconds, wrapping.
        measured_ms: u32,
        /// Latitude of its slot in 1e-7 degrees.
        slot_latitude_e7: i32,
        /// Longitude of its slot in 1e-7 degrees.
        slot_longitude_e7: i32,
        /// Altitude of its slot above mean sea level in millimetres.
        slot_altitude_amsl_mm: i32,
        /// Code of its flight state.
        flight_state: u8,
        /// Code of landed or not.
        landed: u8,
        /// Distance to its slot or goal in cm; 65535 unknown.
        tracking_error_cm: u16,
        /// Round trip on the link in 0.1 ms; 65535 unknown.
        round_trip_100_us: u16,
        /// Setpoints sent in 0.1 per second.
        setpoint_rate_dhz: u16,
        /// Incarnation of its actor.
        actor_incarnation: u16,
        /// Incarnation of its UAV-model plugin instance.
        model_incarnation: u16,
    }
);

const _: () = assert!(Header::BYTES == HEADER_BYTES && Record::BYTES == RECORD_BYTES);

/// The bits of [`Record::flags`].
pub mod flag {
    /// Motors armed.
    pub const ARMED: u8 = 1;
    /// Frames of it arrive.
    pub const CONNECTED: u8 = 2;
    /// Latitude, longitude and altitude are measured; without it they are 0 and mean nothing.
    pub const POSITION: u8 = 4;
    /// It has a slot or goal; without it the slot's numbers mean nothing.
    pub const SLOT: u8 = 8;
    /// Its autopilot would arm.
    pub const READY: u8 = 16;
    /// It leads the formation.
    pub const LEADER: u8 = 32;
    /// A pilot or the autopilot's own failsafe flies it.
    pub const PILOT: u8 = 64;
    /// Its model says that an operator must look, or its actor or model has been given up.
    pub const FAULTED: u8 = 128;

    /// All bits with the names the browser knows them by.
    pub const ALL: &[(&str, u8)] = &[
        ("armed", ARMED),
        ("connected", CONNECTED),
        ("position", POSITION),
        ("slot", SLOT),
        ("ready", READY),
        ("leader", LEADER),
        ("pilot", PILOT),
        ("faulted", FAULTED),
    ];
}

/// The frame of a snapshot. `now` is when it is made: ages grow even if no newer snapshot comes.
#[must_use]
pub fn encode(snapshot: &FleetSnapshot, now: NodeTime) -> Vec<u8> {
    let vehicles = snapshot.vehicles.iter().take(MAX_RECORDS);
    let mut out = Vec::with_capacity(HEADER_BYTES + vehicles.len() * RECORD_BYTES);
    Header {
        magic: FRAME_MAGIC,
        sequence: snapshot.sequence as u32,
        count: vehicles.len() as u32,
        server_time_ms: wrapping_ms(now),
    }
    .write(&mut out);
    let snapshot_age_s = now.seconds_since(snapshot.time).max(0.0);
    for vehicle in vehicles {
        record(vehicle, snapshot.frame.as_ref(), snapshot_age_s).write(&mut out);
    }
    out
}

/// One vehicle's record. `snapshot_age_s` is how old the picture of it is.
#[must_use]
pub fn record(vehicle: &VehicleSnapshot, frame: Option<&SwarmFrame>, snapshot_age_s: f64) -> Record {
    let place = position(vehicle, frame);
    let slot = frame
        .zip(vehicle.slot)
        .map(|(frame, slot)| frame.geodetic(&slot))
        .filter(Geodetic::is_valid);
    let kinematics = vehicle.kinematics.unwrap_or_default();
    let (latitude_e7, longitude_e7, altitude_amsl_mm) = packed_place(place);
    let (slot_latitude_e7, slot_longitude_e7, slot_altitude_amsl_mm) = packed_place(slot);
    Record {
        id: vehicle.id.0,
        mode: vehicle.mode.code(),
        flags: flags(vehicle, place.is_some(), slot.is_some()),
        latitude_e7,
        longitude_e7,
        altitude_amsl_mm,
        velocity_north_cm_s: (kinematics.velocity.north_m_s * 100.0).round() as i16,
        velocity_east_cm_s: (kinematics.velocity.east_m_s * 100.0).round() as i16,
        velocity_down_cm_s: (kinematics.velocity.down_m_s * 100.0).round() as i16,
        roll_cdeg: (f64::from(vehicle.roll_rad).to_degrees() * 100.0).round() as i16,
        pitch_cdeg: (f64::from(vehicle.pitch_rad).to_degrees() * 100.0).round() as i16,
        yaw_cdeg: yaw_cdeg(kinematics.yaw_rad),
        battery_percent: vehicle.battery.remaining.map_or(UNKNOWN_PERCENT, percent),
        loss_percent: percent(vehicle.link.loss),
        satellites: vehicle.gnss.satellites,
        fix: vehicle.gnss.fix.code(),
        battery_10_mv: vehicle
            .battery
            .voltage_v
            .map_or(UNKNOWN_VOLTAGE, |v| (v * 100.0).round() as u16),
        age_ms: ((vehicle.age_s.max(0.0) + snapshot_age_s) * 1e3).round() as u16,
        measured_ms: wrapping_ms(kinematics.measured),
        slot_latitude_e7,
        slot_longitude_e7,
        slot_altitude_amsl_mm,
        flight_state: vehicle.flight_state.code(),
        landed: vehicle.landed.code(),
        tracking_error_cm: known_u16(vehicle.tracking_error_m.map(|m| m * 100.0)),
        round_trip_100_us: known_u16(vehicle.link.round_trip_s.map(|s| f64::from(s) * 1e4)),
        setpoint_rate_dhz: (vehicle.link.setpoint_rate_hz * 10.0).round() as u16,
        actor_incarnation: u16::try_from(vehicle.actor.incarnation.0).unwrap_or(u16::MAX),
        model_incarnation: u16::try_from(vehicle.model.incarnation.0).unwrap_or(u16::MAX),
    }
}

/// Where the vehicle is: as it says itself, or else from its place in the swarm's frame.
fn position(vehicle: &VehicleSnapshot, frame: Option<&SwarmFrame>) -> Option<Geodetic> {
    let from_frame = || {
        frame
            .zip(vehicle.kinematics)
            .map(|(frame, k)| frame.geodetic(&k.position))
    };
    vehicle.global.or_else(from_frame).filter(Geodetic::is_valid)
}

fn flags(vehicle: &VehicleSnapshot, has_position: bool, has_slot: bool) -> u8 {
    let given_up = [vehicle.actor.status, vehicle.model.status].contains(&ActorStatus::GivenUp);
    let set = |is_set: bool, bit: u8| if is_set { bit } else { 0 };
    set(vehicle.armed, flag::ARMED)
        | set(vehicle.link.connected, flag::CONNECTED)
        | set(has_position, flag::POSITION)
        | set(has_slot, flag::SLOT)
        | set(vehicle.ready_to_arm == Some(true), flag::READY)
        | set(vehicle.is_leader, flag::LEADER)
        | set(vehicle.flight_state == FlightState::PilotControl, flag::PILOT)
        | set(given_up || vehicle.flight_state == FlightState::Faulted, flag::FAULTED)
}

/// Latitude and longitude in 1e-7 degrees, altitude in millimetres; zeros, marked by a flag, if there is no place.
fn packed_place(place: Option<Geodetic>) -> (i32, i32, i32) {
    place.map_or((0, 0, 0), |place| {
        (
            (place.latitude_deg * 1e7).round() as i32,
            (place.longitude_deg * 1e7).round() as i32,
            (place.altitude_amsl_m * 1e3).round() as i32,
        )
    })
}

/// Hundredths of a degree in 0..36000.
fn yaw_cdeg(yaw_rad: f64) -> u16 {
    let cdeg = (yaw_rad.to_degrees() * 100.0).rem_euclid(36_000.0).round() as u16;
    if cdeg >= 36_000 { 0 } else { cdeg }
}

/// A share of 0..=1 as percent.
fn percent(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * 100.0).round() as u8
}

/// A number that fits below the value that stands for "unknown", or that value.
fn known_u16(value: Option<f64>) -> u16 {
    value
        .filter(|v| v.is_finite())
        .map_or(UNKNOWN_U16, |v| v.round().clamp(0.0, f64::from(UNKNOWN_U16 - 1)) as u16)
}

/// Milliseconds of node time in 32 bits; they start anew every 49.7 days.
fn wrapping_ms(time: NodeTime) -> u32 {
    (time.0 / 1000) as u32
}

#[cfg(test)]
mod tests;
