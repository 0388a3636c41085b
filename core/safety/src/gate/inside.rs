//! What the gate asks of the fences: where a setpoint leads, whether the vehicle can still stop, and the way up at a take-off.

use super::{Gate, MAX_BRAKING_M_S2, braking_m_s2, driven_share_s};
use crate::fence::Approach;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{PositionNed, Refusal, Setpoint};

/// From the refusal of a setpoint until the vehicle brakes: two control periods and the time it takes to tilt.
const REACTION_S: f64 = 0.1;

impl Gate {
    /// How vehicles are taken to stop in front of a fence.
    pub(super) fn approach(&self) -> Approach {
        Approach {
            max_speed_m_s: self.limits.max_speed_m_s.max(self.limits.max_climb_m_s),
            braking_m_s2: MAX_BRAKING_M_S2,
            reaction_s: REACTION_S,
            margin_m: 0.0,
        }
    }

    /// Whether a setpoint keeps a vehicle inside: the asked place and where its velocity leads within the horizon are inside, and so is
    /// the way there; and a vehicle that could not stop any more at its present velocity is asked for one that it can stop from.
    pub(super) fn setpoint_in_fences(
        &self,
        own: &VehicleKinematics,
        airborne: bool,
        setpoint: &Setpoint,
    ) -> Result<(), Refusal> {
        let (fences, here) = (&self.fences, &own.position);
        if let Some(position) = &setpoint.position {
            fences.may_move(here, position, airborne)?;
        }
        let base = setpoint.position.unwrap_or(*here);
        let Some(velocity) = &setpoint.velocity else {
            return Ok(());
        };
        let braking = setpoint
            .acceleration
            .map_or(0.0, |a| braking_m_s2(velocity, &a.vector()));
        let seconds = driven_share_s(velocity.norm(), braking, self.limits.separation_horizon_s);
        let end = base.moved(velocity.vector() * seconds);
        // Who is outside is measured by where it is, not by the place it was asked to come back to.
        let start = if fences.contains(here).is_ok() { &base } else { here };
        fences.may_move(start, &end, airborne)?;
        if airborne {
            self.can_stop(own, setpoint)?;
        }
        Ok(())
    }

    /// A vehicle that comes in too fast to stop may only be given a velocity from which it could: what follows a refusal is braking
    /// straight on, so that it must come before that is too late, however slantingly the boundary is approached.
    fn can_stop(&self, own: &VehicleKinematics, setpoint: &Setpoint) -> Result<(), Refusal> {
        let approach = self.approach();
        let Err(refusal) = self.fences.stops_inside(&own.position, &own.velocity, &approach) else {
            return Ok(());
        };
        // A setpoint that is ahead of the vehicle brakes for the place where it is itself: no reaction to be added.
        let at_once = Approach {
            reaction_s: 0.0,
            ..approach
        };
        let asked = setpoint.velocity.unwrap_or_default();
        let yields = self.fences.stops_inside(&own.position, &asked, &at_once).is_ok();
        if yields { Ok(()) } else { Err(refusal) }
    }

    /// Whether a take-off from the ground to a height over it is inside: the top, and the way up as far as exclusions go.
    pub(super) fn take_off_in_fences(&self, ground: &PositionNed, height_m: f64) -> Result<(), Refusal> {
        let top = PositionNed {
            down_m: ground.down_m - height_m,
            ..*ground
        };
        self.goal(&top)?;
        self.fences.crossed(ground, &top).map_or(Ok(()), |zone| {
            Err(Refusal::OutsideFence {
                detail: format!("the way up to {height_m:.1} m crosses \"{}\"", zone.name),
            })
        })
    }
}

#[cfg(test)]
mod tests;
