//! Frames with their known contents: the browser's decoder is tested with what this encoder makes.

use crate::wire::{self, HEADER_BYTES, RECORD_BYTES, Record};
use serde::Serialize;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    Battery, FlightMode, FlightState, Geodetic, Gnss, GnssFix, Incarnation, LandedState, LinkHealth, NodeTime,
    PositionNed, SwarmFrame, SystemId, VehicleId, VelocityNed,
};
use skein_view::{ActorHealth, ActorStatus, FleetSnapshot, PluginHealth, VehicleSnapshot};
use std::fmt::Write;

/// One frame: its bytes, and what they say.
#[derive(Serialize)]
struct Vector {
    name: &'static str,
    hex: String,
    sequence: u32,
    server_time_ms: u32,
    records: Vec<Record>,
}

/// The file of all vectors.
pub(super) fn vectors() -> String {
    let vectors = [
        vector("no vehicle", &FleetSnapshot::default(), NodeTime(0)),
        vector(
            "one that flies and one of which nothing is known",
            &flying(),
            NodeTime(12_345_678),
        ),
        vector("every number beyond its range", &extreme(), NodeTime(u64::MAX)),
    ];
    // A list of plain structs always becomes JSON.
    serde_json::to_string_pretty(&vectors).unwrap_or_default() + "\n"
}

fn vector(name: &'static str, snapshot: &FleetSnapshot, now: NodeTime) -> Vector {
    let bytes = wire::encode(snapshot, now);
    debug_assert_eq!(bytes.len(), HEADER_BYTES + RECORD_BYTES * snapshot.vehicles.len());
    let hex = bytes
        .iter()
        .fold(String::with_capacity(bytes.len() * 2), |mut hex, byte| {
            let _ = write!(hex, "{byte:02x}");
            hex
        });
    let age_s = now.seconds_since(snapshot.time).max(0.0);
    let records = snapshot
        .vehicles
        .iter()
        .map(|vehicle| wire::record(vehicle, snapshot.frame.as_ref(), age_s))
        .collect();
    Vector {
        name,
        hex,
        sequence: snapshot.sequence as u32,
        server_time_ms: (now.0 / 1000) as u32,
        records,
    }
}

/// A vehicle of which nothing is known but its id.
pub(crate) fn unknown_vehicle(id: u16) -> VehicleSnapshot {
    VehicleSnapshot {
        id: VehicleId(id),
        node: None,
        name: format!("uav-{id}"),
        simulated: false,
        system_id: SystemId(1),
        plugin: "generic-uav".to_owned(),
        plugin_version: "0.1.0".to_owned(),
        flight_state: FlightState::Idle,
        state_detail: String::new(),
        mode: FlightMode::Unknown,
        armed: false,
        landed: LandedState::Unknown,
        ready_to_arm: None,
        global: None,
        kinematics: None,
        roll_rad: 0.0,
        pitch_rad: 0.0,
        home: None,
        battery: Battery::default(),
        gnss: Gnss::default(),
        link: LinkHealth::default(),
        ways: Vec::new(),
        age_s: 0.0,
        slot: None,
        tracking_error_m: None,
        is_leader: false,
        actor: ActorHealth::default(),
        model: PluginHealth::default(),
        model_state: None,
        avoiding: None,
        failsafe: None,
        energy: None,
        stopped: false,
        limits: None,
        capability: None,
        payloads: Vec::new(),
        degraded: Vec::new(),
    }
}

