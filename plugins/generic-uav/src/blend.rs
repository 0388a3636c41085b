//! What makes every change of plan smooth: the difference between where the vehicle is (or was last sent) and where the new plan begins
//! fades out over some seconds, in place and in velocity.
//!
//! Must never do: end with a jump. The difference and its rate are those given at the start and zero at the end.

use crate::settings::Settings;
use minicbor::{Decode, Encode};
use nalgebra::Vector3;
use skein_domain::{AccelerationNed, PositionNed, VelocityNed};

/// A difference in place below this is none, in metres.
const NO_OFFSET_M: f64 = 0.005;
/// A difference in velocity below this is none, in metres per second.
const NO_VELOCITY_M_S: f64 = 0.01;
/// No blend is shorter, in seconds.
const SHORTEST_S: f64 = 0.5;
/// Of the speed that the plan leaves a vehicle this share is used to catch up with it: the plan may be faster later.
const SPARE_SHARE: f64 = 0.4;

/// What is left of a blend is hastened if it is longer than this, in seconds, and can go so many times as fast.
const WORTH_HASTENING_S: f64 = 10.0;
const HASTENED_FROM: f64 = 1.5;

/// Place and motion at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Motion {
    pub position: PositionNed,
    pub velocity: VelocityNed,
    pub acceleration: AccelerationNed,
}

impl Motion {
    pub(crate) fn new(position: PositionNed, velocity: VelocityNed, acceleration: AccelerationNed) -> Self {
        Self {
            position,
            velocity,
            acceleration,
        }
    }
}

/// A difference that fades out.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Blend {
    /// Difference in place at the start, in metres.
    #[n(0)]
    offset: PositionNed,
    /// Difference in velocity at the start.
    #[n(1)]
    velocity: VelocityNed,
    #[n(2)]
    duration_s: f64,
    #[n(3)]
    elapsed_s: f64,
}

impl Blend {
    /// From the motion the vehicle has to that of a plan; `None` if they hardly differ.
    pub(crate) fn between(have: &Motion, plan: &Motion, settings: &Settings) -> Option<Self> {
        let offset = have.position.vector() - plan.position.vector();
        let velocity = have.velocity.vector() - plan.velocity.vector();
        let (offset_m, velocity_m_s) = (offset.norm(), velocity.norm());
        // Also for what is not finite: then there is nothing to blend from.
        if !(offset_m + velocity_m_s).is_finite() || (offset_m < NO_OFFSET_M && velocity_m_s < NO_VELOCITY_M_S) {
            return None;
        }
        let acceleration = settings.acceleration_m_s2;
        // A difference in velocity fades so that, on top of a plan that starts from rest in the same direction, the sum is never
        // faster than both ends: that needs between one and three times the time of plain braking.
        let for_velocity_s = 3.0 * velocity_m_s / acceleration;
        let for_offset_s = (1.5 * offset_m / catch_up_m_s(plan, settings)).max((6.0 * offset_m / acceleration).sqrt());
        let duration_s = for_velocity_s.max(for_offset_s).max(SHORTEST_S);
        Some(Self {
            offset: offset.into(),
            velocity: velocity.into(),
            duration_s,
            elapsed_s: 0.0,
        })
    }

    /// The same, or a quicker one from the motion it has come to, where the plan has become so much slower that a long one would waste what speed
    /// there is.
    pub(crate) fn hastened(self, plan: &Motion, settings: &Settings) -> Self {
        let left_s = self.duration_s - self.elapsed_s;
        let began_with_m_s = 1.5 * self.offset.vector().norm() / self.duration_s;
        if left_s < WORTH_HASTENING_S || catch_up_m_s(plan, settings) < HASTENED_FROM * began_with_m_s {
            return self;
        }
        Self::between(&self.apply(plan), plan, settings)
            .filter(|quicker| quicker.duration_s < left_s)
            .unwrap_or(self)
    }

    /// The same, beginning so many seconds later.
    pub(crate) fn beginning_in(self, wait_s: f64) -> Self {
        Self {
            elapsed_s: self.elapsed_s - wait_s,
            ..self
        }
    }

    /// Moves on by `dt_s`; whether anything of the difference is left.
    pub(crate) fn advance(&mut self, dt_s: f64) -> bool {
        self.elapsed_s += dt_s;
        self.elapsed_s < self.duration_s
    }

    /// The plan's motion with what is left of the difference.
    pub(crate) fn apply(&self, plan: &Motion) -> Motion {
        let t = self.duration_s;
        let s = (self.elapsed_s / t).clamp(0.0, 1.0);
        let (offset, velocity) = (self.offset.vector(), self.velocity.vector() * t);
        let sum = |of_offset: f64, of_velocity: f64| -> Vector3<f64> { offset * of_offset + velocity * of_velocity };
        let position = sum(1.0 + s * s * (2.0 * s - 3.0), s * (1.0 + s * (s - 2.0)));
        let rate = sum(6.0 * s * (s - 1.0), 1.0 + s * (3.0 * s - 4.0)) / t;
        let change = sum(12.0 * s - 6.0, 6.0 * s - 4.0) / (t * t);
        Motion {
            position: plan.position.moved(position),
            velocity: (plan.velocity.vector() + rate).into(),
            acceleration: (plan.acceleration.vector() + change).into(),
        }
    }
}

/// How fast a vehicle comes after a plan, beside the plan's own speed.
fn catch_up_m_s(plan: &Motion, settings: &Settings) -> f64 {
    let spare_m_s = SPARE_SHARE * (settings.max_speed_m_s - plan.velocity.vector().norm());
    settings.catch_up_m_s.max(spare_m_s)
}

/// Braking along a straight line to a stop, then standing there.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Stop {
    #[n(0)]
    pub from: PositionNed,
    #[n(1)]
    pub velocity: VelocityNed,
}

impl Stop {
    /// Standing at a place.
    pub(crate) fn at(place: PositionNed) -> Self {
        Self {
            from: place,
            velocity: VelocityNed::default(),
        }
    }

    /// How long it takes to stand, in seconds.
    pub(crate) fn duration_s(&self, acceleration_m_s2: f64) -> f64 {
        self.velocity.norm() / acceleration_m_s2
    }

    /// The motion after `t_s` seconds.
    pub(crate) fn sample(&self, t_s: f64, acceleration_m_s2: f64) -> Motion {
        let (velocity, duration_s) = (self.velocity.vector(), self.duration_s(acceleration_m_s2));
        let t = t_s.clamp(0.0, duration_s);
        if duration_s <= 0.0 {
            return Motion {
                position: self.from,
                ..Motion::default()
            };
        }
        let left = 1.0 - t / duration_s;
        let braking = if t < duration_s {
            velocity / -duration_s
        } else {
            Vector3::zeros()
        };
        Motion {
            position: self.from.moved(velocity * (t * (1.0 - 0.5 * t / duration_s))),
            velocity: (velocity * left).into(),
            acceleration: braking.into(),
        }
    }
}

#[cfg(test)]
mod tests;
