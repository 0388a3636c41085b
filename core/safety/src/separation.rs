//! Whether the motion that a setpoint asks for brings a vehicle too close to another one.

use nalgebra::Vector3;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, Refusal, Setpoint, VehicleId};

/// Another vehicle as this one sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peer {
    /// Its id.
    pub id: VehicleId,
    /// Its measured motion.
    pub kinematics: VehicleKinematics,
    /// Whether it is in the air; one on the ground is no obstacle to a vehicle in the air.
    pub airborne: bool,
}

/// A distance between asked and measured position up to this is usual: tracking error and noise, not a way to be flown, in metres.
const TRACKING_ERROR_M: f64 = 1.0;
/// A larger one is flown off at this rate, per second (about what a position controller does).
const POSITION_GAIN_PER_S: f64 = 1.0;
/// Measured states are carried on for at most this long, in seconds.
const MAX_AGE_S: f64 = 0.5;
/// Slower than this, in metres per second, nobody counts as flying towards anybody.
const STILL_M_S: f64 = 0.15;

/// The own motion as a setpoint asks for it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion {
    /// Where the vehicle is measured to be now.
    measured: Vector3<f64>,
    /// Where it is if it is as near to the asked position as it usually is.
    asked: Vector3<f64>,
    /// How it will move.
    velocity: Vector3<f64>,
}

/// Where something measured a little ago is now.
fn carried_on(kinematics: &VehicleKinematics, now: NodeTime) -> Vector3<f64> {
    let age_s = now.seconds_since(kinematics.measured).clamp(0.0, MAX_AGE_S);
    kinematics.position.vector() + kinematics.velocity.vector() * age_s
}

impl Motion {
    /// What the setpoint makes of the present state. `max_speed_m_s` bounds how fast a far position is flown to.
    pub fn new(own: &VehicleKinematics, setpoint: &Setpoint, max_speed_m_s: f64, now: NodeTime) -> Self {
        let measured = carried_on(own, now);
        let feed_forward = setpoint.velocity.map_or_else(Vector3::zeros, |v| v.vector());
        let Some(position) = setpoint.position else {
            return Self {
                measured,
                asked: measured,
                velocity: feed_forward,
            };
        };
        let left = position.vector() - measured;
        let left_m = left.norm();
        if left_m <= TRACKING_ERROR_M {
            return Self {
                measured,
                asked: position.vector(),
                velocity: feed_forward,
            };
        }
        let direction = left / left_m;
        let wanted = feed_forward + direction * ((left_m - TRACKING_ERROR_M) * POSITION_GAIN_PER_S);
        let speed = wanted.norm();
        let velocity = if speed > max_speed_m_s {
            wanted * (max_speed_m_s / speed)
        } else {
            wanted
        };
        Self {
            measured,
            asked: measured + direction * TRACKING_ERROR_M,
            velocity,
        }
    }

    /// The worst approach to any peer in the air that gets below `limit_m` within `horizon_s`, if the own motion has a part in it.
    pub fn too_close(
        &self,
        own: VehicleId,
        peers: &[Peer],
        limit_m: f64,
        horizon_s: f64,
        now: NodeTime,
    ) -> Option<Refusal> {
        let mut worst: Option<(f64, VehicleId)> = None;
        let near_m = limit_m + TRACKING_ERROR_M;
        for peer in peers {
            if !peer.airborne || peer.id == own {
                continue;
            }
            // The box comes first and costs little: most peers are far away.
            let (v, p) = (&peer.kinematics.velocity, &peer.kinematics.position);
            let age_s = now.seconds_since(peer.kinematics.measured).clamp(0.0, MAX_AGE_S);
            let north = p.north_m + v.north_m_s * age_s - self.measured.x;
            if north.abs() > near_m + horizon_s * (v.north_m_s - self.velocity.x).abs() {
                continue;
            }
            let east = p.east_m + v.east_m_s * age_s - self.measured.y;
            if east.abs() > near_m + horizon_s * (v.east_m_s - self.velocity.y).abs() {
                continue;
            }
            let there = carried_on(&peer.kinematics, now);
            let closest_m = self.closest_m(&there, &v.vector(), limit_m, horizon_s);
            if closest_m < limit_m && worst.is_none_or(|(least_m, _)| closest_m < least_m) {
                worst = Some((closest_m, peer.id));
            }
        }
        worst.map(|(distance_m, other)| Refusal::TooClose {
            other,
            distance_m,
            limit_m,
        })
    }

    /// The closest approach that the own motion brings about, by the more favourable of both guesses of where the vehicle is:
    /// the measured place shares its errors of delay with the peer's, the asked one has no noise. Infinite if it does not come
    /// closer, or not by its own motion.
    fn closest_m(&self, there: &Vector3<f64>, their_velocity: &Vector3<f64>, limit_m: f64, horizon_s: f64) -> f64 {
        let mut most_m = 0.0_f64;
        for here in [&self.measured, &self.asked] {
            let apart = there - here;
            let relative = their_velocity - self.velocity;
            let present_m = apart.norm();
            let towards_m_s = if present_m > 0.0 {
                self.velocity.dot(&apart) / present_m
            } else {
                0.0
            };
            let closing = -apart.dot(&relative);
            // Also what is not a number ends here.
            let comes_closer = closing > STILL_M_S * present_m && towards_m_s > STILL_M_S;
            if !comes_closer {
                return f64::INFINITY;
            }
            let at_s = (closing / relative.norm_squared()).clamp(0.0, horizon_s);
            most_m = most_m.max((apart + relative * at_s).norm());
            if most_m >= limit_m {
                return most_m;
            }
        }
        most_m
    }
}

#[cfg(test)]
mod tests;
