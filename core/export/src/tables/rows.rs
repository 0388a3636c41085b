//! Which columns there are.
//!
//! Must never do: change a column's name or unit without saying so in the documentation: programs of others stand on them.

use super::{Cell, Row};
use crate::overview::word;
use crate::told::Told;
use serde::Serialize;
use skein_domain::{PositionNed, Setpoint, VelocityNed};
use skein_recording::{SetpointRecord, VehicleTelemetry};
use skein_view::EventRecord;

fn real(value: Option<f64>) -> Cell {
    Cell::Real(value.filter(|value| value.is_finite()))
}

fn single(value: Option<f32>) -> Cell {
    // By its shortest decimal: 0.1 stays 0.1.
    real(value.and_then(|value| value.to_string().parse().ok()))
}

fn json(value: &impl Serialize) -> Option<String> {
    serde_json::to_string(value).ok()
}

fn begin(told: &Told, vehicle: Option<u16>) -> Row {
    vec![
        ("time_utc", Cell::Moment(told.at_ns)),
        ("time_s", real(Some(told.time_s))),
        ("vehicle", Cell::Count(vehicle.map(i64::from))),
    ]
}

fn position(row: &mut Row, names: [&'static str; 3], of: Option<PositionNed>) {
    let [north, east, down] = names;
    row.push((north, real(of.map(|of| of.north_m))));
    row.push((east, real(of.map(|of| of.east_m))));
    row.push((down, real(of.map(|of| of.down_m))));
}

fn velocity(row: &mut Row, names: [&'static str; 3], of: Option<VelocityNed>) {
    let [north, east, down] = names;
    row.push((north, real(of.map(|of| of.north_m_s))));
    row.push((east, real(of.map(|of| of.east_m_s))));
    row.push((down, real(of.map(|of| of.down_m_s))));
}

/// Of a vehicle.
pub fn telemetry(told: &Told, of: &VehicleTelemetry) -> Row {
    let mut row = begin(told, Some(of.vehicle.0));
    let moves = of.kinematics;
    position(&mut row, ["north_m", "east_m", "down_m"], moves.map(|of| of.position));
    let names = ["velocity_north_m_s", "velocity_east_m_s", "velocity_down_m_s"];
    velocity(&mut row, names, moves.map(|of| of.velocity));
    let of_link = &of.link;
    row.extend([
        ("roll_rad", single(Some(of.roll_rad))),
        ("pitch_rad", single(Some(of.pitch_rad))),
        ("yaw_rad", real(moves.map(|of| of.yaw_rad))),
        ("latitude_deg", real(of.global.map(|of| of.latitude_deg))),
        ("longitude_deg", real(of.global.map(|of| of.longitude_deg))),
        ("altitude_amsl_m", real(of.global.map(|of| of.altitude_amsl_m))),
        ("flight_state", Cell::Text(Some(of.flight_state.word()))),
        ("mode", Cell::Text(Some(of.mode.word()))),
        ("armed", Cell::Truth(Some(of.armed))),
        ("landed", Cell::Text(Some(of.landed.word()))),
        ("battery_remaining", single(of.battery.remaining)),
        ("battery_voltage_v", single(of.battery.voltage_v)),
        ("battery_current_a", single(of.battery.current_a)),
        ("gnss_fix", Cell::Text(Some(of.gnss.fix.word()))),
        ("gnss_satellites", Cell::Count(Some(of.gnss.satellites.into()))),
        ("gnss_horizontal_accuracy_m", single(of.gnss.horizontal_accuracy_m)),
        ("link_connected", Cell::Truth(Some(of_link.connected))),
        ("link_loss", single(Some(of_link.loss))),
        ("link_round_trip_s", single(of_link.round_trip_s)),
        ("link_receive_rate_hz", single(Some(of_link.receive_rate_hz))),
        ("link_setpoint_rate_hz", single(Some(of_link.setpoint_rate_hz))),
        ("age_s", real(Some(of.age_s))),
    ]);
    position(&mut row, ["slot_north_m", "slot_east_m", "slot_down_m"], of.slot);
    row.push(("tracking_error_m", real(of.tracking_error_m)));
    row.push(("is_leader", Cell::Truth(Some(of.is_leader))));
    row
}

/// The names of one setpoint's columns: position, velocity, yaw, yaw rate.
type Names = ([&'static str; 3], [&'static str; 3], [&'static str; 2]);
const ASKED: Names = (
    ["asked_north_m", "asked_east_m", "asked_down_m"],
    [
        "asked_velocity_north_m_s",
        "asked_velocity_east_m_s",
        "asked_velocity_down_m_s",
    ],
    ["asked_yaw_rad", "asked_yaw_rate_rad_s"],
);
const FLOWN: Names = (
    ["flown_north_m", "flown_east_m", "flown_down_m"],
    [
        "flown_velocity_north_m_s",
        "flown_velocity_east_m_s",
        "flown_velocity_down_m_s",
    ],
    ["flown_yaw_rad", "flown_yaw_rate_rad_s"],
);

fn one_setpoint(row: &mut Row, names: Names, of: Option<Setpoint>) {
    let (places, velocities, [yaw, rate]) = names;
    position(row, places, of.and_then(|of| of.position));
    velocity(row, velocities, of.and_then(|of| of.velocity));
    row.push((yaw, real(of.and_then(|of| of.yaw_rad))));
    row.push((rate, real(of.and_then(|of| of.yaw_rate_rad_s))));
}

/// Of a setpoint.
pub fn setpoint(told: &Told, of: &SetpointRecord) -> Row {
    let mut row = begin(told, Some(of.vehicle.0));
    one_setpoint(&mut row, ASKED, Some(of.asked));
    one_setpoint(&mut row, FLOWN, of.flown);
    let text = |of: Option<String>| Cell::Text(of);
    row.extend([
        ("changed_by_m_s", real(of.change.as_ref().map(|change| change.by_m_s))),
        (
            "change_because",
            text(of.change.as_ref().and_then(|change| change.because.clone())),
        ),
        ("slowed", text(of.slowed.as_ref().map(ToString::to_string))),
        ("refused", text(of.refusal.as_ref().map(ToString::to_string))),
    ]);
    row
}

/// Of an event.
pub fn event(told: &Told, of: &EventRecord) -> Row {
    let mut row = begin(told, of.vehicle.map(|vehicle| vehicle.0));
    let node = of.node.map(|node| node.0.to_string()).or_else(|| told.node.clone());
    let kind = serde_json::to_value(&of.kind).unwrap_or_default();
    let name = kind.get("kind").and_then(|kind| kind.as_str()).map(str::to_owned);
    row.extend([
        ("node", Cell::Text(node)),
        ("seq", Cell::Count(i64::try_from(of.seq).ok())),
        ("severity", Cell::Text(Some(word(of.severity)))),
        ("kind", Cell::Text(name)),
        ("text", Cell::Text(Some(of.text.clone()))),
        ("details_json", Cell::Text(json(&kind))),
    ]);
    row
}
