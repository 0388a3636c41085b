//! One setpoint: what a vehicle should do now. Fields left out are the autopilot's to choose.

use crate::{AccelerationNed, LocalPositionNed, PositionNed, VelocityNed};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// A setpoint in the swarm frame. A position with a velocity and an acceleration is tracked with feed-forward.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, Encode, Decode)]
pub struct Setpoint {
    /// Where to be, in the swarm frame.
    #[n(0)]
    pub position: Option<PositionNed>,
    /// How fast to move; feed-forward when a position is given too.
    #[n(1)]
    pub velocity: Option<VelocityNed>,
    /// Acceleration feed-forward.
    #[n(2)]
    pub acceleration: Option<AccelerationNed>,
    /// Yaw in radians, clockwise from north.
    #[n(3)]
    pub yaw_rad: Option<f64>,
    /// Yaw rate in radians per second.
    #[n(4)]
    pub yaw_rate_rad_s: Option<f64>,
}

impl Setpoint {
    /// Stay at `position`, looking to `yaw_rad`.
    #[must_use]
    pub fn hold(position: PositionNed, yaw_rad: Option<f64>) -> Self {
        Self {
            position: Some(position),
            yaw_rad,
            ..Self::default()
        }
    }

    /// Whether every number in it is finite and at least a position or a velocity is given.
    #[must_use]
    pub fn is_well_formed(&self) -> bool {
        (self.position.is_some() || self.velocity.is_some())
            && self.position.is_none_or(|p| p.is_finite())
            && self.velocity.is_none_or(|v| v.is_finite())
            && self.acceleration.is_none_or(|a| a.is_finite())
            && self.yaw_rad.is_none_or(f64::is_finite)
            && self.yaw_rate_rad_s.is_none_or(f64::is_finite)
    }
}

/// The same for a link: the position is in the vehicle's own frame. Only the vehicle actor makes one, after the safety gate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LocalSetpoint {
    /// Where to be, in the vehicle's own frame.
    pub position: Option<LocalPositionNed>,
    /// How fast to move.
    pub velocity: Option<VelocityNed>,
    /// Acceleration feed-forward.
    pub acceleration: Option<AccelerationNed>,
    /// Yaw in radians, clockwise from north.
    pub yaw_rad: Option<f64>,
    /// Yaw rate in radians per second.
    pub yaw_rate_rad_s: Option<f64>,
}
