//! What is known of one vehicle: its latest telemetry, and the state of the link it came over. Plain values, latest wins.

use crate::{AccelerationNed, Geodetic, LocalFrame, LocalPositionNed, NodeTime, PositionNed, VelocityNed};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

macro_rules! plain_enum {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $n:literal $variant:ident),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
        #[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
        #[serde(rename_all = "snake_case")]
        #[cbor(index_only)]
        #[repr(u8)]
        pub enum $name { $($(#[$vdoc])* #[n($n)] $variant = $n),+ }

        impl $name {
            /// Every value, in the order of its number on the wire.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// The number that stands for it in binary frames.
            #[must_use]
            pub fn code(self) -> u8 {
                self as u8
            }

            /// The word that stands for it in JSON.
            #[must_use]
            pub fn word(self) -> String {
                stringify_variant(self)
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(&self.word())
            }
        }
    };
}

/// The snake_case word of a plain enum's variant, as serde writes it.
fn stringify_variant<T: std::fmt::Debug>(value: T) -> String {
    let camel = format!("{value:?}");
    let mut word = String::with_capacity(camel.len() + 4);
    for (i, c) in camel.chars().enumerate() {
        if c.is_ascii_uppercase() && i > 0 {
            word.push('_');
        }
        word.push(c.to_ascii_lowercase());
    }
    word
}

plain_enum!(
    /// The autopilot's flight mode, in words that fit PX4 and its peers.
    FlightMode {
        /// Not known, or one we have no word for.
        #[default]
        0 Unknown,
        /// Direct stick input.
        1 Manual,
        /// Pilot steers, altitude is held.
        2 Altitude,
        /// Pilot steers, position is held.
        3 Position,
        /// Rate control by the pilot.
        4 Acro,
        /// Attitude control by the pilot.
        5 Stabilized,
        /// External setpoints.
        6 Offboard,
        /// Automatic: ready on the ground.
        7 Ready,
        /// Automatic take-off.
        8 TakeOff,
        /// Automatic: holds its position.
        9 Hold,
        /// Automatic: flies the uploaded mission.
        10 Mission,
        /// Automatic: returns to launch.
        11 Return,
        /// Automatic landing.
        12 Land,
        /// Descends without position control.
        13 Descend,
        /// Flight terminated.
        14 Termination,
    }
);

impl FlightMode {
    /// Whether a vehicle in this mode can be armed by a command alone. It cannot in a pilot's mode without a transmitter, in OFFBOARD
    /// without a stream (which PX4 shows after a landing out of OFFBOARD), nor while it lands or returns; its own word that it is
    /// not ready then speaks of the mode.
    #[must_use]
    pub fn arms_by_command(self) -> bool {
        matches!(
            self,
            Self::Unknown | Self::Hold | Self::Ready | Self::TakeOff | Self::Mission
        )
    }
}

plain_enum!(
    /// Whether the vehicle stands on the ground, as its own detector says.
    LandedState {
        /// Not known: treat as in the air.
        #[default]
        0 Unknown,
        /// On the ground.
        1 OnGround,
        /// In the air.
        2 InAir,
        /// Taking off.
        3 TakingOff,
        /// Landing.
        4 Landing,
    }
);

plain_enum!(
    /// Kind of satellite fix.
    GnssFix {
        /// No receiver or no report.
        #[default]
        0 Unknown,
        /// Receiver without a fix.
        1 None,
        /// Two-dimensional.
        2 TwoD,
        /// Three-dimensional.
        3 ThreeD,
        /// Differential.
        4 Dgps,
        /// Real-time kinematic, float.
        5 RtkFloat,
        /// Real-time kinematic, fixed.
        6 RtkFixed,
    }
);

plain_enum!(
    /// Where a vehicle stands in its flight, as its UAV-model plugin decides it.
    FlightState {
        /// On the ground, disarmed.
        #[default]
        0 Idle,
        /// Arming was asked for and is awaited.
        1 Arming,
        /// Armed on the ground or climbing to the take-off height.
        2 TakingOff,
        /// Stays where it is, under the swarm's control.
        3 Holding,
        /// Flies to a place it was sent to.
        4 GoingTo,
        /// Keeps its slot relative to the leader.
        5 Following,
        /// Leads the formation along its route.
        6 Leading,
        /// Flies back to its launch place.
        7 Returning,
        /// Descends to the ground.
        8 Landing,
        /// A human pilot or the autopilot's own failsafe has taken it out of the swarm's control.
        9 PilotControl,
        /// Something failed that the model cannot mend; an operator must look.
        10 Faulted,
    }
);

impl FlightState {
    /// Whether the vehicle is in the air and under the swarm's control, so that it may take a slot.
    #[must_use]
    pub fn is_available_in_air(self) -> bool {
        matches!(self, Self::Holding | Self::GoingTo | Self::Following | Self::Leading)
    }
}

/// Battery, as reported.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct Battery {
    /// Remaining charge, 0..=1.
    #[n(0)]
    pub remaining: Option<f32>,
    /// Voltage in volts.
    #[n(1)]
    pub voltage_v: Option<f32>,
    /// Current in amperes.
    #[n(2)]
    pub current_a: Option<f32>,
}

