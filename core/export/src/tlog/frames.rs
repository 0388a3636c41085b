//! What a recording tells, as messages of MAVLink.
//!
//! Must never do: let a number run over: one that has no place in its field becomes the nearest that has.

use mavlink::dialects::common::{
    ATTITUDE_DATA, GLOBAL_POSITION_INT_DATA, GPS_RAW_INT_DATA, GpsFixType, HEARTBEAT_DATA, LOCAL_POSITION_NED_DATA,
    MavAutopilot, MavFrame, MavModeFlag, MavSeverity, MavState, MavType, POSITION_TARGET_LOCAL_NED_DATA,
    PositionTargetTypemask as Mask, STATUSTEXT_DATA, SYS_STATUS_DATA,
};
use mavlink::types::CharArray;
use skein_domain::exchange::Severity;
use skein_domain::telemetry::{GnssFix, VehicleKinematics};
use skein_domain::{Geodetic, Setpoint};
use skein_px4::modes::Px4Mode;
use skein_recording::VehicleTelemetry;
use skein_view::EventRecord;
use std::f64::consts::TAU;

/// Longest text of one STATUSTEXT.
const TEXT_CHUNK: usize = 50;
/// No text is told in more frames than this.
const CHUNKS: usize = 8;
/// Words of MAVLink for what is not known.
const UNKNOWN_U16: u16 = u16::MAX;

fn e7(degrees: f64) -> i32 {
    (degrees * 1e7).round() as i32
}

fn mm(metres: f64) -> i32 {
    (metres * 1e3).round() as i32
}

fn cm_s(m_s: f64) -> i16 {
    (m_s * 1e2).round() as i16
}

fn centidegrees(angle_rad: f64) -> u16 {
    let degrees = angle_rad.rem_euclid(TAU).to_degrees();
    (degrees * 1e2).round().min(35_999.0) as u16
}

/// What kind of vehicle it is was not recorded.
pub(super) fn heartbeat(of: &VehicleTelemetry) -> HEARTBEAT_DATA {
    let mut flags = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
    if of.armed {
        flags |= MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
    }
    let status = if of.armed {
        MavState::MAV_STATE_ACTIVE
    } else {
        MavState::MAV_STATE_STANDBY
    };
    HEARTBEAT_DATA {
        custom_mode: Px4Mode::of(of.mode).map_or(0, Px4Mode::custom_mode),
        mavtype: MavType::MAV_TYPE_GENERIC,
        autopilot: MavAutopilot::MAV_AUTOPILOT_PX4,
        base_mode: flags,
        system_status: status,
        mavlink_version: 3,
    }
}

pub(super) fn system_status(of: &VehicleTelemetry) -> SYS_STATUS_DATA {
    let battery = &of.battery;
    SYS_STATUS_DATA {
        voltage_battery: battery.voltage_v.map_or(UNKNOWN_U16, |v| (v * 1e3).round() as u16),
        current_battery: battery.current_a.map_or(-1, |a| (a * 1e2).round() as i16),
        battery_remaining: battery.remaining.map_or(-1, |share| (share * 1e2).round() as i8),
        ..SYS_STATUS_DATA::default()
    }
}

pub(super) fn satellites(time_us: u64, of: &VehicleTelemetry) -> GPS_RAW_INT_DATA {
    let fix = match of.gnss.fix {
        GnssFix::Unknown => GpsFixType::GPS_FIX_TYPE_NO_GPS,
        GnssFix::None => GpsFixType::GPS_FIX_TYPE_NO_FIX,
        GnssFix::TwoD => GpsFixType::GPS_FIX_TYPE_2D_FIX,
        GnssFix::ThreeD => GpsFixType::GPS_FIX_TYPE_3D_FIX,
        GnssFix::Dgps => GpsFixType::GPS_FIX_TYPE_DGPS,
        GnssFix::RtkFloat => GpsFixType::GPS_FIX_TYPE_RTK_FLOAT,
        GnssFix::RtkFixed => GpsFixType::GPS_FIX_TYPE_RTK_FIXED,
    };
    // The receiver's own place was not recorded, the estimator's was.
    let place = of.global.unwrap_or_default();
    GPS_RAW_INT_DATA {
        time_usec: time_us,
        fix_type: fix,
        lat: e7(place.latitude_deg),
        lon: e7(place.longitude_deg),
        alt: mm(place.altitude_amsl_m),
        eph: UNKNOWN_U16,
        epv: UNKNOWN_U16,
        vel: UNKNOWN_U16,
        cog: UNKNOWN_U16,
        satellites_visible: of.gnss.satellites,
        h_acc: of.gnss.horizontal_accuracy_m.map_or(0, |m| (m * 1e3).round() as u32),
        ..GPS_RAW_INT_DATA::default()
    }
}

/// Rates were not recorded.
pub(super) fn attitude(up_ms: u32, of: &VehicleTelemetry) -> ATTITUDE_DATA {
    ATTITUDE_DATA {
        time_boot_ms: up_ms,
        roll: of.roll_rad,
        pitch: of.pitch_rad,
        yaw: of.kinematics.map_or(0.0, |moves| moves.yaw_rad as f32),
        ..ATTITUDE_DATA::default()
    }
}

