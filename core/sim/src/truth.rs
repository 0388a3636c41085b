//! What really happens: for referees, never for the swarm.

use skein_domain::{AccelerationNed, FlightMode, Geodetic, LandedState, PositionNed, VelocityNed};
use std::sync::Arc;

/// All vehicles at one moment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TruthFrame {
    /// Seconds since the simulation started.
    pub time_s: f64,
    /// Counts the frames.
    pub sequence: u64,
    /// Every vehicle ever started, killed ones too, in the order of their start.
    pub vehicles: Vec<VehicleTruth>,
    /// Every other that moves about.
    pub movers: Vec<MoverTruth>,
    /// The longest time for which the machine did not let this process run, in seconds. A setpoint gap of that length may be its own.
    pub longest_stall_s: f64,
}

impl TruthFrame {
    /// The vehicle with this system id; the last started one if several had it.
    #[must_use]
    pub fn vehicle(&self, system_id: u8) -> Option<&VehicleTruth> {
        self.vehicles.iter().rev().find(|v| v.system_id == system_id)
    }

    /// The smallest distance between any two living vehicles of which at least one is off the ground, in metres.
    #[must_use]
    pub fn smallest_distance_m(&self) -> Option<f64> {
        let mut smallest: Option<f64> = None;
        for (i, a) in self.vehicles.iter().enumerate().filter(|(_, v)| v.alive) {
            for b in self.vehicles.iter().skip(i + 1).filter(|v| v.alive) {
                if a.touches_ground && b.touches_ground {
                    continue;
                }
                let distance = a.position.distance_m(&b.position);
                if smallest.is_none_or(|s| distance < s) {
                    smallest = Some(distance);
                }
            }
        }
        smallest
    }
}

/// One vehicle at one moment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VehicleTruth {
    /// MAVLink system id.
    pub system_id: u8,
    /// False once killed; the rest then stays as it was.
    pub alive: bool,
    /// Where it is about the simulation's origin.
    pub position: PositionNed,
    /// The same as a place on Earth.
    pub geodetic: Geodetic,
    /// Velocity.
    pub velocity: VelocityNed,
    /// Acceleration.
    pub acceleration: AccelerationNed,
    /// Yaw in radians, clockwise from north.
    pub yaw_rad: f64,
    /// Tilt from the level in radians.
    pub tilt_rad: f64,
    /// Motors armed.
    pub armed: bool,
    /// What its own land detector says.
    pub landed: LandedState,
    /// Whether it really stands on the ground.
    pub touches_ground: bool,
    /// Height above its ground in metres.
    pub height_m: f64,
    /// Flight mode as its heartbeat shows it.
    pub mode: FlightMode,
    /// Whether a failsafe is in command.
    pub failsafe: bool,
    /// Position error of its estimate: estimated minus true, in metres.
    pub estimate_error: PositionNed,
    /// Where its estimator's origin lies about the simulation's origin.
    pub local_origin: PositionNed,
    /// Battery charge, 0..=1.
    pub battery: f64,
    /// Time since the last accepted setpoint in seconds, while in OFFBOARD and armed.
    pub offboard_gap_s: Option<f64>,
    /// The longest time between two accepted setpoints while in OFFBOARD and armed, as the vehicle saw it, in seconds.
    pub offboard_gap_max_s: f64,
    /// The longest that was left of any without the time in which the machine did not let this process run: what the sender is answerable
    /// for.
    pub offboard_gap_sender_max_s: f64,
    /// What was left so at most since the frame before.
    pub offboard_gap_recent_s: f64,
    /// Setpoints accepted since the start.
    pub setpoints: u64,
    /// Setpoints dropped as malformed or in an unsupported frame.
    pub setpoints_refused: u64,
    /// Speed of the hardest touch-down in metres per second.
    pub touch_down_max_m_s: f64,
    /// Every change of mode since the start, oldest first.
    pub mode_changes: Arc<Vec<ModeChange>>,
    /// Where its gimbal points, if it has one.
    pub gimbal: Option<GimbalTruth>,
    /// What its camera does, if it has one.
    pub camera: Option<CameraTruth>,
    /// How its radio is heard, if it has one.
    pub radio: Option<RadioTruth>,
    /// The places of the mission that it keeps.
    pub mission: Arc<Vec<Geodetic>>,
}

/// Where somebody else is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MoverTruth {
    /// Who, as whoever hears it will call it: `mavlink:42`, `adsb:4CA123`.
    pub source: String,
    /// Where it is about the simulation's origin.
    pub position: PositionNed,
    /// Velocity.
    pub velocity: VelocityNed,
}

/// Where a gimbal points.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GimbalTruth {
    /// Roll about the horizon in radians.
    pub roll_rad: f64,
    /// Pitch about the horizon in radians, upwards positive.
    pub pitch_rad: f64,
    /// Yaw from the vehicle's nose in radians, clockwise.
    pub yaw_vehicle_rad: f64,
    /// Yaw from north in radians, clockwise.
    pub yaw_north_rad: f64,
    /// System and component that steer it; zeros: nobody.
    pub owner: (u8, u8),
}

/// What a camera does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CameraTruth {
    /// Pictures on its storage.
    pub pictures: u32,
    /// It records.
    pub recording: bool,
    /// Zoom factor, 1 being the widest.
    pub zoom_factor: f64,
    /// Horizontal field of view in radians at that zoom.
    pub field_of_view_rad: f64,
}

/// How a vehicle's radio is heard.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RadioTruth {
    /// Signal at the vehicle in decibels over a milliwatt.
    pub signal_dbm: f64,
    /// Share of packets lost, 0..=1.
    pub loss: f64,
    /// Distance to the ground station in metres.
    pub distance_m: f64,
}

/// One change of the flight mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeChange {
    /// Seconds since the simulation started.
    pub time_s: f64,
    /// Mode before.
    pub from: FlightMode,
    /// Mode after.
    pub to: FlightMode,
    /// Why.
    pub cause: ModeCause,
}

/// Why a mode changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModeCause {
    /// A command over one of its faces.
    Commanded,
    /// A failsafe took over.
    Failsafe,
    /// The reason for the failsafe is gone: back to the mode that was asked for.
    Recovered,
    /// The pilot, by radio control.
    Pilot,
    /// The automatic take-off came to its end.
    TakeOffEnded,
    /// Disarmed after a landing: back to the mode that was last set and can be armed in.
    Disarmed,
    /// The autopilot started anew.
    Rebooted,
}