/// Satellite navigation, as reported.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct Gnss {
    /// Kind of fix.
    #[n(0)]
    pub fix: GnssFix,
    /// Satellites used.
    #[n(1)]
    pub satellites: u8,
    /// Horizontal dilution or accuracy as reported, in metres where known.
    #[n(2)]
    pub horizontal_accuracy_m: Option<f32>,
}

/// What has been taken from the battery, and how long the rest lasts: as far as the vehicle says so.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct BatteryUse {
    /// Charge used since it was switched on, in ampere hours.
    pub consumed_ah: Option<f32>,
    /// Energy used since it was switched on, in watt hours.
    pub consumed_wh: Option<f32>,
    /// Flight time that is left by the vehicle's own reckoning, in seconds.
    pub remaining_s: Option<f32>,
}

/// What a vehicle's estimator says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct EstimatorHealth {
    /// What it has and what is wrong with it, as MAVLink numbers it (`ESTIMATOR_STATUS_FLAGS`). Ask by the methods.
    pub flags: u16,
    /// Accuracy of the position along the horizontal in metres, one standard deviation.
    pub horizontal_accuracy_m: Option<f32>,
    /// Accuracy of the height in metres, one standard deviation.
    pub vertical_accuracy_m: Option<f32>,
    /// How far the last horizontal positions were from what was expected, 1 being where they are not believed any more.
    pub position_ratio: f32,
    /// The same for the velocity.
    pub velocity_ratio: f32,
}

impl EstimatorHealth {
    /// It has an attitude.
    pub const ATTITUDE: u16 = 1;
    /// It has a horizontal velocity.
    pub const VELOCITY_HORIZONTAL: u16 = 2;
    /// It has a vertical velocity.
    pub const VELOCITY_VERTICAL: u16 = 4;
    /// It has a position relative to where it started.
    pub const POSITION_RELATIVE: u16 = 8;
    /// It has a position on Earth.
    pub const POSITION_ABSOLUTE: u16 = 16;
    /// It has a height above mean sea level.
    pub const HEIGHT_ABSOLUTE: u16 = 32;
    /// It takes it that it does not move: PX4 sets it of whatever stands still on the ground, and without any source of a position.
    pub const CONSTANT_POSITION: u16 = 128;
    /// It would have a relative position in flight.
    pub const POSITION_RELATIVE_PREDICTED: u16 = 256;
    /// It would have a position on Earth in flight.
    pub const POSITION_ABSOLUTE_PREDICTED: u16 = 512;
    /// The satellite receiver is not believed.
    pub const GNSS_GLITCH: u16 = 1024;
    /// The accelerometers are not believed.
    pub const ACCELEROMETER_ERROR: u16 = 2048;

    /// Whether all of these flags are set.
    #[must_use]
    pub fn has(&self, flags: u16) -> bool {
        self.flags & flags == flags
    }

    /// Whether it knows where on Earth it is, how high, and how fast it moves: what flying among others needs. PX4 takes back
    /// velocity and position when it has no source of them, so these flags tell it. That it takes itself not to move is no fault of
    /// a vehicle that stands; one in the air has lost its way.
    #[must_use]
    pub fn is_position_good(&self, in_air: bool) -> bool {
        let needed = Self::ATTITUDE | Self::VELOCITY_HORIZONTAL | Self::POSITION_ABSOLUTE | Self::HEIGHT_ABSOLUTE;
        self.has(needed) && !(in_air && self.has(Self::CONSTANT_POSITION)) && !self.has(Self::ACCELEROMETER_ERROR)
    }
}

/// When each kind of message was last heard; zero = never since the autopilot started. By this staleness is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct HeardTimes {
    /// Local position.
    pub local: NodeTime,
    /// Global position.
    pub global: NodeTime,
    /// Attitude.
    pub attitude: NodeTime,
    /// First satellite receiver.
    pub gnss: NodeTime,
    /// Second satellite receiver.
    pub gnss2: NodeTime,
    /// The estimator's report on itself.
    pub estimator: NodeTime,
    /// Wind.
    pub wind: NodeTime,
    /// Battery.
    pub battery: NodeTime,
    /// System status with the health of the sensors.
    pub system_status: NodeTime,
}

