//! A made-up flight of 3 vehicles on circles, as a node records it; also for the tests against other people's programs (`tests/interop`).

use serde_json::json;
use skein_domain::exchange::Severity;
use skein_domain::telemetry::{GnssFix, VehicleKinematics};
use skein_domain::{
    Battery, FlightMode, FlightState, Geodetic, Gnss, LandedState, LinkHealth, NodeId, NodeTime, PositionNed, Setpoint,
    SwarmFrame, VehicleId, VelocityNed,
};
use skein_recording::{
    Audit, AuditChain, ClockOffset, ClockRecord, Encoded, FORMAT, Header, SetpointRecord, TimeBase, Topic,
    VehicleTelemetry, Writer,
};
use skein_view::{EventKind, EventRecord, FleetSnapshot};
use std::path::{Path, PathBuf};

/// Where the swarm's frame has its origin.
pub const ORIGIN: Geodetic = Geodetic {
    latitude_deg: 47.397_742,
    longitude_deg: 8.545_594,
    altitude_amsl_m: 488.0,
};
/// 2026-11-28 10:00:00 UTC.
pub const BEGIN_UNIX_NS: u64 = 1_795_860_000_000_000_000;

/// What is flown, and how it is recorded.
#[derive(Debug, Clone)]
pub struct Flight {
    /// The node's number.
    pub node: Option<u64>,
    /// The vehicles that it flies, of 1 to 3: it sees all of them.
    pub flies: Vec<u16>,
    /// When its clock stood at zero, in nanoseconds since 1970.
    pub zero_unix_ns: u64,
    /// When the flight begins, on its clock in seconds.
    pub from_s: f64,
    /// How long it is, in seconds.
    pub seconds: u64,
    /// Nothing is recorded in this second.
    pub gap_at: Option<u64>,
    /// Clocks of others.
    pub others: Vec<ClockOffset>,
    /// The chain of the audit.
    pub audit: AuditChain,
    /// It comes to its end.
    pub finishes: bool,
}

impl Default for Flight {
    fn default() -> Self {
        Self {
            node: Some(1),
            flies: vec![1, 2, 3],
            zero_unix_ns: BEGIN_UNIX_NS - 100_000_000_000,
            from_s: 100.0,
            seconds: 20,
            gap_at: None,
            others: Vec::new(),
            audit: AuditChain::default(),
            finishes: true,
        }
    }
}

fn frame() -> SwarmFrame {
    SwarmFrame::new(ORIGIN)
}

/// Where a vehicle is after so many seconds.
pub fn position(vehicle: u16, after_s: f64) -> PositionNed {
    let (sin, cos) = (after_s * 0.3 + f64::from(vehicle)).sin_cos();
    PositionNed::new(20.0 * cos, 20.0 * sin, -10.0 * f64::from(vehicle))
}

fn kinematics(vehicle: u16, after_s: f64, at: NodeTime) -> VehicleKinematics {
    let (sin, cos) = (after_s * 0.3 + f64::from(vehicle)).sin_cos();
    VehicleKinematics {
        position: position(vehicle, after_s),
        velocity: VelocityNed::new(-6.0 * sin, 6.0 * cos, 0.0),
        yaw_rad: (after_s * 0.3).sin(),
        measured: at,
    }
}

impl Flight {
    fn at(&self, after_s: f64) -> NodeTime {
        NodeTime::from_seconds(self.from_s + after_s)
    }

    fn header(&self) -> Header {
        Header {
            format: FORMAT,
            version: "0.1.0".into(),
            node: self.node.map(NodeId),
            name: self.node.map_or_else(|| "alone".into(), |node| format!("node-{node}")),
            swarm: if self.node.is_some() {
                "blue".into()
            } else {
                String::new()
            },
            base: TimeBase {
                node: NodeTime(0),
                unix_ns: self.zero_unix_ns,
            },
        }
    }

    fn telemetry(&self, vehicle: u16, after_s: f64) -> VehicleTelemetry {
        let at = self.at(after_s);
        let moves = kinematics(vehicle, after_s, at);
        VehicleTelemetry {
            time: at,
            vehicle: VehicleId(vehicle),
            global: Some(frame().geodetic(&moves.position)),
            kinematics: Some(moves),
            roll_rad: 0.1,
            pitch_rad: -0.05,
            flight_state: FlightState::Following,
            mode: FlightMode::Offboard,
            armed: true,
            landed: LandedState::InAir,
            battery: Battery {
                remaining: Some(0.8),
                voltage_v: Some(15.2),
                current_a: Some(11.5),
            },
            gnss: Gnss {
                fix: GnssFix::ThreeD,
                satellites: 14,
                horizontal_accuracy_m: Some(0.7),
            },
            link: LinkHealth {
                connected: true,
                ..LinkHealth::default()
            },
            age_s: 0.02,
            slot: Some(position(vehicle, after_s)),
            tracking_error_m: Some(0.25),
            is_leader: vehicle == 1,
        }
    }

