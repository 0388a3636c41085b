//! An anchor that follows something whose position is told now and then: over the API, MAVLink or ROS 2, one to ten times a second,
//! late, unevenly and with noise. What the formation sees of it moves smoothly and within limits.
//!
//! Must never do: depend on when it was asked before. Where the anchor is follows from what was told and when, and from the time.

use crate::heading::HeadingFollower;
use nalgebra::Vector3;
use skein_domain::{AnchorReference, FormationHeading, NodeTime, PositionNed, VelocityNed};
use std::collections::VecDeque;
use thiserror::Error;

/// The anchor is worked out in steps of this length in seconds, counted from the first thing told.
const STEP_S: f64 = 0.02;
/// How quickly a small difference fades: the natural frequency of the critically damped tracker, in radians per second.
const FREQUENCY_RAD_S: f64 = 1.5;
/// Velocity is estimated from what was told in this time, in seconds, where it is not told itself.
const WINDOW_S: f64 = 1.5;
/// So many tellings are remembered at most.
const MOST_TOLD: usize = 32;
/// Tellings that span less time than this, in seconds, say nothing about velocity.
const LEAST_SPAN_S: f64 = 0.15;
/// A reference slower than this has no course, in metres per second.
const COURSE_FROM_M_S: f64 = 0.5;
/// The anchor stands still when it is slower than this after it was braked, in metres per second.
const STANDS_M_S: f64 = 1e-6;

/// What the anchor may do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceLimits {
    /// Largest speed in metres per second.
    pub speed_m_s: f64,
    /// Largest acceleration in metres per second squared.
    pub acceleration_m_s2: f64,
    /// Largest rate at which its heading turns, in radians per second.
    pub turn_rate_rad_s: f64,
    /// Without anything told for so long, in seconds, it brakes to a stop.
    pub stale_after_s: f64,
}

/// Why something told about a reference was not taken, or limits cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ReferenceError {
    /// A limit is not usable.
    #[error("{limit} = {value}: it must be a finite number above zero")]
    InvalidLimit {
        /// Which one.
        limit: &'static str,
        /// What was given.
        value: f64,
    },
    /// A number is not finite.
    #[error("its position, velocity or heading is not finite")]
    NotFinite,
    /// It is not newer than what is known.
    #[error("it is {behind_s:.3} s older than what is known")]
    OutOfOrder {
        /// How much older, in seconds.
        behind_s: f64,
    },
}

/// One thing told.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ReferenceReport {
    position: Vector3<f64>,
    velocity: Option<Vector3<f64>>,
    heading_rad: Option<f64>,
    time: NodeTime,
}

/// Where the reference is taken to be from one moment on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Aim {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    course_rad: f64,
    time: NodeTime,
}

/// The anchor at one step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct State {
    step: u64,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    heading: HeadingFollower,
}

/// Smooths a reference that is told now and then.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceTracker {
    limits: ReferenceLimits,
    told: VecDeque<ReferenceReport>,
    /// When the steps begin, what is aimed at, and the anchor at the step of the last thing told.
    tracked: Option<(NodeTime, Aim, State)>,
}

