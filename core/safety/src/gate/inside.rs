//! What the gate asks of the fences: where a setpoint leads a vehicle on the ground, and the way up at a take-off.

use super::Gate;
use nalgebra::Vector3;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{PositionNed, Refusal, Setpoint, VelocityNed};

/// Slowing down counts when it is looked where a velocity leads, but no more than this, in metres per second squared.
const MAX_BRAKING_M_S2: f64 = 3.0;

impl Gate {
    /// Whether a setpoint keeps a vehicle that stands inside: the asked place and where its velocity leads within the horizon. In the air
    /// the fences bound the velocity instead.
    pub(super) fn setpoint_on_the_ground(&self, own: &VehicleKinematics, setpoint: &Setpoint) -> Result<(), Refusal> {
        let (fences, here) = (&self.fences, &own.position);
        if let Some(position) = &setpoint.position {
            fences.may_move(here, position, false)?;
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
        fences.may_move(start, &end, false)
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

/// How strongly an acceleration brakes a velocity, as far as it is believed.
fn braking_m_s2(velocity: &VelocityNed, acceleration: &Vector3<f64>) -> f64 {
    let speed = velocity.norm();
    if speed > 0.0 {
        (-acceleration.dot(&velocity.vector()) / speed).clamp(0.0, MAX_BRAKING_M_S2)
    } else {
        0.0
    }
}

/// For how many seconds at the present speed the way within the horizon would last, when braking.
fn driven_share_s(speed_m_s: f64, braking_m_s2: f64, horizon_s: f64) -> f64 {
    if braking_m_s2 * horizon_s >= speed_m_s {
        // It stands before the horizon: v²/2b of way, over v. Without braking the speed is zero here.
        return if braking_m_s2 > 0.0 {
            0.5 * speed_m_s / braking_m_s2
        } else {
            0.0
        };
    }
    if speed_m_s > 0.0 {
        horizon_s - 0.5 * braking_m_s2 * horizon_s * horizon_s / speed_m_s
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests;
