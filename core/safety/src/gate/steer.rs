//! What becomes of a setpoint in flight: refused if it makes no sense or asks for a place behind a fence, else changed as little as keeps
//! the vehicle off others and inside of the fences.

use super::{Gate, invalid};
use crate::avoidance::{AvoidanceSettings, Change, Surroundings, filter_in};
use crate::fence::Approach;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, Refusal, Setpoint, VehicleId};

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
        if let Some(position) = &wanted.position {
            self.fences.may_move(&own_kinematics.position, position, airborne)?;
        }
        let settings = self.avoidance();
        let approach = Approach {
            max_speed_m_s: settings.max_speed_m_s,
            braking_m_s2: settings.braking_m_s2,
            reaction_s: settings.reaction_s,
        };
        // The fences' conditions on the velocity, beside those of the others.
        let bounds = self.fences.velocity_limits(&own_kinematics.position, &approach);
        let filtered = filter_in(own, own_kinematics, wanted, surroundings, &bounds, &settings, now);
        Ok(Steered {
            setpoint: filtered.setpoint,
            change: filtered.change,
        })
    }
}

#[cfg(test)]
mod tests;
