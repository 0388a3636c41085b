//! Between setpoints and velocities: what an autopilot makes of a setpoint, and the setpoint that makes it fly a velocity.

use super::AvoidanceSettings;
use super::nearest::{Row, SpeedLimits};
use nalgebra::{Vector2, Vector3};
use skein_domain::Setpoint;

/// The velocity that PX4's position control steers for: feed-forward plus gain times what is left of the way, within the limits;
/// what the position asks for has precedence.
pub(super) fn velocity(
    setpoint: &Setpoint,
    position: &Vector3<f64>,
    settings: &AvoidanceSettings,
    limits: &SpeedLimits,
) -> Vector3<f64> {
    let forward = setpoint.velocity.map_or_else(Vector3::zeros, |v| v.vector());
    let Some(place) = setpoint.position else {
        return forward;
    };
    let back = (place.vector() - position) * settings.position_gain_per_s;
    let level = level(back.xy(), forward.xy(), limits.horizontal_m_s);
    let down = (back.z + forward.z).max(-limits.up_m_s).min(limits.down_m_s);
    Vector3::new(level.x, level.y, down)
}

fn level(first: Vector2<f64>, second: Vector2<f64>, limit: f64) -> Vector2<f64> {
    let sum = first + second;
    if sum.norm() <= limit {
        return sum;
    }
    let length = first.norm();
    if length >= limit {
        return first * (limit / length);
    }
    let direction = second.try_normalize(1e-9).unwrap_or_else(Vector2::zeros);
    let along = direction.dot(&first);
    let reach = (along * along - length * length + limit * limit).max(0.0).sqrt() - along;
    first + direction * reach
}

/// The setpoint that flies `safe` instead of what was wanted: a velocity without a place, the yaw kept, and of the acceleration
/// what does not push against the rows that bind.
pub(super) fn setpoint(wanted: &Setpoint, safe: &Vector3<f64>, rows: &[Row]) -> Setpoint {
    let acceleration = wanted.acceleration.map(|a| {
        let mut left = a.vector();
        for row in rows.iter().filter(|row| row.excess(safe) > -1e-3) {
            left -= row.normal * row.normal.dot(&left).max(0.0);
        }
        left.into()
    });
    Setpoint {
        position: None,
        velocity: Some((*safe).into()),
        acceleration,
        ..*wanted
    }
}
