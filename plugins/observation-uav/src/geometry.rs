//! Directions and circles: where to stand to look at something, and which way that is.

use nalgebra::Vector3;
use skein_plugin_sdk::domain::PositionNed;

/// A direction to look in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Direction {
    /// Clockwise from north, in radians.
    pub yaw_rad: f64,
    /// Above the horizon, in radians.
    pub pitch_rad: f64,
}

impl Direction {
    /// From one place to another; `None` if they are the same.
    pub(crate) fn from_to(from: &PositionNed, to: &PositionNed) -> Option<Self> {
        let off = to.vector() - from.vector();
        let across_m = off.xy().norm();
        (off.norm() > 0.01 && off.norm().is_finite()).then(|| Self {
            yaw_rad: off.y.atan2(off.x),
            pitch_rad: (-off.z).atan2(across_m),
        })
    }

    fn unit(&self) -> Vector3<f64> {
        let (sin_yaw, cos_yaw) = self.yaw_rad.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch_rad.sin_cos();
        Vector3::new(cos_pitch * cos_yaw, cos_pitch * sin_yaw, -sin_pitch)
    }

    /// The angle between two, in radians.
    pub(crate) fn angle_to_rad(&self, other: &Self) -> f64 {
        self.unit().dot(&other.unit()).clamp(-1.0, 1.0).acos()
    }
}

/// The place at a horizontal distance and a height from `centre`, seen from there along `bearing_rad`.
pub(crate) fn on_circle(centre: &PositionNed, bearing_rad: f64, stand_off_m: f64, height_m: f64) -> PositionNed {
    let (sin, cos) = bearing_rad.sin_cos();
    centre.moved(Vector3::new(cos * stand_off_m, sin * stand_off_m, -height_m))
}

/// On the way around a circle one goes at most so far ahead at once, in radians: the straight way there stays well off its middle.
const AHEAD_RAD: f64 = 1.0;

/// The next bearing on the shorter way around from one to another.
pub(crate) fn on_the_way(from_rad: f64, to_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let left_rad = (to_rad - from_rad + PI).rem_euclid(TAU) - PI;
    from_rad + left_rad.clamp(-AHEAD_RAD, AHEAD_RAD)
}

/// The bearing from `centre` to `place`, in radians; `None` if they are so near to each other that it means nothing.
pub(crate) fn bearing_rad(centre: &PositionNed, place: &PositionNed) -> Option<f64> {
    let off = place.vector() - centre.vector();
    (off.xy().norm() > 1.0).then(|| off.y.atan2(off.x))
}
