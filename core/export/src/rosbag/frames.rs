//! From the swarm's north, east and down to `map`, east, north and up (REP-103), as `core/ros2` has it.
//!
//! Must never do: read a clock, or know where a value came from.

use super::messages::{Point, Quaternion, Vector3};
use nalgebra::UnitQuaternion;
use skein_domain::frames::wrap_angle_rad;
use skein_domain::{PositionNed, VelocityNed};
use std::f64::consts::FRAC_PI_2;

/// The common frame.
pub(super) const MAP: &str = "map";

pub(super) fn point(of: &PositionNed) -> Point {
    Point {
        x: of.east_m,
        y: of.north_m,
        z: -of.down_m,
    }
}

pub(super) fn translation(of: &PositionNed) -> Vector3 {
    let Point { x, y, z } = point(of);
    Vector3 { x, y, z }
}

pub(super) fn velocity(of: &VelocityNed) -> Vector3 {
    Vector3 {
        x: of.east_m_s,
        y: of.north_m_s,
        z: -of.down_m_s,
    }
}

/// Roll, pitch and yaw of a body of forward, right, down in north, east, down as the orientation of forward, left, up in `map`.
pub(super) fn orientation(roll_rad: f64, pitch_rad: f64, yaw_cw_rad: f64) -> Quaternion {
    let yaw_rad = wrap_angle_rad(FRAC_PI_2 - yaw_cw_rad);
    let q = UnitQuaternion::from_euler_angles(roll_rad, -pitch_rad, yaw_rad);
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    Quaternion {
        x: sign * q.i,
        y: sign * q.j,
        z: sign * q.k,
        w: sign * q.w,
    }
}

pub(super) fn unrotated() -> Quaternion {
    Quaternion {
        w: 1.0,
        ..Quaternion::default()
    }
}