/// In the swarm's frame: the vehicle's own was not recorded.
pub(super) fn local(up_ms: u32, of: &VehicleKinematics) -> LOCAL_POSITION_NED_DATA {
    LOCAL_POSITION_NED_DATA {
        time_boot_ms: up_ms,
        x: of.position.north_m as f32,
        y: of.position.east_m as f32,
        z: of.position.down_m as f32,
        vx: of.velocity.north_m_s as f32,
        vy: of.velocity.east_m_s as f32,
        vz: of.velocity.down_m_s as f32,
    }
}

pub(super) fn global(up_ms: u32, place: &Geodetic, of: &VehicleTelemetry) -> GLOBAL_POSITION_INT_DATA {
    let moves = of.kinematics;
    let velocity = moves.map(|moves| moves.velocity).unwrap_or_default();
    GLOBAL_POSITION_INT_DATA {
        time_boot_ms: up_ms,
        lat: e7(place.latitude_deg),
        lon: e7(place.longitude_deg),
        alt: mm(place.altitude_amsl_m),
        relative_alt: mm(moves.map_or(0.0, |moves| -moves.position.down_m)),
        vx: cm_s(velocity.north_m_s),
        vy: cm_s(velocity.east_m_s),
        vz: cm_s(velocity.down_m_s),
        hdg: moves.map_or(UNKNOWN_U16, |moves| centidegrees(moves.yaw_rad)),
    }
}

/// A setpoint as it was flown, in the swarm's frame.
pub(super) fn target(up_ms: u32, of: &Setpoint) -> POSITION_TARGET_LOCAL_NED_DATA {
    let ignore = |absent: bool, mask: Mask| if absent { mask } else { Mask::empty() };
    let no_position = of.position.is_none();
    let no_velocity = of.velocity.is_none();
    let no_acceleration = of.acceleration.is_none();
    let type_mask = ignore(no_position, Mask::POSITION_TARGET_TYPEMASK_X_IGNORE)
        | ignore(no_position, Mask::POSITION_TARGET_TYPEMASK_Y_IGNORE)
        | ignore(no_position, Mask::POSITION_TARGET_TYPEMASK_Z_IGNORE)
        | ignore(no_velocity, Mask::POSITION_TARGET_TYPEMASK_VX_IGNORE)
        | ignore(no_velocity, Mask::POSITION_TARGET_TYPEMASK_VY_IGNORE)
        | ignore(no_velocity, Mask::POSITION_TARGET_TYPEMASK_VZ_IGNORE)
        | ignore(no_acceleration, Mask::POSITION_TARGET_TYPEMASK_AX_IGNORE)
        | ignore(no_acceleration, Mask::POSITION_TARGET_TYPEMASK_AY_IGNORE)
        | ignore(no_acceleration, Mask::POSITION_TARGET_TYPEMASK_AZ_IGNORE)
        | ignore(of.yaw_rad.is_none(), Mask::POSITION_TARGET_TYPEMASK_YAW_IGNORE)
        | ignore(
            of.yaw_rate_rad_s.is_none(),
            Mask::POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE,
        );
    let position = of.position.unwrap_or_default();
    let velocity = of.velocity.unwrap_or_default();
    let acceleration = of.acceleration.unwrap_or_default();
    POSITION_TARGET_LOCAL_NED_DATA {
        time_boot_ms: up_ms,
        x: position.north_m as f32,
        y: position.east_m as f32,
        z: position.down_m as f32,
        vx: velocity.north_m_s as f32,
        vy: velocity.east_m_s as f32,
        vz: velocity.down_m_s as f32,
        afx: acceleration.north_m_s2 as f32,
        afy: acceleration.east_m_s2 as f32,
        afz: acceleration.down_m_s2 as f32,
        yaw: of.yaw_rad.unwrap_or_default() as f32,
        yaw_rate: of.yaw_rate_rad_s.unwrap_or_default() as f32,
        type_mask,
        coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
    }
}

/// An event as a text, in as many frames as it takes.
pub(super) fn texts(event: &EventRecord, id: u16) -> Vec<STATUSTEXT_DATA> {
    let severity = match event.severity {
        Severity::Info => MavSeverity::MAV_SEVERITY_INFO,
        Severity::Advisory => MavSeverity::MAV_SEVERITY_NOTICE,
        Severity::Warning => MavSeverity::MAV_SEVERITY_WARNING,
        Severity::Critical => MavSeverity::MAV_SEVERITY_CRITICAL,
    };
    // Ground stations read ASCII.
    let shown = |c: char| {
        if c.is_ascii() && !c.is_ascii_control() {
            c as u8
        } else {
            b'?'
        }
    };
    let text: Vec<u8> = event.text.chars().map(shown).collect();
    let is_short = text.len() <= TEXT_CHUNK;
    let chunks = text.chunks(TEXT_CHUNK).take(CHUNKS).enumerate();
    chunks
        .map(|(chunk_seq, chunk)| {
            let mut bytes = [0; TEXT_CHUNK];
            bytes.iter_mut().zip(chunk).for_each(|(to, from)| *to = *from);
            STATUSTEXT_DATA {
                severity,
                text: CharArray::new(bytes),
                // A number is what parts of one text are known by.
                id: if is_short { 0 } else { id },
                chunk_seq: chunk_seq as u8,
            }
        })
        .collect()
}
