//! A flight of four vehicles that was never flown: take-off, a formation, one vehicle that drifts into another, a refusal, a plugin that
//! restarts, a link that is lost, a landing.

use super::story;
use skein_domain::fence::{AltitudeReference, BreachAction, FencePlan, FenceZone, ZoneKind, ZoneOutline};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    Battery, FlightMode, FlightState, Geodetic, Gnss, LandedState, LinkHealth, NodeId, NodeTime, PositionNed, Refusal,
    Setpoint, SwarmFrame, SystemId, VehicleId, VelocityNed,
};
use skein_recording::decisions::GateState;
use skein_recording::{
    AuditChain, Encoded, Header, RecorderState, SetpointRecord, TimeBase, Topic, VehicleTelemetry, Writer,
};
use skein_safety::Limits;
use skein_view::{ActorHealth, FleetSnapshot, PluginHealth, VehicleSnapshot};
use std::path::Path;

/// The flight, as it is drawn.
#[derive(Debug, Clone)]
pub struct Flight {
    pub vehicles: u16,
    pub seconds: f64,
    /// The name of the first vehicle.
    pub name: &'static str,
    /// Something goes wrong in it.
    pub trouble: bool,
}

impl Default for Flight {
    fn default() -> Self {
        Self {
            vehicles: 4,
            seconds: 60.0,
            name: "Adler",
            trouble: true,
        }
    }
}

/// The vehicle that drifts, and the one it drifts into.
pub const DRIFTS: VehicleId = VehicleId(4);
pub const SWARM: SwarmFrame = SwarmFrame {
    origin: Geodetic {
        latitude_deg: 47.397_7,
        longitude_deg: 8.545_6,
        altitude_amsl_m: 488.0,
    },
};
const BEGIN: NodeTime = NodeTime(90_000_000);
/// 28 November 2026, 12:03:00 UTC.
const BEGIN_UNIX_NS: u64 = 1_795_867_380_000_000_000;
pub const RATE_HZ: f64 = 5.0;

pub fn at(t_s: f64) -> NodeTime {
    BEGIN.plus_seconds(t_s)
}

