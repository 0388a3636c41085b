//! What becomes of a setpoint in flight: refused if it makes no sense or asks for a place behind a fence, else changed as little as keeps
//! the vehicle off others and inside of the fences.

use super::{Gate, invalid};
use crate::avoidance::{AvoidanceSettings, Change, Surroundings, as_velocity, filter_in};
use crate::fence::Approach;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, Refusal, Setpoint, VehicleId};

/// How far inside of a boundary a vehicle is kept, in metres, for what its known place and its control may be wrong by: the boundary is to
/// be kept in the truth.
const FENCE_MARGIN_M: f64 = 0.8;
/// A place that moves slower than this stands still, in metres per second.
const STANDS_M_S: f64 = 0.5;

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
        own: VehicleId,
        own_kinematics: &VehicleKinematics,
        airborne: bool,
        wanted: &Setpoint,
        surroundings: &Surroundings,
        now: NodeTime,
    ) -> Result<Steered, Refusal> {
        if !wanted.is_well_formed() {
            return Err(invalid(
                "a setpoint needs a position or a velocity, and finite numbers only",
            ));
        }
        if !own_kinematics.position.is_finite() || !own_kinematics.velocity.is_finite() {
            return Err(Refusal::NoPosition);
        }
        if let Some(velocity) = &wanted.velocity {
            self.velocity(velocity)?;
        }
        if !airborne {
            self.setpoint_in_fences(own_kinematics, airborne, wanted)?;
            return Ok(Steered {
                setpoint: *wanted,
                change: None,
            });
        }
        let settings = self.avoidance();
        let along = self.along_the_fence(own, own_kinematics, wanted, &settings, now)?;
        let wanted = along.as_ref().unwrap_or(wanted);
        let approach = Approach {
            max_speed_m_s: settings.max_speed_m_s,
            braking_m_s2: settings.braking_m_s2,
            reaction_s: settings.reaction_s,
            margin_m: FENCE_MARGIN_M,
        };
        // The fences' conditions on the velocity, beside those of the others.
        let bounds = self.fences.velocity_limits(&own_kinematics.position, &approach);
        let filtered = filter_in(own, own_kinematics, wanted, surroundings, &bounds, &settings, now);
        Ok(Steered {
            setpoint: filtered.setpoint,
            change: filtered.change,
        })
    }

    /// A place behind a fence that moves along, such as a slot of a formation that reaches over the boundary, becomes the velocity with
    /// which it would be flown to: the fences' bounds leave of it what leads along the boundary, so that the vehicle keeps up on the
    /// inside. `None` where the place may be flown to.
    ///
    /// # Errors
    /// Of a place that stands still behind a fence: nothing is gained by going nearer.
    fn along_the_fence(
        &self,
        own: VehicleId,
        own_kinematics: &VehicleKinematics,
        wanted: &Setpoint,
        settings: &AvoidanceSettings,
        now: NodeTime,
    ) -> Result<Option<Setpoint>, Refusal> {
        let Some(position) = &wanted.position else {
            return Ok(None);
        };
        let Err(refusal) = self.fences.may_move(&own_kinematics.position, position, true) else {
            return Ok(None);
        };
        let moves = wanted.velocity.is_some_and(|v| v.norm() > STANDS_M_S);
        // Without the filter nobody would keep the velocity inside.
        let velocity = as_velocity(own, own_kinematics, wanted, settings, now).filter(|_| moves);
        velocity.map(Some).ok_or(refusal)
    }
}

#[cfg(test)]
mod tests;
