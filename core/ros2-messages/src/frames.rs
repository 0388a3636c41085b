//! From Skein's frames to those of ROS: the swarm's north-east-down to REP-103's east-north-up, forward-right-down to forward-left-up, and back.
//!
//! | frame (REP-105) | what it is |
//! |---|---|
//! | `map` | the swarm's common frame: metres east, north and up of its origin |
//! | `<vehicle>/odom` | the same axes about the vehicle's launch place |
//! | `<vehicle>/base_link` | the vehicle: forward, left, up |
//!
//! Must never do: read a clock, or know where a value came from.

use crate::interfaces::Fixed;
use crate::interfaces::geometry::{Point, Quaternion, Vector3};
use nalgebra::{Matrix3, UnitQuaternion, Vector3 as Vector};
use skein_domain::frames::wrap_angle_rad;
use skein_domain::{PositionNed, Stick, VelocityNed};
use std::f64::consts::FRAC_PI_2;

/// The common frame.
pub const MAP: &str = "map";

/// Axes of north-east-down as east-north-up, or the other way: it is its own inverse.
fn swapped(v: Vector<f64>) -> Vector<f64> {
    Vector::new(v.y, v.x, -v.z)
}

/// A position of the swarm's frame in `map`, in metres.
#[must_use]
pub fn point(position: &PositionNed) -> Point {
    let v = swapped(position.vector());
    Point { x: v.x, y: v.y, z: v.z }
}

/// A place in `map` in the swarm's frame, in metres.
#[must_use]
pub fn position(point: &Point) -> PositionNed {
    swapped(Vector::new(point.x, point.y, point.z)).into()
}

/// A covariance of a position along north, east and down as one of a pose in `map`, in square metres. How it is turned is not known, and stands there as 0.
#[must_use]
pub fn covariance(ned: &Matrix3<f64>) -> Fixed<36> {
    let swap = Matrix3::from_columns(&[Vector::x(), Vector::y(), Vector::z()].map(swapped));
    let enu = swap * ned * swap.transpose();
    let mut whole = Fixed::default();
    for row in 0..3 {
        for column in 0..3 {
            whole.0[6 * row + column] = enu[(row, column)];
        }
    }
    whole
}

/// A velocity along the axes of `map`, in metres per second.
#[must_use]
pub fn velocity(velocity: &VelocityNed) -> Vector3 {
    vector(swapped(velocity.vector()))
}

/// A yaw clockwise from north as one counter-clockwise from east, or the other way: it is its own inverse. In radians, -pi..=pi.
#[must_use]
pub fn yaw_rad(yaw_rad: f64) -> f64 {
    wrap_angle_rad(FRAC_PI_2 - yaw_rad)
}

/// Roll, pitch and yaw of a body of forward-right-down in north-east-down, in radians, as the orientation of forward-left-up in `map`.
#[must_use]
pub fn orientation(roll_rad: f64, pitch_rad: f64, yaw_cw_rad: f64) -> Quaternion {
    quaternion(attitude(roll_rad, pitch_rad, yaw_cw_rad))
}

fn attitude(roll_rad: f64, pitch_rad: f64, yaw_cw_rad: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_euler_angles(roll_rad, -pitch_rad, yaw_rad(yaw_cw_rad))
}

/// The orientation of a camera's optical frame (to the right, down, along the axis) in `map`, from roll, pitch (upwards) and yaw (clockwise
/// from north) of its axis, in radians.
#[must_use]
pub fn optical(roll_rad: f64, pitch_rad: f64, yaw_cw_rad: f64) -> Quaternion {
    // Along x of the body is along z of the optical frame, to the left is against its x, up is against its y.
    let of_body = UnitQuaternion::from_euler_angles(-FRAC_PI_2, 0.0, -FRAC_PI_2);
    quaternion(attitude(roll_rad, pitch_rad, yaw_cw_rad) * of_body)
}

/// A velocity of the swarm's frame along the axes of a body with this attitude: forward, left, up, in metres per second.
#[must_use]
pub fn velocity_in_body(velocity: &VelocityNed, roll_rad: f64, pitch_rad: f64, yaw_cw_rad: f64) -> Vector3 {
    let turned = attitude(roll_rad, pitch_rad, yaw_cw_rad).inverse() * swapped(velocity.vector());
    vector(turned)
}

/// A velocity forward, left and up of a level body, in metres per second, and its turning about up, in radians per second, as a stick.
#[must_use]
pub fn stick(body: &Vector3, turning_rad_s: f64) -> Stick {
    Stick {
        forward_m_s: body.x,
        right_m_s: -body.y,
        up_m_s: body.z,
        yaw_rate_rad_s: -turning_rad_s,
    }
}

/// Pitch (upwards positive) and yaw (clockwise) of a direction, in radians: from north for one of `map`, from the nose for one of a body.
/// Nothing for one without a length.
#[must_use]
pub fn look(direction: &Vector3, in_map: bool) -> Option<(f64, f64)> {
    let level = direction.x.hypot(direction.y);
    let length = level.hypot(direction.z);
    if !(length.is_finite() && length > f64::MIN_POSITIVE) {
        return None;
    }
    let yaw_cw_rad = if in_map {
        direction.x.atan2(direction.y)
    } else {
        (-direction.y).atan2(direction.x)
    };
    Some((direction.z.atan2(level), yaw_cw_rad))
}

fn vector(v: Vector<f64>) -> Vector3 {
    Vector3 { x: v.x, y: v.y, z: v.z }
}

/// As the message writes it, with a positive real part.
fn quaternion(q: UnitQuaternion<f64>) -> Quaternion {
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    Quaternion {
        x: sign * q.i,
        y: sign * q.j,
        z: sign * q.k,
        w: sign * q.w,
    }
}

/// No rotation.
#[must_use]
pub fn unrotated() -> Quaternion {
    quaternion(UnitQuaternion::identity())
}

#[cfg(test)]
mod tests;
