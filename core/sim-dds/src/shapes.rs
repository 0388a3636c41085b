//! From what a simulated autopilot publishes to the fields of PX4's messages, and from PX4's messages to what it takes.
//!
//! Must never do: make a value up that the simulation does not know. Such fields are zero, or not a number where PX4 says so.

use crate::octets::Record;
use skein_domain::FlightMode;
use skein_link_dds::definitions::{Release, Topic};
use skein_link_dds::messages::incoming::{OffboardControlMode, TrajectorySetpoint, VehicleCommand};
use skein_sim::topics::{
    Asked, AskedCommand, AskedMode, AskedSetpoint, BatteryReport, CommandAnswer, GlobalReport, GnssReport, HomeReport,
    LocalReport, Published, StatusReport, TimesyncReport,
};

/// `ARMING_STATE_DISARMED`; armed is one more.
const DISARMED: u8 = 1;
/// `VEHICLE_TYPE_ROTARY_WING` and `MAV_TYPE_QUADROTOR`.
const ROTARY_WING: f64 = 1.0;
const QUADROTOR: f64 = 2.0;
/// Component id of an autopilot.
const AUTOPILOT: f64 = 1.0;
/// `SOURCE_PROTOCOL_DDS`, and what a round trip between PX4 and an agent on the same host takes in microseconds.
const WITH_AGENT: f64 = 2.0;
const ROUND_TRIP_US: f64 = 600.0;
/// `FIX_TYPE_3D`.
const FIX: f64 = 3.0;
/// Height of the ellipsoid below the mean sea level in metres, about where the simulation is.
const UNDULATION_M: f64 = 47.2;

/// PX4's number for what it does.
fn nav_state(mode: FlightMode) -> u8 {
    match mode {
        FlightMode::Manual | FlightMode::Unknown => 0,
        FlightMode::Altitude => 1,
        FlightMode::Position => 2,
        FlightMode::Mission => 3,
        FlightMode::Hold | FlightMode::Ready => 4,
        FlightMode::Return => 5,
        FlightMode::Acro => 10,
        FlightMode::Descend => 12,
        FlightMode::Termination => 13,
        FlightMode::Offboard => 14,
        FlightMode::Stabilized => 15,
        FlightMode::TakeOff => 17,
        FlightMode::Land => 18,
    }
}

fn is(truth: bool) -> f64 {
    f64::from(u8::from(truth))
}

fn stamped(stamp_us: u64) -> Record {
    let stamp = stamp_us as f64;
    Record::default().and([("timestamp", stamp)])
}

fn measured(stamp_us: u64) -> Record {
    stamped(stamp_us).and([("timestamp_sample", stamp_us as f64)])
}

/// What stands in a release's message, and its topic; `None` for what that release does not publish.
pub(crate) fn outgoing(published: &Published, release: Release) -> Option<(Topic, Record)> {
    Some(match published {
        Published::Status(report) => (Topic::Status, status(report)),
        Published::Local(report) => (Topic::LocalPosition, local(report)),
        Published::Attitude(report) => {
            let q = report.turned;
            let record = measured(report.stamp_us)
                .with("q", [q.w, q.i, q.j, q.k])
                .with("delta_q_reset", [1.0]);
            (Topic::Attitude, record)
        }
        // Without a word for it in the message, it is published only while it is valid.
        Published::Global(report) if release == Release::V1_15 && !report.horizontal_valid => return None,
        Published::Global(report) => (Topic::GlobalPosition, global(report)),
        Published::Landed(report) => {
            let landed = is(report.landed);
            let record = stamped(report.stamp_us).and([
                ("landed", landed),
                ("maybe_landed", landed),
                ("ground_contact", landed),
                ("at_rest", landed),
            ]);
            (Topic::LandDetected, record)
        }
        Published::Battery(report) => (Topic::Battery, battery(report)),
        Published::Gnss(report) => (Topic::Gnss, gnss(report)),
        Published::Home(report) => (Topic::Home, home(report)),
        Published::Timesync(report) => (Topic::Timesync, timesync(report)),
        Published::CommandAnswer(answer) => (Topic::CommandAck, ack(answer)),
    })
}

