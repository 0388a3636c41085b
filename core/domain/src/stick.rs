//! A stick: how somebody who steers a vehicle by hand wants it to move at this moment.
//!
//! Must never do: decide how fast a vehicle may be; that is its model's and the gate's.

use crate::{Refusal, VelocityNed};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A stick is good for so long, in seconds. After that the vehicle brakes and stands until the next one comes.
pub const STICK_GOOD_S: f64 = 0.5;
/// Without a stick for so long, in seconds, a flight by hand is over.
pub const HAND_GONE_S: f64 = 10.0;
/// No multicopter is asked to fly faster, in metres per second: a number beyond it is a slip.
pub const FASTEST_STICK_M_S: f64 = 50.0;
/// None is asked to turn faster, in radians per second.
pub const FASTEST_STICK_RAD_S: f64 = TAU;

/// A wanted motion along the axes of the level vehicle: forward is where its nose is asked to point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stick {
    /// Forward in metres per second.
    #[n(0)]
    pub forward_m_s: f64,
    /// To the right in metres per second.
    #[n(1)]
    pub right_m_s: f64,
    /// Up in metres per second.
    #[n(2)]
    pub up_m_s: f64,
    /// Turning clockwise as seen from above, in radians per second.
    #[n(3)]
    pub yaw_rate_rad_s: f64,
}

impl Stick {
    /// Whether its numbers can be meant.
    ///
    /// # Errors
    /// [`Refusal::InvalidValue`] with the first that cannot.
    pub fn check(&self) -> Result<(), Refusal> {
        for (name, value, most) in [
            ("forward_m_s", self.forward_m_s, FASTEST_STICK_M_S),
            ("right_m_s", self.right_m_s, FASTEST_STICK_M_S),
            ("up_m_s", self.up_m_s, FASTEST_STICK_M_S),
            ("yaw_rate_rad_s", self.yaw_rate_rad_s, FASTEST_STICK_RAD_S),
        ] {
            // Written so that what is no number is refused too.
            if !(-most..=most).contains(&value) {
                let detail = format!("`{name}`: {value} is not within {:.1} to {most:.1}", -most);
                return Err(Refusal::InvalidValue { detail });
            }
        }
        Ok(())
    }

    /// The wanted velocity of a vehicle that looks to `heading_rad`, clockwise from north.
    #[must_use]
    pub fn velocity(&self, heading_rad: f64) -> VelocityNed {
        let (sin, cos) = heading_rad.sin_cos();
        VelocityNed {
            north_m_s: self.forward_m_s * cos - self.right_m_s * sin,
            east_m_s: self.forward_m_s * sin + self.right_m_s * cos,
            down_m_s: -self.up_m_s,
        }
    }
}

#[cfg(test)]
mod tests;
