//! What is recorded of vehicles, clocks and the recorder itself.
//!
//! Must never do: be what a decision is made from; numbers are rounded here to what a sensor can tell.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    AccelerationNed, Battery, FlightMode, FlightState, Geodetic, Gnss, LandedState, LinkHealth, NodeId, NodeTime,
    PositionNed, Refusal, Setpoint, VehicleId, VelocityNed,
};
use skein_view::{Avoidance, VehicleSnapshot};

/// What is known of one vehicle, with lengths to the millimetre.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct VehicleTelemetry {
    /// When, on the node's clock.
    pub time: NodeTime,
    /// Which vehicle.
    pub vehicle: VehicleId,
    /// Position, velocity and yaw in the swarm's frame.
    pub kinematics: Option<VehicleKinematics>,
    /// Place on Earth.
    pub global: Option<Geodetic>,
    /// Roll in radians.
    pub roll_rad: f32,
    /// Pitch in radians.
    pub pitch_rad: f32,
    /// Flight state as its model decides it.
    pub flight_state: FlightState,
    /// Autopilot mode.
    pub mode: FlightMode,
    /// Motors armed.
    pub armed: bool,
    /// On the ground or in the air.
    pub landed: LandedState,
    /// Battery.
    pub battery: Battery,
    /// Satellite navigation.
    pub gnss: Gnss,
    /// Link measured by the node that flies it.
    pub link: LinkHealth,
    /// Seconds since the last frame was heard.
    pub age_s: f64,
    /// Where its task wants it.
    pub slot: Option<PositionNed>,
    /// Distance to that place in metres.
    pub tracking_error_m: Option<f64>,
    /// Whether it leads.
    pub is_leader: bool,
}

/// To so many digits behind the point.
fn rounded(value: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    (value * scale).round() / scale
}

fn rounded_f32(value: f32, digits: i32) -> f32 {
    let scale = 10_f32.powi(digits);
    (value * scale).round() / scale
}

fn to_ms(at: NodeTime) -> NodeTime {
    NodeTime(at.0 / 1_000 * 1_000)
}

fn place(of: PositionNed) -> PositionNed {
    PositionNed::new(rounded(of.north_m, 3), rounded(of.east_m, 3), rounded(of.down_m, 3))
}

impl VehicleTelemetry {
    /// Of a vehicle as screens see it.
    #[must_use]
    pub fn of(vehicle: &VehicleSnapshot, time: NodeTime) -> Self {
        let kinematics = vehicle.kinematics.map(|of| VehicleKinematics {
            position: place(of.position),
            velocity: VelocityNed::new(
                rounded(of.velocity.north_m_s, 3),
                rounded(of.velocity.east_m_s, 3),
                rounded(of.velocity.down_m_s, 3),
            ),
            yaw_rad: rounded(of.yaw_rad, 4),
            measured: to_ms(of.measured),
        });
        let global = vehicle.global.map(|of| Geodetic {
            latitude_deg: rounded(of.latitude_deg, 8),
            longitude_deg: rounded(of.longitude_deg, 8),
            altitude_amsl_m: rounded(of.altitude_amsl_m, 3),
        });
        let link = LinkHealth {
            loss: rounded_f32(vehicle.link.loss, 4),
            round_trip_s: vehicle.link.round_trip_s.map(|s| rounded_f32(s, 4)),
            clock_offset_s: vehicle.link.clock_offset_s.map(|s| rounded(s, 4)),
            receive_rate_hz: rounded_f32(vehicle.link.receive_rate_hz, 1),
            setpoint_rate_hz: rounded_f32(vehicle.link.setpoint_rate_hz, 1),
            last_heard: to_ms(vehicle.link.last_heard),
            ..vehicle.link
        };
        Self {
            time,
            vehicle: vehicle.id,
            kinematics,
            global,
            roll_rad: rounded_f32(vehicle.roll_rad, 4),
            pitch_rad: rounded_f32(vehicle.pitch_rad, 4),
            flight_state: vehicle.flight_state,
            mode: vehicle.mode,
            armed: vehicle.armed,
            landed: vehicle.landed,
            battery: Battery {
                remaining: vehicle.battery.remaining.map(|v| rounded_f32(v, 4)),
                voltage_v: vehicle.battery.voltage_v.map(|v| rounded_f32(v, 3)),
                current_a: vehicle.battery.current_a.map(|v| rounded_f32(v, 2)),
            },
            gnss: vehicle.gnss,
            link,
            age_s: rounded(vehicle.age_s, 3),
            slot: vehicle.slot.map(place),
            tracking_error_m: vehicle.tracking_error_m.map(|m| rounded(m, 3)),
            is_leader: vehicle.is_leader,
        }
    }