/// A vehicle in the middle of a formation flight.
pub(crate) fn flying_vehicle(id: u16) -> VehicleSnapshot {
    VehicleSnapshot {
        flight_state: FlightState::Leading,
        mode: FlightMode::Offboard,
        armed: true,
        landed: LandedState::InAir,
        ready_to_arm: Some(true),
        global: Some(Geodetic {
            latitude_deg: 47.397_742_1,
            longitude_deg: -8.545_593_9,
            altitude_amsl_m: 498.123,
        }),
        kinematics: Some(VehicleKinematics {
            position: PositionNed::new(1.0, 2.0, -10.0),
            velocity: VelocityNed::new(4.25, -3.5, 0.125),
            yaw_rad: -std::f64::consts::FRAC_PI_2,
            measured: NodeTime(12_300_000),
        }),
        roll_rad: 0.1,
        pitch_rad: -0.05,
        battery: Battery {
            remaining: Some(0.874),
            voltage_v: Some(15.82),
            current_a: Some(12.0),
        },
        gnss: Gnss {
            fix: GnssFix::ThreeD,
            satellites: 14,
            horizontal_accuracy_m: Some(0.8),
        },
        link: LinkHealth {
            connected: true,
            last_heard: NodeTime(12_330_000),
            loss: 0.016,
            round_trip_s: Some(0.0123),
            clock_offset_s: None,
            receive_rate_hz: 115.0,
            setpoint_rate_hz: 50.04,
        },
        ways: Vec::new(),
        age_s: 0.015,
        slot: Some(PositionNed::new(1.2, 2.1, -10.0)),
        tracking_error_m: Some(0.2236),
        is_leader: true,
        actor: ActorHealth {
            incarnation: Incarnation(2),
            ..ActorHealth::default()
        },
        model: PluginHealth {
            incarnation: Incarnation(3),
            ..PluginHealth::default()
        },
        ..unknown_vehicle(id)
    }
}

fn flying() -> FleetSnapshot {
    let origin = Geodetic {
        latitude_deg: 47.397_742,
        longitude_deg: -8.545_594,
        altitude_amsl_m: 488.0,
    };
    FleetSnapshot {
        time: NodeTime(12_340_000),
        sequence: 0x1_0000_0007,
        frame: Some(SwarmFrame::new(origin)),
        vehicles: vec![flying_vehicle(1), unknown_vehicle(300)],
        ..FleetSnapshot::default()
    }
}

/// Every number at or beyond what its field can hold, so that the browser sees the marks for "unknown" and the limits.
pub(crate) fn extreme() -> FleetSnapshot {
    let wild = VehicleSnapshot {
        flight_state: FlightState::Faulted,
        mode: FlightMode::Termination,
        landed: LandedState::Landing,
        global: Some(Geodetic {
            latitude_deg: -90.0,
            longitude_deg: 180.0,
            altitude_amsl_m: -1e12,
        }),
        kinematics: Some(VehicleKinematics {
            position: PositionNed::new(0.0, 0.0, 0.0),
            velocity: VelocityNed::new(1e9, -1e9, f64::NAN),
            yaw_rad: std::f64::consts::TAU - 1e-9,
            measured: NodeTime(u64::MAX),
        }),
        roll_rad: f32::INFINITY,
        pitch_rad: f32::NEG_INFINITY,
        battery: Battery {
            remaining: Some(7.0),
            voltage_v: Some(1e9),
            current_a: None,
        },
        gnss: Gnss {
            fix: GnssFix::RtkFixed,
            satellites: 255,
            horizontal_accuracy_m: None,
        },
        link: LinkHealth {
            loss: f32::NAN,
            round_trip_s: Some(1e9),
            setpoint_rate_hz: 1e9,
            ..LinkHealth::default()
        },
        age_s: f64::INFINITY,
        slot: Some(PositionNed::new(0.0, 0.0, 0.0)),
        tracking_error_m: Some(1e12),
        actor: ActorHealth {
            incarnation: Incarnation(u32::MAX),
            status: ActorStatus::GivenUp,
            ..ActorHealth::default()
        },
        ..unknown_vehicle(u16::MAX)
    };
    FleetSnapshot {
        time: NodeTime(u64::MAX),
        sequence: u64::from(u32::MAX),
        vehicles: vec![wild],
        ..FleetSnapshot::default()
    }
}
