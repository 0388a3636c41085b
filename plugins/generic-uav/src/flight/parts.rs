//! What the parts of a flight keep of it: a request to the autopilot, a goal, a place among neighbours, a hand on the stick.
//!
//! Must never do: decide anything. What is done with them is in the modules of the same names.

use crate::blend::Motion;
use minicbor::{Decode, Encode};
use skein_domain::{
    AccelerationNed, CommandId, NodeTime, PositionNed, Refusal, RequestId, VehicleCommand, VelocityNed,
};

/// A goal's motion is carried on for at most this long, in seconds.
const LONGEST_EXTRAPOLATION_S: f64 = 1.0;

/// A request and how often it was made.
#[derive(Debug, Clone, PartialEq, Default, Encode, Decode)]
pub(crate) struct Asking {
    /// How often it was made.
    #[n(0)]
    pub attempts: u32,
    /// The one whose answer is awaited, and when it was made, in heard seconds.
    #[n(1)]
    pub outstanding: Option<(RequestId, f64)>,
    /// Not to be made again before, in heard seconds.
    #[n(2)]
    pub not_before_s: f64,
    /// The last answer, if it was a refusal.
    #[n(3)]
    pub refusal: Option<Refusal>,
    /// When it was accepted, in heard seconds. The state that should follow may take a little longer to be seen.
    #[n(4)]
    pub accepted_s: Option<f64>,
}

/// Where to be, moving.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub struct Goal {
    /// Where at `time`.
    #[n(0)]
    pub position: PositionNed,
    /// How fast it moves.
    #[n(1)]
    pub velocity: VelocityNed,
    /// When that was.
    #[n(2)]
    pub time: NodeTime,
    /// Horizontal speed not to be exceeded on the way, in metres per second.
    #[n(3)]
    pub speed_m_s: f64,
}

impl Goal {
    /// Where it is at a moment.
    #[must_use]
    pub fn at(&self, now: NodeTime) -> PositionNed {
        let age_s = now.seconds_since(self.time).clamp(0.0, LONGEST_EXTRAPOLATION_S);
        self.position.after(&self.velocity, age_s)
    }

    pub(crate) fn is_usable(&self) -> bool {
        self.position.is_finite() && self.velocity.is_finite() && self.speed_m_s.is_finite() && self.speed_m_s > 0.0
    }
}

/// A flight whose goal comes from outside of this model.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Guided {
    /// The command it began with.
    #[n(0)]
    pub id: CommandId,
    #[n(1)]
    pub command: VehicleCommand,
    /// Brakes and stands while there is none.
    #[n(2)]
    pub goal: Option<Goal>,
}

/// The reference of a vehicle that keeps its place among neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Kept {
    #[n(0)]
    pub position: PositionNed,
    #[n(1)]
    pub velocity: VelocityNed,
    #[n(2)]
    pub acceleration: AccelerationNed,
    /// How far the place is off, in metres.
    #[n(3)]
    pub error_m: f64,
    /// How many neighbours it goes by.
    #[n(4)]
    pub neighbours: u32,
}

impl Kept {
    /// From the motion it has.
    pub(crate) fn from(have: &Motion) -> Self {
        Self {
            position: have.position,
            velocity: have.velocity,
            acceleration: AccelerationNed::default(),
            error_m: 0.0,
            neighbours: 0,
        }
    }

    pub(crate) fn motion(&self) -> Motion {
        Motion {
            position: self.position,
            velocity: self.velocity,
            acceleration: self.acceleration,
        }
    }
}

/// A flight by hand, but for the stick itself: one from before a restart is not followed.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Steered {
    /// When a stick last came, or the flight began.
    #[n(0)]
    pub heard: NodeTime,
    /// How fast it turns.
    #[n(1)]
    pub yaw_rate_rad_s: f64,
}
