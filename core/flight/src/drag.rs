//! How strongly the air slows a multirotor down, learnt in flight from its own attitude and velocity, so that its setpoints can carry what
//! the autopilot would otherwise only find out by lagging behind.
//!
//! The thrust points along the vehicle's own axis and carries its weight, so that the attitude tells its level part. Less the acceleration,
//! that is what pulls against the air: `pull = drag (velocity - wind)`, averaged over spans of some tenths of a second. The slope of pull over
//! velocity is the drag; the intercept, which is the wind's, is learnt along and left to the autopilot.
//!
//! Must never do: learn on the ground or from numbers that are not finite, or give a drag that is not within its bounds.

use minicbor::{Decode, Encode};
use nalgebra::{Vector2, Vector3};
use skein_domain::setpoint::DRAG_MAX_PER_S;
use skein_domain::{NodeTime, VelocityNed};

/// What is taken until more is known, in 1/s: that of a usual quadrotor.
pub const DRAG_AT_FIRST_PER_S: f64 = 0.25;
/// How much is to be seen until that counts no more than what is learnt: seconds times the square of metres per second.
const AT_FIRST_WEIGHT_M2_PER_S: f64 = 2.0;
/// Older spans count less and less over this time, in seconds: wind, payload and battery change.
const MEMORY_S: f64 = 30.0;
/// What was learnt is kept while nothing new is to be learnt: no more is forgotten than leaves so much, seconds times the square of metres
/// per second.
const KEPT_M2_PER_S: f64 = 60.0;
/// A velocity nearer to the mean one than this tells only of the wind, in metres per second: gusts move the vehicle as well as they pull.
const TELLING_M_S: f64 = 0.5;
/// How long a span is at least, in seconds: long against the time between two looks, short against a turn.
const SPAN_S: f64 = 0.2;
/// After a longer gap between two looks a new span begins, in seconds.
const LONGEST_GAP_S: f64 = 0.4;
/// Tilted farther than this it does something else than flying about, in radians.
const TILT_MAX_RAD: f64 = 0.7;
/// What accelerates more than this was touched or tumbles, in metres per second squared.
const ACCELERATION_MAX_M_S2: f64 = 8.0;
/// Standard gravity in metres per second squared.
const GRAVITY_M_S2: f64 = 9.806_65;

/// What a vehicle tells of itself at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub struct Look {
    /// When the velocity was measured.
    #[n(0)]
    pub time: NodeTime,
    /// Velocity over the ground.
    #[n(1)]
    pub velocity: VelocityNed,
    /// Roll in radians.
    #[n(2)]
    pub roll_rad: f64,
    /// Pitch in radians.
    #[n(3)]
    pub pitch_rad: f64,
    /// Yaw in radians, clockwise from north.
    #[n(4)]
    pub yaw_rad: f64,
}

impl Look {
    /// The level part of the thrust over its vertical part, towards north and east. The thrust is opposite to the body's down axis.
    fn lean(&self) -> Vector2<f64> {
        let (sin, cos) = self.yaw_rad.sin_cos();
        let (forward, right) = (-self.pitch_rad.tan(), self.roll_rad.tan() / self.pitch_rad.cos());
        Vector2::new(forward * cos - right * sin, forward * sin + right * cos)
    }

    fn is_usable(&self) -> bool {
        let level = self.roll_rad.cos() * self.pitch_rad.cos();
        // Also refuses what is not finite.
        self.velocity.is_finite() && self.yaw_rad.is_finite() && level >= TILT_MAX_RAD.cos()
    }
}

/// The span that is being looked at: sums over it.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
struct Span {
    #[n(0)]
    began: Look,
    #[n(1)]
    last: Look,
    /// Lean times time, in seconds.
    #[n(2)]
    lean_s: [f64; 2],
    /// The way, in metres.
    #[n(3)]
    way_m: [f64; 2],
}

impl Span {
    fn begin(look: Look) -> Self {
        Self {
            began: look,
            last: look,
            lean_s: [0.0; 2],
            way_m: [0.0; 2],
        }
    }

    fn add(&mut self, look: Look, dt_s: f64) {
        let half_s = 0.5 * dt_s;
        let level = |velocity: &VelocityNed| Vector2::new(velocity.north_m_s, velocity.east_m_s);
        let lean = Vector2::from(self.lean_s) + (self.last.lean() + look.lean()) * half_s;
        let way = Vector2::from(self.way_m) + (level(&self.last.velocity) + level(&look.velocity)) * half_s;
        (self.lean_s, self.way_m, self.last) = (lean.into(), way.into(), look);
    }

    fn duration_s(&self) -> f64 {
        self.last.time.seconds_since(self.began.time)
    }

