//! What sensors say.

use crate::ClassScores;
use nalgebra::{Matrix3, Vector3};
use skein_domain::{NodeTime, VehicleId};
use std::fmt;

/// Names a sensor: a camera of a vehicle, or what tells over the API.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Sensor(pub String);

/// Something that was seen once.
#[derive(Debug, Clone, PartialEq)]
pub enum Observation {
    /// In which direction it is.
    Bearing {
        /// Where the sensor was, in the swarm frame, in metres.
        origin: Vector3<f64>,
        /// Standard deviation of that along each axis, in metres.
        origin_error_m: f64,
        /// A unit vector along north, east, down.
        direction: Vector3<f64>,
        /// Standard deviation of the direction, in radians.
        error_rad: f64,
    },
    /// Where it is.
    Position {
        /// In the swarm frame, in metres.
        position: Vector3<f64>,
        /// In square metres.
        covariance: Matrix3<f64>,
    },
}

/// How far something may be, from how large it looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeGuess {
    /// The likeliest range, in metres.
    pub range_m: f64,
    /// It may be farther or nearer by this factor: one standard deviation.
    pub range_factor: f64,
}

impl RangeGuess {
    /// Standard deviation of the range in metres.
    pub(super) fn error_m(&self) -> f64 {
        self.range_m * (self.range_factor - 1.0).clamp(0.05, 3.0)
    }
}

/// An observation of a sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// Whose.
    pub sensor: Sensor,
    /// What the sensor calls the thing, if it follows it.
    pub name: Option<u64>,
    /// When it was seen.
    pub time: NodeTime,
    /// What was seen.
    pub observation: Observation,
    /// What the sensor takes it for.
    pub scores: ClassScores,
    /// A guess of its range.
    pub guess: Option<RangeGuess>,
    /// How large it looks: its longer side in radians, if the sensor says.
    pub size_rad: Option<f64>,
}

/// A vehicle of the swarm, which is no track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnVehicle {
    /// Which.
    pub id: VehicleId,
    /// When it was there.
    pub time: NodeTime,
    /// Where, in the swarm frame, in metres.
    pub position: Vector3<f64>,
    /// In metres per second.
    pub velocity: Vector3<f64>,
    /// Standard deviation of the position, and half of its size, in metres.
    pub error_m: f64,
}

impl OwnVehicle {
    /// Where it is at a moment if it goes on as it did.
    pub(super) fn at(&self, time: NodeTime) -> Vector3<f64> {
        self.position + self.velocity * time.seconds_since(self.time)
    }
}

/// Why a sighting cannot be true.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unsound {
    /// A number is none, or outside of anything that is flown.
    Number,
    /// The direction has no length.
    Direction,
    /// The covariance is none: not symmetric, or not positive definite.
    Covariance,
}

impl fmt::Display for Unsound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Number => "a number is not finite, or too large",
            Self::Direction => "the direction is no unit vector",
            Self::Covariance => "the covariance is not symmetric and positive definite",
        })
    }
}

impl std::error::Error for Unsound {}

/// Farther from the origin than this nothing is believed, in metres.
const FARTHEST_M: f64 = 1e5;

impl Sighting {
    /// Whether it can be true.
    ///
    /// # Errors
    ///
    /// What cannot be.
    pub fn check(&self) -> Result<(), Unsound> {
        if self.guess.is_some_and(|guess| {
            !(0.1..FARTHEST_M).contains(&guess.range_m) || !(1.0..100.0).contains(&guess.range_factor)
        }) {
            return Err(Unsound::Number);
        }
        if self.size_rad.is_some_and(|size_rad| !(1e-6..3.2).contains(&size_rad)) {
            return Err(Unsound::Number);
        }
        let place = |at: &Vector3<f64>| at.iter().all(|part| part.abs() <= FARTHEST_M);
        match &self.observation {
            Observation::Bearing {
                origin,
                origin_error_m,
                direction,
                error_rad,
            } => {
                if !place(origin) || !(0.0..1e4).contains(origin_error_m) || !(1e-6..1.5).contains(error_rad) {
                    return Err(Unsound::Number);
                }
                if (direction.norm() - 1.0).abs() < 1e-6 {
                    Ok(())
                } else {
                    Err(Unsound::Direction)
                }
            }
            Observation::Position { position, covariance } => {
                if !place(position) || !covariance.iter().all(|part| part.abs() < FARTHEST_M * FARTHEST_M) {
                    return Err(Unsound::Number);
                }
                let skew = (covariance - covariance.transpose()).amax();
                let symmetric = skew <= 1e-6 * covariance.amax();
                let eigenvalues = covariance.symmetric_eigenvalues();
                let positive = eigenvalues
                    .iter()
                    .all(|value| *value > 1e-9 * eigenvalues.amax().max(1e-3));
                if symmetric && positive {
                    Ok(())
                } else {
                    Err(Unsound::Covariance)
                }
            }
        }
    }
}
