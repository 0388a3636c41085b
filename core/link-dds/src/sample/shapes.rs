//! From each shape of a message to what Skein takes from it.
//!
//! Must never do: judge. A field that a release does not have is left out, not made up.

use super::{
    Ack, Attitude, BatteryReport, GnssReport, Landed, LocalPosition, Place, Sample, Status, Timesync, Validity,
};
use skein_domain::Geodetic;

macro_rules! each {
    ($name:ident in $($release:ident),+ => |$message:ident| $sample:expr) => {
        $(impl From<$crate::messages::$release::$name> for Sample {
            fn from($message: $crate::messages::$release::$name) -> Self {
                $sample
            }
        })+
    };
}

each!(VehicleStatus in v1_15, v1_16, v1_18 => |message| Self::Status(Status {
    stamp_us: message.timestamp,
    system_id: message.system_id,
    arming_state: message.arming_state,
    nav_state: message.nav_state,
    failsafe: message.failsafe,
    ready_to_arm: message.pre_flight_checks_pass,
    took_off: message.takeoff_time != 0,
}));

each!(VehicleLocalPosition in v1_15, v1_16, v1_17 => |message| Self::Local(LocalPosition {
    stamp_us: message.timestamp,
    measured_us: message.timestamp_sample,
    valid: Validity {
        horizontal: message.xy_valid,
        vertical: message.z_valid,
        velocity_horizontal: message.v_xy_valid,
        velocity_vertical: message.v_z_valid,
    },
    position_m: [message.x, message.y, message.z],
    velocity_m_s: [message.vx, message.vy, message.vz],
    origin_deg: message.xy_global.then_some([message.ref_lat, message.ref_lon]),
    origin_altitude_m: message.z_global.then_some(message.ref_alt),
    accuracy_m: [message.eph, message.epv],
    dead_reckoning: message.dead_reckoning,
}));

fn place(latitude_deg: f64, longitude_deg: f64, altitude_amsl_m: f64) -> Geodetic {
    Geodetic {
        latitude_deg,
        longitude_deg,
        altitude_amsl_m,
    }
}

each!(VehicleGlobalPosition in v1_15 => |message| Self::Global(Place {
    stamp_us: message.timestamp,
    measured_us: message.timestamp_sample,
    // This release sends it only while it is valid.
    valid: true,
    place: place(message.lat, message.lon, message.alt.into()),
}));

each!(VehicleGlobalPosition in v1_16 => |message| Self::Global(Place {
    stamp_us: message.timestamp,
    measured_us: message.timestamp_sample,
    valid: message.lat_lon_valid && message.alt_valid,
    place: place(message.lat, message.lon, message.alt.into()),
}));

each!(VehicleAttitude in v1_15 => |message| Self::Attitude(Attitude {
    stamp_us: message.timestamp,
    quaternion: message.q,
}));

each!(VehicleLandDetected in v1_15 => |message| Self::Landed(Landed {
    stamp_us: message.timestamp,
    landed: message.landed,
}));

each!(BatteryStatus in v1_15, v1_16, v1_17 => |message| {
    Self::Battery(BatteryReport {
        stamp_us: message.timestamp,
        id: message.id,
        connected: message.connected,
        voltage_v: message.voltage_v,
        current_a: message.current_a,
        remaining: message.remaining,
        discharged_mah: message.discharged_mah,
        time_remaining_s: message.time_remaining_s,
    })
});

each!(SensorGps in v1_15, v1_17, v1_18 => |message| Self::Gnss(GnssReport {
    stamp_us: message.timestamp,
    fix_type: message.fix_type,
    satellites: message.satellites_used,
    horizontal_accuracy_m: message.eph,
    place: place(message.latitude_deg, message.longitude_deg, message.altitude_msl_m),
}));

each!(HomePosition in v1_15, v1_17, later => |message| Self::Home(Place {
    stamp_us: message.timestamp,
    measured_us: message.timestamp,
    valid: message.valid_hpos && message.valid_alt,
    place: place(message.lat, message.lon, message.alt.into()),
}));

each!(TimesyncStatus in v1_15 => |message| Self::Timesync(Timesync {
    stamp_us: message.timestamp,
    source: message.source_protocol,
    offset_us: message.estimated_offset,
    round_trip_us: message.round_trip_time,
}));

each!(VehicleCommandAck in v1_15, v1_18 => |message| Self::Ack(Ack {
    command: message.command,
    result: message.result,
    target_system: message.target_system,
    target_component: message.target_component,
}));
