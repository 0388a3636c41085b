//! One setpoint: what a vehicle should do now. Fields left out are the autopilot's to choose.

use crate::{AccelerationNed, LocalPositionNed, PositionNed, VelocityNed};
use minicbor::{Decode, Encode};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// A setpoint in the swarm frame. A position with a velocity and an acceleration is tracked with feed-forward.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Default,
    Serialize,
    Deserialize,
    Encode,
    Decode,
    schemars::JsonSchema
)]
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
    /// How strongly the air slows this vehicle down, in 1/s: what it takes to keep a velocity against that is added to the acceleration
    /// when the setpoint is handed to the autopilot ([`Self::forward_acceleration`]), after everyone who judges it or changes its velocity.
    #[n(5)]
    pub drag_per_s: Option<f64>,
}

/// No vehicle is taken to be slowed down more strongly than this, in 1/s.
pub const DRAG_MAX_PER_S: f64 = 1.2;
/// No more acceleration than this is added against drag, in metres per second squared.
const AGAINST_DRAG_MAX_M_S2: f64 = 5.0;

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
            && self.drag_per_s.is_none_or(f64::is_finite)
    }

    /// The acceleration an autopilot is to be given: the asked one, and level what the velocity takes against the drag.
    #[must_use]
    pub fn forward_acceleration(&self) -> Option<AccelerationNed> {
        let (Some(drag_per_s), Some(velocity)) = (self.drag_per_s, self.velocity) else {
            return self.acceleration;
        };
        let level = Vector3::new(velocity.north_m_s, velocity.east_m_s, 0.0);
        let against = (level * drag_per_s.clamp(0.0, DRAG_MAX_PER_S)).cap_magnitude(AGAINST_DRAG_MAX_M_S2);
        Some((self.acceleration.unwrap_or_default().vector() + against).into())
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

#[cfg(test)]
mod tests;
