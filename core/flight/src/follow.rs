//! What a follower should do now: the leader's anchor carried on to this moment, plus the vehicle's own slot, turned with the
//! formation, all with feed-forward.

use crate::transition;
use nalgebra::Vector3;
use skein_domain::frames::wrap_angle_rad;
use skein_domain::{AnchorReference, NodeTime, Setpoint, SlotMove};

/// The anchor is carried on for at most this long in seconds. After that the slot stands still where it was last expected: a
/// velocity that nobody has confirmed for so long is not to be flown.
pub const MAX_EXTRAPOLATION_S: f64 = 1.0;

/// The setpoint of the follower in `slot` at `now`: position, velocity with the turning of the formation (ω × r), acceleration with
/// its centripetal, Coriolis and Euler parts, yaw along the formation's heading.
#[must_use]
pub fn setpoint(anchor: &AnchorReference, slot: &SlotMove, now: NodeTime) -> Setpoint {
    let age_s = now.seconds_since(anchor.time).max(0.0);
    let stale = age_s > MAX_EXTRAPOLATION_S;
    let dt = age_s.min(MAX_EXTRAPOLATION_S);
    let (v0, a0) = (anchor.velocity.vector(), anchor.acceleration.vector());
    let change = anchor.heading_acceleration_rad_s2;
    let rate = anchor.heading_rate_rad_s + change * dt;
    let heading = wrap_angle_rad(anchor.heading_rad + (anchor.heading_rate_rad_s + 0.5 * change * dt) * dt);
    let here = transition::sample(slot, now);

    let turned = |frd: Vector3<f64>| skein_domain::OffsetFrd::from(frd).rotated(heading);
    let arm = here.offset.rotated(heading);
    let across = |v: &Vector3<f64>| Vector3::new(-v.y, v.x, 0.0);
    let position = anchor.position.vector() + v0 * dt + a0 * (0.5 * dt * dt) + arm;
    let (slot_velocity, slot_acceleration) = (turned(here.velocity), turned(here.acceleration));
    if stale {
        return Setpoint {
            position: Some(position.into()),
            velocity: Some(slot_velocity.into()),
            acceleration: Some(slot_acceleration.into()),
            yaw_rad: Some(heading),
            yaw_rate_rad_s: Some(0.0),
            drag_per_s: None,
        };
    }
    let velocity = v0 + a0 * dt + slot_velocity + across(&arm) * rate;
    let centripetal = Vector3::new(arm.x, arm.y, 0.0) * (-rate * rate);
    let coriolis = across(&slot_velocity) * (2.0 * rate);
    let euler = across(&arm) * change;
    Setpoint {
        position: Some(position.into()),
        velocity: Some(velocity.into()),
        acceleration: Some((a0 + slot_acceleration + coriolis + centripetal + euler).into()),
        yaw_rad: Some(heading),
        yaw_rate_rad_s: Some(rate),
        drag_per_s: None,
    }
}

#[cfg(test)]
mod tests;
