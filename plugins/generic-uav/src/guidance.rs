//! Flying beside something that moves, for a model that is built on this one: it says where to be, this model flies there smoothly.
//!
//! Must never do: move the reference faster than the limits, or towards a goal whose numbers are not finite.

use crate::blend::Motion;
use crate::flight::{Goal, Phase, Plan, Purpose};
use crate::model::GenericUav;
use crate::settings::Settings;
use nalgebra::Vector3;
use skein_domain::exchange::OwnState;
use skein_domain::{CommandId, FlightState, NodeTime, PositionNed, Refusal, VehicleCommand, VehicleId};
use skein_plugin_sdk::Effects;

/// How fast a small distance is closed, per second: a metre off gives a metre per second.
const CLOSING_RATE_HZ: f64 = 1.0;
/// How fast the velocity follows the wanted one, in seconds. A quarter of the closing time: then neither overshoots.
const VELOCITY_TIME_S: f64 = 0.25;
/// Share of the acceleration that braking towards the goal is planned with; the rest is for a goal that moves.
const BRAKING_SHARE: f64 = 0.7;

/// The speed with which a distance is closed: proportional when near, and such that a constant braking ends at the goal when far.
fn closing_m_s(distance_m: f64, acceleration_m_s2: f64) -> f64 {
    let braking = acceleration_m_s2 * BRAKING_SHARE;
    let near_m = braking / (CLOSING_RATE_HZ * CLOSING_RATE_HZ);
    if distance_m <= near_m {
        CLOSING_RATE_HZ * distance_m
    } else {
        (2.0 * braking * (distance_m - near_m / 2.0)).sqrt()
    }
}

/// One step of the reference towards a goal. Without one it brakes.
pub(crate) fn step(have: &Motion, goal: Option<&Goal>, now: NodeTime, dt_s: f64, settings: &Settings) -> Motion {
    let acceleration_m_s2 = settings.acceleration_m_s2;
    let wanted = goal.filter(|goal| goal.is_usable()).map_or(Vector3::zeros(), |goal| {
        let off = goal.at(now).vector() - have.position.vector();
        let across = Vector3::new(off.x, off.y, 0.0);
        let closing = across.try_normalize(1e-9).map_or(Vector3::zeros(), |towards| {
            towards * closing_m_s(across.norm(), acceleration_m_s2)
        });
        let moving = goal.velocity.vector();
        let horizontal = Vector3::new(moving.x, moving.y, 0.0) + closing;
        let vertical = moving.z + off.z.signum() * closing_m_s(off.z.abs(), acceleration_m_s2);
        let horizontal = horizontal.cap_magnitude(goal.speed_m_s.min(settings.max_speed_m_s));
        Vector3::new(
            horizontal.x,
            horizontal.y,
            vertical.clamp(-settings.climb_m_s, settings.descent_m_s),
        )
    });
    towards(have, wanted, dt_s, acceleration_m_s2)
}

/// One step of the reference towards a velocity.
pub(crate) fn towards(have: &Motion, wanted: Vector3<f64>, dt_s: f64, acceleration_m_s2: f64) -> Motion {
    let velocity = have.velocity.vector();
    let change = ((wanted - velocity) / VELOCITY_TIME_S).cap_magnitude(acceleration_m_s2);
    Motion {
        position: have.position.moved(velocity * dt_s + change * (dt_s * dt_s / 2.0)),
        velocity: (velocity + change * dt_s).into(),
        acceleration: change.into(),
    }
}

/// What a model that is built on this one uses of it, beside handing events through.
impl GenericUav {
    /// From now on takes [`VehicleCommand::Observe`]: it flies where [`Self::guide`] says. Without this it refuses the command.
    #[must_use]
    pub fn with_guidance(mut self) -> Self {
        self.takes_guidance = true;
        self
    }