/// One of two links to one vehicle.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct VehicleWay {
    /// What it goes over: `MAVLink` or `DDS`.
    pub name: String,
    /// It carries commands and setpoints now; the other one is heard only.
    pub flies: bool,
    /// How it is.
    pub link: LinkHealth,
}

/// State of the link to one vehicle, measured by this node.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct LinkHealth {
    /// Frames arrive. False from the moment the link is declared lost until it is regained.
    #[n(0)]
    pub connected: bool,
    /// When the last frame of this vehicle arrived.
    #[n(1)]
    pub last_heard: NodeTime,
    /// Share of frames lost on the way here, 0..=1, over the last seconds, from the sequence numbers.
    #[n(2)]
    pub loss: f32,
    /// Round-trip time in seconds, smoothed (TIMESYNC or command acknowledgement).
    #[n(3)]
    pub round_trip_s: Option<f32>,
    /// Autopilot clock minus node clock in seconds.
    #[n(4)]
    pub clock_offset_s: Option<f64>,
    /// Frames per second received.
    #[n(5)]
    pub receive_rate_hz: f32,
    /// Setpoints per second sent; 0 when not streaming.
    #[n(6)]
    pub setpoint_rate_hz: f32,
}

/// Everything a link knows of one vehicle. Positions are as the vehicle gives them: geodetic, and in its own local frame.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Telemetry {
    /// Flight mode.
    pub mode: FlightMode,
    /// Motors armed.
    pub armed: bool,
    /// The autopilot's own failsafe acts.
    #[serde(default)]
    pub failsafe: bool,
    /// The autopilot runs in a simulation: its clock goes at a pace of its own, and its battery tells nothing of a flight's length.
    #[serde(default)]
    pub simulated: bool,
    /// On the ground or in the air.
    pub landed: LandedState,
    /// Whether the autopilot would let it be armed now; `None` until it says.
    pub ready_to_arm: Option<bool>,
    /// Global position estimate.
    pub global: Option<Geodetic>,
    /// Local position estimate, in the vehicle's own frame.
    pub local: Option<LocalPositionNed>,
    /// The vehicle's own frame, once known.
    pub local_frame: Option<LocalFrame>,
    /// Velocity estimate.
    pub velocity: Option<VelocityNed>,
    /// Acceleration estimate where the vehicle gives one.
    pub acceleration: Option<AccelerationNed>,
    /// Node time at which the position was measured (not received), as far as the clock offset is known.
    pub position_time: NodeTime,
    /// Roll in radians.
    pub roll_rad: f32,
    /// Pitch in radians.
    pub pitch_rad: f32,
    /// Yaw in radians, clockwise from north.
    pub yaw_rad: f32,
    /// Launch place as the autopilot has it.
    pub home: Option<Geodetic>,
    /// Battery.
    pub battery: Battery,
    /// Satellite navigation: the first receiver.
    pub gnss: Gnss,
    /// Where the first satellite receiver says that it is, unfiltered; only with a fix.
    #[serde(default)]
    pub gnss_place: Option<Geodetic>,
    /// The second satellite receiver, if there is one.
    #[serde(default)]
    pub gnss2: Gnss,
    /// Where the second satellite receiver says that it is, unfiltered; only with a fix.
    #[serde(default)]
    pub gnss2_place: Option<Geodetic>,
    /// Whether the autopilot holds its satellite receiver for healthy; `None` if it has none or does not say.
    #[serde(default)]
    pub gnss_healthy: Option<bool>,
    /// What the estimator says of itself.
    #[serde(default)]
    pub estimator: Option<EstimatorHealth>,
    /// Wind as the autopilot estimates it: where the air moves to.
    #[serde(default)]
    pub wind: Option<VelocityNed>,
    /// What has been taken from the battery.
    #[serde(default)]
    pub battery_use: BatteryUse,
    /// When each kind of message was last heard.
    #[serde(default)]
    pub heard: HeardTimes,
}

/// One vehicle as the swarm sees it: telemetry in the common frame. What peers, plugins and screens read.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct VehicleKinematics {
    /// Position in the swarm frame.
    #[n(0)]
    pub position: PositionNed,
    /// Velocity.
    #[n(1)]
    pub velocity: VelocityNed,
    /// Yaw in radians, clockwise from north.
    #[n(2)]
    pub yaw_rad: f64,
    /// When it was measured.
    #[n(3)]
    pub measured: NodeTime,
}
