//! The straight way to a place, from rest to rest.

use crate::route::{PathLimits, RouteError};
use crate::speed::{Phase, ramps};
use nalgebra::Vector3;
use skein_domain::{AccelerationNed, PositionNed, VelocityNed};

/// A straight flight with a trapezoid in speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GoTo {
    from: PositionNed,
    to: PositionNed,
    direction: Vector3<f64>,
    phases: [Phase; 3],
    duration_s: f64,
}

impl GoTo {
    /// From one place to another at `speed_m_s`, reached and left with `acceleration_m_s2`.
    ///
    /// # Errors
    /// [`RouteError`] if a number is not usable. Two equal places are fine: the flight is over at once.
    pub fn new(from: PositionNed, to: PositionNed, speed_m_s: f64, acceleration_m_s2: f64) -> Result<Self, RouteError> {
        Self::within(from, to, speed_m_s, &PathLimits::level(acceleration_m_s2))
    }

    /// The same with limits to climb and descent.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn within(from: PositionNed, to: PositionNed, speed_m_s: f64, limits: &PathLimits) -> Result<Self, RouteError> {
        limits.check(speed_m_s)?;
        if !from.is_finite() {
            return Err(RouteError::StartNotFinite);
        }
        let way = to.vector() - from.vector();
        let length_m = way.norm();
        if !length_m.is_finite() {
            return Err(RouteError::WaypointNotFinite { index: 0 });
        }
        let direction = if length_m > 0.0 {
            way / length_m
        } else {
            Vector3::zeros()
        };
        let cap = limits.speed_along(&direction, speed_m_s);
        let phases = ramps(length_m, 0.0, 0.0, cap, limits.acceleration_m_s2);
        let duration_s = phases.iter().map(|phase| phase.duration_s).sum();
        Ok(Self {
            from,
            to,
            direction,
            phases,
            duration_s,
        })
    }

    /// How long it takes in seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Where it ends.
    #[must_use]
    pub fn to(&self) -> PositionNed {
        self.to
    }

    /// Position, velocity, acceleration and whether the end is reached, `t_s` seconds after the start. Before it (and for a time
    /// that is not a number): at rest at the start.
    #[must_use]
    pub fn sample(&self, t_s: f64) -> (PositionNed, VelocityNed, AccelerationNed, bool) {
        let mut left_s = t_s.max(0.0);
        for phase in &self.phases {
            if left_s < phase.duration_s {
                let (distance_m, speed) = phase.at(left_s);
                return (
                    self.from.moved(self.direction * distance_m),
                    (self.direction * speed).into(),
                    (self.direction * phase.acceleration_m_s2).into(),
                    false,
                );
            }
            left_s -= phase.duration_s;
        }
        (self.to, VelocityNed::default(), AccelerationNed::default(), true)
    }
}

#[cfg(test)]
mod tests;