impl ReferenceTracker {
    /// One that has been told nothing yet.
    ///
    /// # Errors
    /// [`ReferenceError::InvalidLimit`].
    pub fn new(limits: ReferenceLimits) -> Result<Self, ReferenceError> {
        for (limit, value) in [
            ("speed_m_s", limits.speed_m_s),
            ("acceleration_m_s2", limits.acceleration_m_s2),
            ("turn_rate_rad_s", limits.turn_rate_rad_s),
            ("stale_after_s", limits.stale_after_s),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(ReferenceError::InvalidLimit { limit, value });
            }
        }
        Ok(Self {
            limits,
            told: VecDeque::new(),
            tracked: None,
        })
    }

    /// Takes what is told: where the reference was at `time`, and its velocity and heading if they are known.
    ///
    /// The anchor begins where it is first told to be. Told velocities are taken as they are, else the velocity is that of the
    /// straight line through what was told lately (least squares), which also takes most of the noise out of the position.
    ///
    /// # Errors
    /// [`ReferenceError`] for numbers that are not finite, and for what is not newer than the last.
    pub fn update(
        &mut self,
        position: PositionNed,
        velocity: Option<VelocityNed>,
        heading_rad: Option<f64>,
        time: NodeTime,
    ) -> Result<(), ReferenceError> {
        let finite =
            position.is_finite() && velocity.is_none_or(|v| v.is_finite()) && heading_rad.is_none_or(f64::is_finite);
        if !finite {
            return Err(ReferenceError::NotFinite);
        }
        if let Some(last) = self.told.back().filter(|last| time <= last.time) {
            return Err(ReferenceError::OutOfOrder {
                behind_s: last.time.seconds_since(time),
            });
        }
        // After a silence what was told before says nothing about how it moves now.
        let recent = |told: &ReferenceReport| time.seconds_since(told.time) <= WINDOW_S;
        self.told.retain(recent);
        if self.told.len() == MOST_TOLD {
            self.told.pop_front();
        }
        self.told.push_back(ReferenceReport {
            position: position.vector(),
            velocity: velocity.map(|v| v.vector()),
            heading_rad,
            time,
        });
        self.tracked = Some(match self.tracked {
            None => self.begin(position, velocity, heading_rad, time),
            Some((epoch, aim, state)) => {
                let state = self.advanced(state, &aim, epoch, time);
                (epoch, self.aim(aim.course_rad, time), state)
            }
        });
        Ok(())
    }

    /// The anchor at `now`, and whether nothing has been told for too long: then it brakes, or has come to rest. None if nothing
    /// has ever been told. A time before the last thing told counts as that.
    #[must_use]
    pub fn anchor(&self, now: NodeTime) -> Option<(AnchorReference, bool)> {
        let (epoch, aim, state) = self.tracked.as_ref()?;
        let now = now.max(aim.time);
        let state = self.advanced(*state, aim, *epoch, now);
        // Between two steps along the last one's acceleration.
        let dt = (now.seconds_since(*epoch) - state.step as f64 * STEP_S).clamp(0.0, STEP_S);
        let rate = state.heading.rate_rad_s();
        let anchor = AnchorReference {
            position: (state.position + state.velocity * dt + state.acceleration * (0.5 * dt * dt)).into(),
            velocity: (state.velocity + state.acceleration * dt).into(),
            acceleration: state.acceleration.into(),
            heading_rad: skein_domain::frames::wrap_angle_rad(state.heading.heading_rad() + rate * dt),
            heading_rate_rad_s: rate,
            heading_acceleration_rad_s2: state.heading.acceleration_rad_s2(),
            time: now,
        };
        Some((anchor, self.is_stale(aim, now)))
    }

    fn is_stale(&self, aim: &Aim, now: NodeTime) -> bool {
        now.seconds_since(aim.time) > self.limits.stale_after_s
    }

    fn begin(
        &self,
        position: PositionNed,
        velocity: Option<VelocityNed>,
        heading_rad: Option<f64>,
        time: NodeTime,
    ) -> (NodeTime, Aim, State) {
        let velocity = velocity.map_or_else(Vector3::zeros, |v| v.vector());
        let heading_rad = heading_rad.or_else(|| course(&velocity)).unwrap_or(0.0);
        let mode = FormationHeading::Course {
            max_rate_rad_s: self.limits.turn_rate_rad_s,
        };
        let state = State {
            step: 0,
            position: position.vector(),
            velocity: velocity.cap_magnitude(self.limits.speed_m_s),
            acceleration: Vector3::zeros(),
            heading: HeadingFollower::new(mode, heading_rad),
        };
        (time, self.aim(heading_rad, time), state)
    }

    /// What is aimed at after the last thing told.
    fn aim(&self, held_course_rad: f64, time: NodeTime) -> Aim {
        let Some(last) = self.told.back() else {
            return Aim {
                position: Vector3::zeros(),
                velocity: Vector3::zeros(),
                course_rad: held_course_rad,
                time,
            };
        };
        let (position, velocity) = match last.velocity {
            Some(velocity) => (last.position, velocity),
            None => self.fitted(last),
        };
        Aim {
            position,
            velocity,
            course_rad: last
                .heading_rad
                .or_else(|| course(&velocity))
                .unwrap_or(held_course_rad),
            time,
        }
    }

    /// The straight line through what was told lately, at its end.
    fn fitted(&self, last: &ReferenceReport) -> (Vector3<f64>, Vector3<f64>) {
        let count = self.told.len() as f64;
        let age_s = |told: &ReferenceReport| told.time.seconds_since(last.time);
        let mean_s = self.told.iter().map(age_s).sum::<f64>() / count;
        // Relative to the last one, so that large coordinates cost no digits.
        let mean = self
            .told
            .iter()
            .map(|told| told.position - last.position)
            .sum::<Vector3<f64>>()
            / count;
        let spread = self.told.iter().map(|told| (age_s(told) - mean_s).powi(2)).sum::<f64>();
        let span_s = self.told.front().map_or(0.0, |first| -age_s(first));
        if span_s < LEAST_SPAN_S {
            return (last.position, Vector3::zeros());
        }
        let weighted = |told: &ReferenceReport| (told.position - last.position - mean) * (age_s(told) - mean_s);
        let velocity = self.told.iter().map(weighted).sum::<Vector3<f64>>() / spread;
        (last.position + mean - velocity * mean_s, velocity)
    }

    /// The anchor at the last step that is not after `now`.
    fn advanced(&self, mut state: State, aim: &Aim, epoch: NodeTime, now: NodeTime) -> State {
        let until = (now.seconds_since(epoch) / STEP_S + 1e-6).floor().max(0.0) as u64;
        while state.step < until {
            let time = epoch.plus_seconds(state.step as f64 * STEP_S);
            let stale = self.is_stale(aim, time);
            if stale && state.velocity.norm() < STANDS_M_S && state.heading.rate_rad_s().abs() < STANDS_M_S {
                // It stands and goes on standing: no need to count the steps of a long silence.
                (state.velocity, state.acceleration) = (Vector3::zeros(), Vector3::zeros());
                let heading = &state.heading;
                state.heading = HeadingFollower::resume(heading.mode(), heading.heading_rad(), heading.rate_rad_s());
                state.step = until;
                return state;
            }
            self.step(&mut state, aim, time, stale);
        }
        state
    }

    fn step(&self, state: &mut State, aim: &Aim, time: NodeTime, stale: bool) {
        let limit = self.limits.acceleration_m_s2;
        let wanted = if stale {
            Vector3::zeros()
        } else {
            let ahead_s = time.seconds_since(aim.time).max(0.0);
            let away = aim.position + aim.velocity * ahead_s - state.position;
            // Near by, a = ω² e + 2 ω ė; from afar no faster than can still be braked from.
            let distance_m = away.norm();
            let closing = (0.5 * FREQUENCY_RAD_S * distance_m).min((BRAKING_SHARE * limit * distance_m).sqrt());
            let towards = away.try_normalize(f64::MIN_POSITIVE).unwrap_or_default();
            (aim.velocity + towards * closing).cap_magnitude(self.limits.speed_m_s)
        };
        let rate = if stale { 1.0 / STEP_S } else { 2.0 * FREQUENCY_RAD_S };
        state.acceleration = ((wanted - state.velocity) * rate).cap_magnitude(limit);
        state.position += state.velocity * STEP_S + state.acceleration * (0.5 * STEP_S * STEP_S);
        state.velocity += state.acceleration * STEP_S;
        let course_rad = if stale { f64::NAN } else { aim.course_rad };
        state.heading.step(course_rad, STEP_S);
        state.step += 1;
    }
}

/// Twice the share of the acceleration that a braking from afar is planned with: the rest makes up for the lag.
const BRAKING_SHARE: f64 = 1.0;

/// The course of something fast enough to have one.
fn course(velocity: &Vector3<f64>) -> Option<f64> {
    (velocity.x.hypot(velocity.y) >= COURSE_FROM_M_S).then(|| velocity.y.atan2(velocity.x))
}

#[cfg(test)]
mod tests;