    /// Mean velocity and mean pull against the air over the span; none if something else went on.
    fn pull(&self) -> Option<(Vector2<f64>, Vector2<f64>)> {
        let time_s = self.duration_s();
        let acceleration: Vector3<f64> = (self.last.velocity.vector() - self.began.velocity.vector()) / time_s;
        if acceleration.norm() > ACCELERATION_MAX_M_S2 {
            return None;
        }
        let lean = Vector2::from(self.lean_s) / time_s;
        let pull = lean * (GRAVITY_M_S2 - acceleration.z) - acceleration.xy();
        Some((Vector2::from(self.way_m) / time_s, pull))
    }
}

/// Learns the drag of one vehicle. Plain data, to be saved with the state of whoever flies it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Encode, Decode)]
pub struct DragEstimator {
    #[n(0)]
    span: Option<Span>,
    /// For how long the means are known, what is older counting less, in seconds.
    #[n(1)]
    known_s: f64,
    #[n(2)]
    mean_velocity_m_s: [f64; 2],
    #[n(3)]
    mean_pull_m_s2: [f64; 2],
    /// About the means: velocity by velocity, and velocity by pull.
    #[n(4)]
    spread_m2_per_s: f64,
    #[n(5)]
    together_m2_per_s2: f64,
}

impl DragEstimator {
    /// The drag as far as it is known, in 1/s, from zero to [`DRAG_MAX_PER_S`].
    #[must_use]
    pub fn drag_per_s(&self) -> f64 {
        let slope = (self.together_m2_per_s2 + AT_FIRST_WEIGHT_M2_PER_S * DRAG_AT_FIRST_PER_S)
            / (self.spread_m2_per_s.max(0.0) + AT_FIRST_WEIGHT_M2_PER_S);
        if slope.is_finite() {
            slope.clamp(0.0, DRAG_MAX_PER_S)
        } else {
            DRAG_AT_FIRST_PER_S
        }
    }

    /// What is told of the vehicle now. The same told again, or only half of it anew, is passed over.
    pub fn see(&mut self, look: Look) {
        if !look.is_usable() {
            return self.interrupt();
        }
        let Some(span) = &mut self.span else {
            self.span = Some(Span::begin(look));
            return;
        };
        let dt_s = look.time.seconds_since(span.last.time);
        if !(0.0..=LONGEST_GAP_S).contains(&dt_s) {
            *span = Span::begin(look);
            return;
        }
        let turned = (look.roll_rad, look.pitch_rad) != (span.last.roll_rad, span.last.pitch_rad);
        if dt_s <= 0.0 || !turned {
            return;
        }
        span.add(look, dt_s);
        if span.duration_s() >= SPAN_S {
            let (seen, time_s) = (span.pull(), span.duration_s());
            *span = Span::begin(look);
            if let Some((velocity, pull)) = seen {
                self.learn(velocity, pull, time_s);
            }
        }
    }

    /// It does not fly, or is not heard: what comes next does not belong to what was before.
    pub fn interrupt(&mut self) {
        self.span = None;
    }

    fn learn(&mut self, velocity: Vector2<f64>, pull: Vector2<f64>, time_s: f64) {
        let kept = (-time_s / MEMORY_S).exp();
        let known_s = self.known_s * kept + time_s;
        let share = time_s / known_s;
        let (mean_velocity, mean_pull) = (
            Vector2::from(self.mean_velocity_m_s),
            Vector2::from(self.mean_pull_m_s2),
        );
        let (off, pull_off) = (velocity - mean_velocity, pull - mean_pull);
        let mut next = Self {
            known_s,
            mean_velocity_m_s: (mean_velocity + off * share).into(),
            mean_pull_m_s2: (mean_pull + pull_off * share).into(),
            ..*self
        };
        if off.norm() >= TELLING_M_S {
            let weight_s = time_s * (1.0 - share);
            next.spread_m2_per_s += weight_s * off.norm_squared();
            next.together_m2_per_s2 += weight_s * off.dot(&pull_off);
        }
        let left_m2_per_s = (next.spread_m2_per_s * kept).max(next.spread_m2_per_s.min(KEPT_M2_PER_S));
        if next.spread_m2_per_s > 0.0 {
            next.together_m2_per_s2 *= left_m2_per_s / next.spread_m2_per_s;
            next.spread_m2_per_s = left_m2_per_s;
        }
        let finite = next.mean_velocity_m_s.iter().chain(&next.mean_pull_m_s2);
        let sound = finite
            .chain([&next.known_s, &next.spread_m2_per_s, &next.together_m2_per_s2])
            .all(|x| x.is_finite());
        *self = if sound && next.spread_m2_per_s >= 0.0 {
            next
        } else {
            Self::default()
        };
    }
}

#[cfg(test)]
mod tests;