fn status(report: &StatusReport) -> Record {
    stamped(report.stamp_us).and([
        ("armed_time", report.armed_us as f64),
        ("arming_state", f64::from(DISARMED + u8::from(report.armed))),
        ("nav_state", nav_state(report.mode).into()),
        ("nav_state_user_intention", nav_state(report.intention).into()),
        ("nav_state_display", nav_state(report.mode).into()),
        ("accepts_offboard_setpoints", is(report.mode == FlightMode::Offboard)),
        ("vehicle_type", ROTARY_WING),
        ("failsafe", is(report.failsafe)),
        ("system_type", QUADROTOR),
        ("system_id", report.system_id.into()),
        ("component_id", AUTOPILOT),
        ("power_input_valid", 1.0),
        ("pre_flight_checks_pass", is(report.checks_pass)),
    ])
}

fn local(report: &LocalReport) -> Record {
    let (p, v, a) = (report.position_m, report.velocity_m_s, report.acceleration_m_s2);
    let horizontal = is(report.horizontal_valid);
    let vertical = is(report.vertical_valid);
    let record = measured(report.stamp_us).and([
        ("xy_valid", horizontal),
        ("z_valid", vertical),
        ("v_xy_valid", horizontal),
        ("v_z_valid", vertical),
        ("x", p.x),
        ("y", p.y),
        ("z", p.z),
        ("vx", v.x),
        ("vy", v.y),
        ("vz", v.z),
        ("z_deriv", v.z),
        ("ax", a.x),
        ("ay", a.y),
        ("az", a.z),
        ("heading", report.yaw_rad),
        ("unaided_heading", f64::NAN),
        ("heading_good_for_control", 1.0),
        ("dist_bottom", report.height_m),
        ("dist_bottom_valid", 1.0),
        ("eph", report.accuracy_horizontal_m),
        ("epv", report.accuracy_vertical_m),
        ("evh", 0.1),
        ("evv", 0.1),
        ("dead_reckoning", is(report.dead_reckoning)),
        ("vxy_max", f64::INFINITY),
        ("vz_max", f64::INFINITY),
        ("hagl_min", f64::INFINITY),
        ("hagl_max", f64::INFINITY),
        ("hagl_max_z", f64::INFINITY),
        ("hagl_max_xy", f64::INFINITY),
    ]);
    let Some(origin) = report.origin else { return record };
    record.and([
        ("xy_global", 1.0),
        ("z_global", 1.0),
        ("ref_timestamp", report.origin_us as f64),
        ("ref_lat", origin.latitude_deg),
        ("ref_lon", origin.longitude_deg),
        ("ref_alt", origin.altitude_amsl_m),
    ])
}

fn global(report: &GlobalReport) -> Record {
    measured(report.stamp_us).and([
        ("lat", report.place.latitude_deg),
        ("lon", report.place.longitude_deg),
        ("alt", report.place.altitude_amsl_m),
        ("alt_ellipsoid", report.place.altitude_amsl_m + UNDULATION_M),
        ("lat_lon_valid", is(report.horizontal_valid)),
        ("alt_valid", 1.0),
        ("eph", report.accuracy_horizontal_m),
        ("epv", report.accuracy_vertical_m),
        ("terrain_alt", f64::NAN),
        ("dead_reckoning", is(report.dead_reckoning)),
    ])
}

