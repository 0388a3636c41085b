//! Commands: what an operator asks of a vehicle, and what a vehicle's model asks of its autopilot.

use crate::payload::Target;
use crate::{FlightMode, PositionNed};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// What an operator, the coordinator or another program may ask of one vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub enum VehicleCommand {
    /// Arm and stay on the ground (the autopilot disarms by itself after some seconds).
    #[n(0)]
    Arm,
    /// Disarm; refused in the air.
    #[n(1)]
    Disarm,
    /// Arm if need be, climb to a height above the launch place, then hold.
    #[n(2)]
    TakeOff {
        /// Height above the launch place in metres.
        #[n(0)]
        #[schemars(range(max = 10_000.0), extend("exclusiveMinimum" = 0))]
        height_m: f64,
    },
    /// Land where it is.
    #[n(3)]
    Land,
    /// Fly to a place and land there.
    #[n(4)]
    LandAt {
        /// The landing spot in the swarm frame; its height is that of the ground.
        #[n(0)]
        spot: PositionNed,
    },
    /// Stop and hold the position.
    #[n(5)]
    Hold,
    /// Return to the launch place and land.
    #[n(6)]
    Return,
    /// Fly to a place and hold there.
    #[n(7)]
    GoTo {
        /// The place in the swarm frame.
        #[n(0)]
        position: PositionNed,
        /// Yaw on the way and there, in radians; unchanged if left out.
        #[n(1)]
        #[schemars(range(min = -1000.0, max = 1000.0))]
        yaw_rad: Option<f64>,
        /// Speed in metres per second; the model's cruise speed if left out.
        #[n(2)]
        #[schemars(range(max = 200.0), extend("exclusiveMinimum" = 0))]
        speed_m_s: Option<f64>,
    },
    /// Keep a target in view: fly to a stand-off distance from it, stay there, and point the gimbal at it.
    #[n(8)]
    Observe {
        /// What is to be kept in view.
        #[n(0)]
        target: Target,
        /// Horizontal distance to keep in metres; the model's own if left out.
        #[n(1)]
        #[schemars(range(min = 0.0, max = 100_000.0))]
        stand_off_m: Option<f64>,
        /// Height above the target to keep in metres; if left out the present one, or the one that a camera without a gimbal needs.
        #[n(2)]
        #[schemars(range(min = -10_000.0, max = 10_000.0))]
        height_m: Option<f64>,
        /// From which side: the bearing from the target to the vehicle, in radians clockwise from north; the nearest side if left out.
        #[n(3)]
        #[schemars(range(min = -1000.0, max = 1000.0))]
        bearing_rad: Option<f64>,
    },
    /// Point the gimbal at a target (region of interest) without moving the vehicle for it.
    #[n(9)]
    LookAt {
        /// What is to be looked at.
        #[n(0)]
        target: Target,
    },
    /// End `observe` or `look_at`: hold, gimbal ahead.
    #[n(10)]
    StopObserving,
    /// Be flown by hand: it goes where the sticks that follow point, and stands while none come. A leader goes on leading. Done when no
    /// stick has come for ten seconds.
    #[n(11)]
    Steer,
}

impl VehicleCommand {
    /// The command's name as it stands in the API and in logs.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Arm => "arm",
            Self::Disarm => "disarm",
            Self::TakeOff { .. } => "take_off",
            Self::Land => "land",
            Self::LandAt { .. } => "land_at",
            Self::Hold => "hold",
            Self::Return => "return",
            Self::GoTo { .. } => "go_to",
            Self::Observe { .. } => "observe",
            Self::LookAt { .. } => "look_at",
            Self::StopObserving => "stop_observing",
            Self::Steer => "steer",
        }
    }
}

/// What a vehicle's model may ask of the autopilot. The link turns it into the protocol's own command.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Encode, Decode)]
pub enum AutopilotCommand {
    /// Arm the motors.
    #[n(0)]
    Arm,
    /// Disarm the motors; the autopilot refuses in the air.
    #[n(1)]
    Disarm,
    /// Automatic take-off from the ground to a height above the launch place. The link makes the absolute altitude of it.
    #[n(2)]
    TakeOff {
        /// Height above the launch place in metres.
        #[n(0)]
        height_m: f64,
    },
    /// Automatic landing at the present place.
    #[n(3)]
    Land,
    /// Automatic return to launch.
    #[n(4)]
    ReturnToLaunch,
    /// Change to another flight mode than OFFBOARD.
    #[n(5)]
    SetMode {
        /// The mode.
        #[n(0)]
        mode: FlightMode,
    },
    /// Enter OFFBOARD. The link does it only when its setpoint stream has run long enough.
    #[n(6)]
    EnterOffboard,
    /// Motors off at once, in flight too: the vehicle falls. Never a model's to ask for; the link puts it ahead of all else, repeats
    /// it until it is done and ends the setpoint stream.
    #[n(7)]
    EmergencyStop,
}

impl AutopilotCommand {
    /// Whether it brings a flight to rest or home, by the autopilot's own means. Asked for also where it is in doubt who else hears it: a
    /// vehicle that flies must never be left without them.
    #[must_use]
    pub fn brings_to_rest(&self) -> bool {
        match self {
            Self::Land | Self::ReturnToLaunch | Self::EmergencyStop | Self::Disarm => true,
            Self::SetMode { mode } => {
                matches!(mode, FlightMode::Hold | FlightMode::Land | FlightMode::Return)
            }
            Self::Arm | Self::TakeOff { .. } | Self::EnterOffboard => false,
        }
    }
}