fn ramp(t_s: f64, from_s: f64, until_s: f64) -> f64 {
    let share = ((t_s - from_s) / (until_s - from_s)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

impl Flight {
    fn home(&self, n: u16) -> [f64; 2] {
        let row = f64::from(n.div_ceil(2));
        [-row * 4.0, if n.is_multiple_of(2) { row * 4.0 } else { -row * 4.0 }]
    }

    /// Where its task wants a vehicle.
    pub fn slot(&self, n: u16, t_s: f64) -> PositionNed {
        let [north_m, east_m] = self.home(n);
        let (join, leave) = (
            ramp(t_s, 8.0, 14.0),
            ramp(t_s, self.seconds - 16.0, self.seconds - 12.0),
        );
        let along = ramp(t_s, 12.0, self.seconds - 16.0);
        let row = f64::from(n.div_ceil(2));
        let side = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
        let angle = along * 2.4;
        let path = [90.0 * angle.sin(), 90.0 * (1.0 - angle.cos())];
        let slot = [path[0] - row * 5.0, path[1] + side * row * 5.0];
        let up = 20.0 * ramp(t_s, 2.0, 8.0) * (1.0 - ramp(t_s, self.seconds - 12.0, self.seconds - 4.0));
        let place = |home: f64, slot: f64| home + (slot - home) * join * (1.0 - leave * 0.1);
        PositionNed::new(place(north_m, slot[0]), place(east_m, slot[1]), -up)
    }

    /// Where it is.
    pub fn place(&self, n: u16, t_s: f64) -> PositionNed {
        let slot = self.slot(n, t_s);
        let wobble = 0.15 * (t_s * 1.7 + f64::from(n)).sin();
        let mut place = PositionNed::new(slot.north_m + wobble, slot.east_m - wobble, slot.down_m + wobble * 0.3);
        if self.trouble && VehicleId(n + 1) == DRIFTS {
            let drift = ramp(t_s, 28.0, 35.0) * (1.0 - ramp(t_s, 36.5, 42.0));
            let towards = self.slot(2, t_s);
            place.north_m += (towards.north_m - slot.north_m) * 0.9 * drift;
            place.east_m += (towards.east_m - slot.east_m) * 0.9 * drift;
        }
        place
    }

    fn airborne(&self, t_s: f64) -> bool {
        t_s > 2.0 && t_s < self.seconds - 4.0
    }

    /// The link of the second vehicle is lost for a while.
    fn silent(&self, n: u16, t_s: f64) -> bool {
        self.trouble && n == 1 && (44.0..47.0).contains(&t_s)
    }

    #[expect(clippy::too_many_lines, reason = "every field of a vehicle")]
    fn snapshot(&self, n: u16, t_s: f64) -> VehicleSnapshot {
        let heard_s = if self.silent(n, t_s) { 44.0 } else { t_s };
        let (place, before) = (self.place(n, heard_s), self.place(n, heard_s - 0.1));
        let velocity = (place.vector() - before.vector()) * 10.0;
        let flies = self.airborne(t_s);
        let slot = self.slot(n, t_s);
        let [north_m, east_m] = self.home(n);
        VehicleSnapshot {
            id: VehicleId(n + 1),
            node: None,
            name: if n == 0 {
                self.name.into()
            } else {
                ["Bussard", "Falke", "Habicht"][usize::from(n + 2) % 3].into()
            },
            simulated: true,
            system_id: SystemId(1),
            plugin: "generic-uav".into(),
            plugin_version: "0.1.0".into(),
            flight_state: if flies {
                FlightState::Following
            } else {
                FlightState::Idle
            },
            state_detail: String::new(),
            mode: if flies { FlightMode::Offboard } else { FlightMode::Hold },
            armed: flies || (1.0..2.0).contains(&t_s),
            landed: if flies {
                LandedState::InAir
            } else {
                LandedState::OnGround
            },
            ready_to_arm: Some(true),
            global: Some(SWARM.geodetic(&place)),
            kinematics: Some(VehicleKinematics {
                position: place,
                velocity: VelocityNed::new(velocity.x, velocity.y, velocity.z),
                yaw_rad: 0.3,
                measured: at(heard_s),
            }),
            roll_rad: 0.0,
            pitch_rad: 0.0,
            home: Some(SWARM.geodetic(&PositionNed::new(north_m, east_m, 0.0))),
            battery: Battery {
                remaining: Some((0.95 - 0.002 * t_s - 0.01 * f64::from(n % 7)) as f32),
                ..Battery::default()
            },
            gnss: Gnss::default(),
            link: self.link(n, t_s),
            ways: Vec::new(),
            age_s: t_s - heard_s,
            slot: flies.then_some(slot),
            tracking_error_m: flies.then(|| place.distance_m(&slot)),
            is_leader: n == 0,
            actor: ActorHealth::default(),
            model: PluginHealth::default(),
            model_state: None,
            avoiding: None,
            failsafe: None,
            energy: Some(skein_domain::EnergyState {
                remaining: 0.9,
                reserve: 0.15,
                ..Default::default()
            }),
            stopped: false,
            limits: None,
            capability: None,
            payloads: Vec::new(),
            degraded: Vec::new(),
        }
    }

    fn link(&self, n: u16, t_s: f64) -> LinkHealth {
        let silent = self.silent(n, t_s);
        let worse = if self.trouble && n == 1 {
            ramp(t_s, 38.0, 44.0) * (1.0 - ramp(t_s, 46.0, 50.0))
        } else {
            0.0
        };
        LinkHealth {
            connected: !silent,
            last_heard: at(t_s),
            loss: (0.01 + 0.006 * (t_s * 0.9 + f64::from(n)).sin() + 0.3 * worse) as f32,
            round_trip_s: Some((0.018 + 0.004 * (t_s * 1.3 + f64::from(n)).cos() + 0.09 * worse) as f32),
            clock_offset_s: None,
            receive_rate_hz: 60.0,
            setpoint_rate_hz: if self.airborne(t_s) && !silent { 20.0 } else { 0.0 },
        }
    }

    pub fn header(&self) -> Header {
        Header {
            format: skein_recording::FORMAT,
            version: "0.1.0".into(),
            node: Some(NodeId(7)),
            name: "ground".into(),
            swarm: "north".into(),
            base: TimeBase {
                node: BEGIN,
                unix_ns: BEGIN_UNIX_NS,
            },
        }
    }

    /// Writes it, without its end.
    pub fn write(&self, path: &Path) -> Writer {
        let mut tape = Tape(Writer::create(path, self.header()).expect("begins"));
        tape.put(Topic::Gate, 0.0, &gate());
        let mut events = if self.trouble { story::events() } else { Vec::new() };
        let mut actions = if self.trouble { story::actions() } else { Vec::new() };
        let mut chain = AuditChain::default();
        for tick in 0..=(self.seconds * RATE_HZ) as u64 {
            let t_s = tick as f64 / RATE_HZ;
            while let Some(event) = events.pop_if(|event| event.time <= at(t_s)) {
                tape.put(Topic::Events, t_s, &event);
            }
            while let Some(action) = actions.pop_if(|action| action.time <= at(t_s)) {
                tape.put(Topic::Audit, t_s, &chain.add(action));
            }
            let vehicles: Vec<VehicleSnapshot> = (0..self.vehicles).map(|n| self.snapshot(n, t_s)).collect();
            for vehicle in &vehicles {
                tape.put(
                    Topic::Telemetry(vehicle.id),
                    t_s,
                    &VehicleTelemetry::of(vehicle, at(t_s)),
                );
                if self.airborne(t_s) && !self.silent(vehicle.id.0 - 1, t_s) {
                    tape.put(Topic::Setpoint(vehicle.id), t_s, &self.setpoint(vehicle, t_s));
                }
            }
            if tick.is_multiple_of(RATE_HZ as u64) {
                let fleet = FleetSnapshot {
                    time: at(t_s),
                    frame: Some(SWARM),
                    vehicles,
                    ..FleetSnapshot::default()
                };
                let mut fleet = serde_json::to_value(&fleet).expect("encodes");
                if (10.0..self.seconds - 15.0).contains(&t_s) {
                    fleet["formation"] =
                        serde_json::json!({ "leader": 1, "members": [1, 2, 3, 4], "settled_at": at(12.0) });
                }
                tape.put(Topic::Fleet, t_s, &fleet);
                tape.put(
                    Topic::Recorder,
                    t_s,
                    &RecorderState {
                        time: at(t_s),
                        ..RecorderState::default()
                    },
                );
                tape.0.flush().expect("flushes");
            }
        }
        tape.0
    }

    fn setpoint(&self, vehicle: &VehicleSnapshot, t_s: f64) -> SetpointRecord {
        let refused = self.trouble && vehicle.id.0 == 3 && (20.0..20.5).contains(&t_s);
        let asked = Setpoint {
            position: vehicle.slot,
            ..Setpoint::default()
        };
        SetpointRecord {
            time: at(t_s),
            vehicle: vehicle.id,
            peers: None,
            gate: 1,
            asked,
            flown: (!refused).then_some(asked),
            slowed: None,
            refusal: refused.then(|| Refusal::OutsideFence {
                detail: "12.0 m into \"mast\"".into(),
            }),
            change: None,
        }
    }
}

/// A recording that is written.
struct Tape(Writer);

impl Tape {
    fn put(&mut self, topic: Topic, t_s: f64, message: &impl serde::Serialize) {
        let message = Encoded::json(topic, at(t_s), message).expect("encodes");
        self.0.write(&message, at(t_s)).expect("takes it");
    }
}

fn gate() -> GateState {
    let zone = |name: &str, kind, corners_m: &[[f64; 2]]| FenceZone {
        name: name.into(),
        kind,
        outline: ZoneOutline::LocalPolygon {
            corners_m: corners_m.to_vec(),
        },
        floor_m: None,
        ceiling_m: Some(50.0),
        altitude_reference: AltitudeReference::Origin,
        action: BreachAction::Hold,
    };
    let field = [[-30.0, -40.0], [120.0, -40.0], [120.0, 190.0], [-30.0, 190.0]];
    let mast = [[20.0, 60.0], [20.0, 85.0], [45.0, 85.0], [45.0, 60.0]];
    GateState {
        time: at(0.0),
        number: 1,
        limits: Limits {
            max_speed_m_s: 12.0,
            max_climb_m_s: 3.0,
            max_descent_m_s: 2.0,
            min_separation_m: 2.0,
            separation_horizon_s: 2.0,
        },
        min_height_m: 1.0,
        fences: FencePlan {
            zones: vec![
                zone("field", ZoneKind::Inclusion, &field),
                zone("mast", ZoneKind::Exclusion, &mast),
            ],
            breach_return: None,
        },
        frame: Some(SWARM),
    }
}
