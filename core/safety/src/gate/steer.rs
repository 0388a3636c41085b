//! What becomes of a setpoint in flight: refused if it makes no sense or asks for a place behind a fence, else changed as little as keeps
//! the vehicle off others and inside of the fences.

use super::Gate;
use crate::avoidance::{AvoidanceSettings, Change, Conditions, Filtered, Surroundings, as_velocity, filter};
use crate::fence::Approach;
use crate::half_space::HalfSpace;
use nalgebra::Vector3;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, Refusal, Setpoint, VehicleId};

/// How far inside of a boundary a vehicle is kept, in metres, for what its known place and its control may be wrong by: the boundary is to
/// be kept in the truth.
const FENCE_MARGIN_M: f64 = 0.8;
/// A place that moves slower than this stands still, in metres per second.
const STANDS_M_S: f64 = 0.5;
/// Who holds outside of a fence comes back by this part of the way per second, and no faster than this in metres per second.
const BACK_PER_S: f64 = 0.5;
const BACK_MAX_M_S: f64 = 1.0;

/// The vehicle whose setpoints are steered.
#[derive(Debug, Clone, Copy)]
pub struct Steering<'a> {
    /// Which.
    pub id: VehicleId,
    /// As it was measured.
    pub kinematics: &'a VehicleKinematics,
    /// On the ground nothing is changed.
    pub airborne: bool,
    /// The height of the ground under it in the swarm's frame, positive down: of the place it took off from. Without one there is no
    /// floor.
    pub ground_down_m: Option<f64>,
}

/// A setpoint that may be sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steered {
    /// What to send.
    pub setpoint: Setpoint,
    /// What was changed of the one that was wanted.
    pub change: Option<Change>,
}

impl Gate {
    /// What the separation filter assumes and demands.
    #[must_use]
    pub fn avoidance(&self) -> AvoidanceSettings {
        let limits = &self.limits;
        AvoidanceSettings {
            min_separation_m: limits.min_separation_m,
            horizon_s: limits.separation_horizon_s,
            max_speed_m_s: limits.max_speed_m_s,
            max_climb_m_s: limits.max_climb_m_s,
            max_descent_m_s: limits.max_descent_m_s,
            ..AvoidanceSettings::default()
        }
    }

    /// The setpoint that a vehicle may be given in place of the wanted one, among everything else in the air.
    ///
    /// # Errors
    /// The typed reason: it is not well-formed, too fast, or asks for a place behind a fence.
    pub fn steer(
        &self,
        own: &Steering<'_>,
        wanted: &Setpoint,
        surroundings: &Surroundings,
        now: NodeTime,
    ) -> Result<Steered, Refusal> {
        if !wanted.is_well_formed() {
            return Err(Refusal::invalid(
                "a setpoint needs a position or a velocity, and finite numbers only",
            ));
        }
        let here = own.kinematics;
        if !here.position.is_finite() || !here.velocity.is_finite() {
            return Err(Refusal::NoPosition);
        }
        if let Some(velocity) = &wanted.velocity {
            self.velocity(velocity)?;
        }
        if !own.airborne {
            self.setpoint_on_the_ground(here, wanted)?;
            return Ok(Steered {
                setpoint: *wanted,
                change: None,
            });
        }
        let along = self.along_the_fence(own, wanted, now)?;
        let wanted = along.as_ref().unwrap_or(wanted);
        let bounds = self.bounds(own);
        Ok(self.filtered(own, wanted, &bounds, surroundings, now).into())
    }

    /// What is flown in place of a refused setpoint: holding a place as far as keeps the vehicle off others, and back inside of the
    /// fences if it has come out of them.
    #[must_use]
    pub fn hold(&self, own: &Steering<'_>, hold: &Setpoint, surroundings: &Surroundings, now: NodeTime) -> Steered {
        if !own.airborne {
            return Steered {
                setpoint: *hold,
                change: None,
            };
        }
        let mut bounds = self.bounds(own);
        let outside_m = self.fences.excess(&own.kinematics.position).distance_m();
        if outside_m > 0.0 {
            // Outside the directions that lead further out are closed: back along them.
            let back_m_s = (BACK_PER_S * outside_m).min(BACK_MAX_M_S);
            for closed in bounds.iter_mut().filter(|b| b.limit_m_s <= 0.0) {
                closed.limit_m_s = -back_m_s;
            }
        }
        self.filtered(own, hold, &bounds, surroundings, now).into()
    }

    /// The conditions on the velocity that fences and the ground set, beside those of the others.
    fn bounds(&self, own: &Steering<'_>) -> Vec<HalfSpace> {
        let settings = self.avoidance();
        let approach = Approach {
            max_speed_m_s: settings.max_speed_m_s,
            braking_m_s2: settings.braking_m_s2,
            reaction_s: settings.reaction_s,
            margin_m: FENCE_MARGIN_M,
        };
        let here = &own.kinematics.position;
        let mut bounds = self.fences.velocity_limits(here, &approach);
        if let Some(ground_down_m) = own.ground_down_m.filter(|down_m| down_m.is_finite()) {
            let above_floor_m = ground_down_m - self.min_height_m - here.down_m;
            let to_the_floor = Approach {
                margin_m: 0.0,
                ..approach
            };
            bounds.push(HalfSpace {
                normal: Vector3::z(),
                limit_m_s: to_the_floor.speed_m_s(above_floor_m),
            });
        }
        bounds
    }

    /// A place behind a fence that moves along, such as a slot of a formation that reaches over the boundary, becomes the velocity with
    /// which it would be flown to: the fences' bounds leave of it what leads along the boundary, so that the vehicle keeps up on the
    /// inside. `None` where the place may be flown to.
    ///
    /// # Errors
    /// Of a place that stands still behind a fence: nothing is gained by going nearer.
    fn along_the_fence(
        &self,
        own: &Steering<'_>,
        wanted: &Setpoint,
        now: NodeTime,
    ) -> Result<Option<Setpoint>, Refusal> {
        let Some(position) = &wanted.position else {
            return Ok(None);
        };
        let Err(refusal) = self.fences.may_move(&own.kinematics.position, position, true) else {
            return Ok(None);
        };
        let moves = wanted.velocity.is_some_and(|v| v.norm() > STANDS_M_S);
        let velocity = as_velocity(own.id, own.kinematics, wanted, &self.avoidance(), now).filter(|_| moves);
        velocity.map(Some).ok_or(refusal)
    }

    fn filtered(
        &self,
        own: &Steering<'_>,
        wanted: &Setpoint,
        bounds: &[HalfSpace],
        surroundings: &Surroundings,
        now: NodeTime,
    ) -> Filtered {
        let conditions = Conditions {
            surroundings,
            bounds,
            settings: &self.avoidance(),
        };
        filter(own.id, own.kinematics, wanted, &conditions, now)
    }
}

impl From<Filtered> for Steered {
    fn from(filtered: Filtered) -> Self {
        Self {
            setpoint: filtered.setpoint,
            change: filtered.change,
        }
    }
}

#[cfg(test)]
mod tests;