    fn fleet(&self, after_s: f64) -> FleetSnapshot {
        let vehicles = (1..=3).map(|vehicle| {
            let of = self.telemetry(vehicle, after_s);
            let node = self.node.map(|node| if self.flies.contains(&vehicle) { node } else { 3 - node });
            let made = json!({
                "id": vehicle, "node": node, "name": format!("uav-{vehicle}"), "system_id": vehicle, "plugin": "generic-uav",
                "plugin_version": "1", "flight_state": of.flight_state, "state_detail": "", "mode": of.mode, "armed": true,
                "landed": of.landed, "ready_to_arm": null, "global": of.global, "kinematics": of.kinematics, "roll_rad": of.roll_rad,
                "pitch_rad": of.pitch_rad, "home": ORIGIN, "battery": of.battery, "gnss": of.gnss, "link": of.link, "age_s": of.age_s,
                "slot": of.slot, "tracking_error_m": of.tracking_error_m, "is_leader": of.is_leader,
                "actor": skein_view::ActorHealth::default(), "model": skein_view::PluginHealth::default(), "model_state": null,
                "avoiding": null, "failsafe": null, "energy": null, "stopped": false, "limits": null, "capability": null,
                "payloads": [], "degraded": [],
            });
            serde_json::from_value(made).expect("a vehicle")
        });
        FleetSnapshot {
            time: self.at(after_s),
            frame: Some(frame()),
            vehicles: vehicles.collect(),
            ..FleetSnapshot::default()
        }
    }

    fn event(&self, second: u64) -> EventRecord {
        let severities = [Severity::Info, Severity::Warning, Severity::Info, Severity::Critical];
        EventRecord {
            seq: second,
            time: self.at(second as f64),
            node: None,
            vehicle: (!second.is_multiple_of(4)).then_some(VehicleId((second % 4) as u16)),
            severity: severities[(second % 4) as usize],
            kind: EventKind::Notice,
            text: format!("in second {second}: <a> \"quoted\" text & more, long enough for two frames of MAVLink"),
        }
    }

    fn setpoint(&self, vehicle: u16, after_s: f64) -> SetpointRecord {
        let at = self.at(after_s);
        let moves = kinematics(vehicle, after_s, at);
        let asked = Setpoint {
            position: Some(moves.position),
            velocity: Some(moves.velocity),
            yaw_rad: Some(moves.yaw_rad),
            ..Setpoint::default()
        };
        SetpointRecord {
            time: at,
            vehicle: VehicleId(vehicle),
            peers: None,
            gate: 0,
            asked,
            flown: Some(asked),
            slowed: None,
            refusal: None,
            change: None,
        }
    }

    /// Writes it. What this leaves is the end of the audit's chain.
    pub fn write(mut self, folder: &Path, name: &str) -> (PathBuf, AuditChain) {
        let path = folder.join(name);
        let gap_at = self.gap_at;
        let mut writer = Writer::create(&path, self.header()).expect("begins");
        for second in (0..self.seconds).filter(move |second| Some(*second) != gap_at) {
            for message in self.second(second) {
                writer.write(&message, message.at).expect("takes it");
            }
            writer.flush().expect("flushes");
        }
        if self.finishes {
            writer.finish().expect("ends");
        } else {
            let bytes = std::fs::read(&path).expect("is there");
            drop(writer);
            std::fs::write(&path, bytes).expect("is put back");
        }
        (path, self.audit)
    }

    fn second(&mut self, second: u64) -> Vec<Encoded> {
        let mut messages = Vec::new();
        let begin = self.at(second as f64);
        if second.is_multiple_of(2) {
            let audit = self.audit.add(Audit {
                time: begin,
                who: "Ada".into(),
                over: "api".into(),
                what: format!("POST /api/v1/commands {second}"),
                ..Audit::default()
            });
            messages.push(Encoded::json(Topic::Audit, begin, &audit).expect("encodes"));
        }
        let clock = ClockRecord {
            time: begin,
            unix_ns: 0,
            others: self.others.clone(),
        };
        messages.push(Encoded::json(Topic::Clock, begin, &clock).expect("encodes"));
        messages.push(Encoded::json(Topic::Fleet, begin, &self.fleet(second as f64)).expect("encodes"));
        messages.push(Encoded::json(Topic::Events, begin, &self.event(second)).expect("encodes"));
        for tenth in 0..10_u32 {
            let after_s = second as f64 + f64::from(tenth) / 10.0;
            let at = self.at(after_s);
            for vehicle in 1..=3 {
                let topic = Topic::Telemetry(VehicleId(vehicle));
                messages.push(Encoded::json(topic, at, &self.telemetry(vehicle, after_s)).expect("encodes"));
            }
            for vehicle in &self.flies {
                let topic = Topic::Setpoint(VehicleId(*vehicle));
                messages.push(Encoded::json(topic, at, &self.setpoint(*vehicle, after_s)).expect("encodes"));
            }
        }
        messages
    }
}