    /// The command of the guided flight being flown, if there is one. Any other flight ends it.
    #[must_use]
    pub fn guided(&self) -> Option<(CommandId, VehicleCommand)> {
        match &self.flight.phase {
            Phase::Flying(flying) => match &flying.purpose {
                Purpose::Guided(guided) => Some((guided.id, guided.command)),
                _ => None,
            },
            _ => None,
        }
    }

    /// Where to be from now on in a guided flight; `None` to brake and stand.
    pub fn guide(&mut self, to: Option<Goal>) {
        if let Phase::Flying(flying) = &mut self.flight.phase
            && let Purpose::Guided(guided) = &mut flying.purpose
        {
            guided.goal = to;
        }
    }

    /// What the command of a guided flight asked for is the case. The flight goes on.
    pub fn guided_command_done(&mut self, out: &mut Effects) {
        if let Some((id, _)) = self.guided()
            && self.flight.command.is_some_and(|command| command.id == id)
        {
            self.command_done(out);
        }
    }

    /// Ends a guided flight from within: holds, or flies home and lands. A command that was not done is refused.
    pub fn break_off_guided(&mut self, refusal: Refusal, home: bool, detail: &str, out: &mut Effects) {
        if self.guided().is_none() {
            return;
        }
        self.command_refused(refusal, out);
        let launch = self.own.and_then(|own| own.home).filter(PositionNed::is_finite);
        match (home, launch) {
            (true, Some(home)) => self.fly(Purpose::Home { home }, None, detail, out),
            (true, None) => self.begin_landing(true, detail, out),
            (false, _) => self.fly(Purpose::Hold { at: None }, None, detail, out),
        }
    }

    /// Turns the vehicle's nose, where its flight leaves that open; whether it does.
    pub fn look_along(&mut self, towards_rad: f64) -> bool {
        if let Phase::Flying(flying) = &mut self.flight.phase
            && !matches!(
                flying.purpose,
                Purpose::Lead(_) | Purpose::Follow(_) | Purpose::Steer(_)
            )
            && towards_rad.is_finite()
        {
            flying.yaw_rad = Some(towards_rad);
            return true;
        }
        false
    }

    /// The yaw last asked for in a flight by setpoints.
    #[must_use]
    pub fn asked_yaw_rad(&self) -> Option<f64> {
        match &self.flight.phase {
            Phase::Flying(flying) => flying.yaw_rad,
            _ => None,
        }
    }

    /// Where the reference of a guided flight is: free of noise, unlike [`Self::position`].
    #[must_use]
    pub fn guided_reference(&self) -> Option<PositionNed> {
        match &self.flight.phase {
            Phase::Flying(flying) => match flying.plan {
                Plan::Guided { position, .. } => Some(position),
                _ => None,
            },
            _ => None,
        }
    }

    /// The vehicle it flies.
    #[must_use]
    pub fn vehicle(&self) -> VehicleId {
        self.vehicle
    }

    /// The flight state.
    #[must_use]
    pub fn state(&self) -> FlightState {
        self.flight.phase.state()
    }

    /// The vehicle's own state as last seen.
    #[must_use]
    pub fn own_state(&self) -> Option<&OwnState> {
        self.own.as_ref()
    }

    /// Where the vehicle is, carried on to this moment.
    #[must_use]
    pub fn position(&self) -> Option<PositionNed> {
        self.measured().map(|motion| motion.position)
    }

    /// Moves the reference of a guided flight on by a period.
    pub(crate) fn step_guided(&self, plan: &mut Plan, purpose: &Purpose, dt_s: f64) {
        if let (
            Plan::Guided {
                position,
                velocity,
                acceleration,
            },
            Purpose::Guided(guided),
        ) = (plan, purpose)
        {
            let have = Motion::new(*position, *velocity, *acceleration);
            let next = step(&have, guided.goal.as_ref(), self.now, dt_s, &self.settings);
            (*position, *velocity, *acceleration) = (next.position, next.velocity, next.acceleration);
        }
    }
}

#[cfg(test)]
mod tests;