    /// Puts it over an older picture of the same vehicle.
    pub fn put_over(self, vehicle: &mut VehicleSnapshot) {
        vehicle.kinematics = self.kinematics;
        vehicle.global = self.global;
        vehicle.roll_rad = self.roll_rad;
        vehicle.pitch_rad = self.pitch_rad;
        vehicle.flight_state = self.flight_state;
        vehicle.mode = self.mode;
        vehicle.armed = self.armed;
        vehicle.landed = self.landed;
        vehicle.battery = self.battery;
        vehicle.gnss = self.gnss;
        vehicle.link = self.link;
        vehicle.age_s = self.age_s;
        vehicle.slot = self.slot;
        vehicle.tracking_error_m = self.tracking_error_m;
        vehicle.is_leader = self.is_leader;
    }
}

/// One setpoint: as the vehicle's model asked for it, and what the safety gate made of it. With the control period and the gate that it names,
/// it can be judged again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SetpointRecord {
    /// When it was judged, on the node's clock.
    pub time: NodeTime,
    /// Which vehicle.
    pub vehicle: VehicleId,
    /// The control period it was judged in: the `made` of a message on `/skein/peers`. Null if that one was thinned out; then the numbers here are
    /// rounded, and it cannot be judged again.
    pub peers: Option<NodeTime>,
    /// The gate it was judged by: the `number` of a message on `/skein/gate`.
    pub gate: u64,
    /// As the model asked for it, in the swarm's frame.
    pub asked: Setpoint,
    /// As it was flown, in the swarm's frame; null if it was refused.
    pub flown: Option<Setpoint>,
    /// It was too fast, and is flown slower: in which respect.
    pub slowed: Option<Refusal>,
    /// Why it was refused.
    pub refusal: Option<Refusal>,
    /// What was changed of it.
    pub change: Option<Avoidance>,
}

impl SetpointRecord {
    /// The same without its control period, to a tenth of a millimetre.
    #[must_use]
    pub fn thinned(self) -> Self {
        Self {
            peers: None,
            asked: short(&self.asked),
            flown: self.flown.as_ref().map(short),
            ..self
        }
    }
}

fn short(setpoint: &Setpoint) -> Setpoint {
    let digits = |value: f64| rounded(value, 4);
    Setpoint {
        position: setpoint
            .position
            .map(|of| PositionNed::new(digits(of.north_m), digits(of.east_m), digits(of.down_m))),
        velocity: setpoint
            .velocity
            .map(|of| VelocityNed::new(digits(of.north_m_s), digits(of.east_m_s), digits(of.down_m_s))),
        acceleration: setpoint
            .acceleration
            .map(|of| AccelerationNed::new(digits(of.north_m_s2), digits(of.east_m_s2), digits(of.down_m_s2))),
        yaw_rad: setpoint.yaw_rad.map(digits),
        yaw_rate_rad_s: setpoint.yaw_rate_rad_s.map(digits),
        ..*setpoint
    }
}

/// Another node's clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClockOffset {
    /// The node.
    pub node: NodeId,
    /// Its clock less this node's, in seconds.
    pub ahead_s: f64,
    /// How far off that may be, in seconds.
    pub error_s: Option<f64>,
}

/// How the clocks of the swarm stand to each other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClockRecord {
    /// When, on the node's clock.
    pub time: NodeTime,
    /// The computer's clock at that moment, in nanoseconds since 1970.
    pub unix_ns: u64,
    /// The other nodes'.
    pub others: Vec<ClockOffset>,
}

/// How the recorder fares.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct RecorderState {
    /// When, on the node's clock.
    pub time: NodeTime,
    /// Bytes of this file until now.
    pub bytes: u64,
    /// Messages that were dropped since the node started, because the disk did not take them.
    pub dropped: u64,
}