fn battery(report: &BatteryReport) -> Record {
    stamped(report.stamp_us).and([
        ("connected", 1.0),
        ("voltage_v", report.voltage_v),
        ("voltage_filtered_v", report.voltage_v),
        ("current_a", report.current_a),
        ("current_filtered_a", report.current_a),
        ("current_average_a", report.current_a),
        ("discharged_mah", report.consumed_mah),
        ("remaining", report.charge),
        ("scale", 1.0),
        ("time_remaining_s", report.remaining_s),
        ("temperature", f64::NAN),
        ("cell_count", 4.0),
        ("id", 1.0),
        ("warning", report.warning.into()),
    ])
}

fn gnss(report: &GnssReport) -> Record {
    let record = measured(report.stamp_us).and([
        ("eph", report.accuracy_horizontal_m),
        ("epv", report.accuracy_vertical_m),
        ("satellites_used", report.satellites.into()),
        ("time_utc_usec", report.utc_us as f64),
        ("heading", f64::NAN),
    ]);
    if !report.fixed {
        return record;
    }
    let v = report.velocity_m_s;
    record.and([
        ("fix_type", FIX),
        ("latitude_deg", report.place.latitude_deg),
        ("longitude_deg", report.place.longitude_deg),
        ("altitude_msl_m", report.place.altitude_amsl_m),
        ("altitude_ellipsoid_m", report.place.altitude_amsl_m + UNDULATION_M),
        ("vel_m_s", v.norm()),
        ("vel_n_m_s", v.x),
        ("vel_e_m_s", v.y),
        ("vel_d_m_s", v.z),
        ("cog_rad", v.y.atan2(v.x)),
        ("vel_ned_valid", 1.0),
    ])
}

fn home(report: &HomeReport) -> Record {
    stamped(report.stamp_us).and([
        ("lat", report.place.latitude_deg),
        ("lon", report.place.longitude_deg),
        ("alt", report.place.altitude_amsl_m),
        ("x", report.position_m.x),
        ("y", report.position_m.y),
        ("z", report.position_m.z),
        ("valid_alt", 1.0),
        ("valid_hpos", 1.0),
        ("valid_lpos", 1.0),
        ("update_count", report.count.into()),
    ])
}

fn timesync(report: &TimesyncReport) -> Record {
    let offset = report.offset_us as f64;
    stamped(report.stamp_us).and([
        ("source_protocol", WITH_AGENT),
        ("remote_timestamp", report.stamp_us as f64 - offset),
        ("observed_offset", offset),
        ("estimated_offset", offset),
        ("round_trip_time", ROUND_TRIP_US),
    ])
}

fn ack(answer: &CommandAnswer) -> Record {
    stamped(answer.stamp_us).and([
        ("command", answer.command.into()),
        ("result", answer.result.into()),
        ("target_system", answer.to_system.into()),
        ("target_component", answer.to_component.into()),
    ])
}

/// A command as the autopilot takes it.
pub(crate) fn command(c: &VehicleCommand) -> Asked {
    Asked::Command(AskedCommand {
        command: c.command,
        param: [c.param1, c.param2, c.param3, c.param4],
        place: [c.param5, c.param6, c.param7.into()],
        to_system: c.target_system,
        to_component: c.target_component,
        from_system: c.source_system,
        from_component: c.source_component,
    })
}

/// What of the setpoints counts, as the autopilot takes it. Attitudes, rates and motors are not what the simulation can follow.
pub(crate) fn mode(m: &OffboardControlMode) -> Asked {
    Asked::Mode(AskedMode {
        stamp_us: m.timestamp,
        follows: m.position || m.velocity || m.acceleration,
    })
}

/// A setpoint as the autopilot takes it.
pub(crate) fn setpoint(s: &TrajectorySetpoint) -> Asked {
    let three = |values: [f32; 3]| values.map(f64::from).into();
    Asked::Setpoint(AskedSetpoint {
        position_m: three(s.position),
        velocity_m_s: three(s.velocity),
        acceleration_m_s2: three(s.acceleration),
        yaw_rad: s.yaw.into(),
        yaw_rate_rad_s: s.yawspeed.into(),
    })
}

#[cfg(test)]
mod tests;
