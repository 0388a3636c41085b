//! Smooth trajectories through waypoints, within what the vehicles can do, flown together on the common clock.
//!
//! Must never do: hand out a trajectory whose limits or distances were only sampled. Peaks and distances are proven bounds.

mod derived;
mod distance;
mod peaks;
mod polynomial;
mod sampling;
mod spline;
mod timing;
mod upload;

use skein_domain::{AccelerationNed, FlightLimits, NodeTime, PositionNed, Trajectory, VelocityNed};
use thiserror::Error;

pub use derived::{length_m, rest, standing, with_heights_scaled};
pub use distance::min_distance_m;
pub use peaks::{Peaks, peaks};
pub use sampling::{TrajectorySample, check, duration_s, end, sample};
pub use upload::{SpeedWaypoint, to_waypoints};

/// What is made as small as possible over a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Smoothness {
    /// The integral of the squared jerk: polynomials of the fifth degree, continuous up to the fourth derivative.
    #[default]
    Jerk,
    /// The integral of the squared snap: polynomials of the seventh degree, continuous up to the sixth derivative. Rounder, and jerk is
    /// continuous from rest: for payloads and large airframes.
    Snap,
}

/// How a vehicle moves where its trajectory begins.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionState {
    /// Position.
    pub position: PositionNed,
    /// Velocity.
    pub velocity: VelocityNed,
    /// Acceleration.
    pub acceleration: AccelerationNed,
}

impl MotionState {
    /// At rest.
    #[must_use]
    pub fn at_rest(position: PositionNed) -> Self {
        Self {
            position,
            ..Self::default()
        }
    }
}

/// One vehicle's way among those planned together.
#[derive(Debug, Clone, PartialEq)]
pub struct Journey {
    /// How it moves at the common start.
    pub start: MotionState,
    /// The places it passes; at rest at the last.
    pub waypoints: Vec<PositionNed>,
    /// What it can do.
    pub limits: FlightLimits,
}

/// Trajectories that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct TogetherPlan {
    /// One per journey, in their order, all with the same start.
    pub trajectories: Vec<Trajectory>,
    /// When the k-th waypoint is passed by all who have one, in seconds after the start.
    pub passes_s: Vec<f64>,
    /// No two of them are ever nearer than this, in metres: a proven lower bound, a millimetre below the true value at most where that
    /// is small. Infinite for one alone. The caller refuses what is too near.
    pub min_distance_m: f64,
    /// Which two (places in the list) come that near.
    pub nearest: Option<(usize, usize)>,
}

impl TogetherPlan {
    /// How long it takes in seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.passes_s.last().copied().unwrap_or(0.0)
    }
}

/// Why there is no trajectory.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TrajectoryError {
    /// A vehicle has no waypoint.
    #[error("vehicle {index} in the list has no waypoint")]
    NoWaypoints {
        /// Its place in the list.
        index: usize,
    },
    /// A number of the start is not finite.
    #[error("the start of vehicle {index} in the list is not finite")]
    StartNotFinite {
        /// Its place in the list.
        index: usize,
    },
    /// A waypoint is not finite, or farther than can be counted with.
    #[error("waypoint {waypoint} of vehicle {index} in the list is not finite or too far away")]
    WaypointNotUsable {
        /// The vehicle's place in the list.
        index: usize,
        /// The waypoint's.
        waypoint: usize,
    },
    /// A limit cannot be planned with.
    #[error("the limits of vehicle {index} in the list cannot be planned with")]
    InvalidLimits {
        /// Its place in the list.
        index: usize,
    },
    /// From the motion it starts with, no way was found on which it stays within its limits.
    #[error("vehicle {index} in the list moves so that no way within its limits begins there")]
    StartBeyondLimits {
        /// Its place in the list.
        index: usize,
    },
    /// It would take longer than any battery lasts.
    #[error("the way takes more than {limit_s} s")]
    TooLong {
        /// The longest there is, in seconds.
        limit_s: f64,
    },
    /// A given trajectory is not usable.
    #[error("piece {piece} of the trajectory {why}")]
    Malformed {
        /// Which piece.
        piece: usize,
        /// What is wrong with it.
        why: &'static str,
    },
}

/// One vehicle's trajectory from `start_state` through `waypoints`, at rest at the last.
///
/// # Errors
/// [`TrajectoryError`] for numbers that are not usable, or a start from which the limits cannot be kept.
pub fn plan(
    start_state: MotionState,
    waypoints: &[PositionNed],
    limits: &FlightLimits,
    start: NodeTime,
    smoothness: Smoothness,
) -> Result<Trajectory, TrajectoryError> {
    let journey = Journey {
        start: start_state,
        waypoints: waypoints.to_vec(),
        limits: *limits,
    };
    let planned = timing::together(std::slice::from_ref(&journey), smoothness)?;
    let pieces = planned.pieces.into_iter().next().unwrap_or_default();
    Ok(Trajectory {
        start,
        pieces,
        yaw_rad: None,
    })
}

/// Trajectories for several vehicles that begin at one time and pass their k-th waypoints at one time: as slow as the slowest needs.
///
/// Who has fewer waypoints than others ends at its last one, at rest. A vehicle that starts in flight goes on from its velocity and
/// acceleration; one whose way would swing out far for it brakes first.
///
/// # Errors
/// As [`plan`].
pub fn plan_together(
    journeys: &[Journey],
    start: NodeTime,
    smoothness: Smoothness,
) -> Result<TogetherPlan, TrajectoryError> {
    let planned = timing::together(journeys, smoothness)?;
    let trajectories: Vec<Trajectory> = planned
        .pieces
        .into_iter()
        .map(|pieces| Trajectory {
            start,
            pieces,
            yaw_rad: None,
        })
        .collect();
    let (min_distance_m, nearest) = distance::nearest(&trajectories);
    Ok(TogetherPlan {
        trajectories,
        passes_s: planned.passes_s,
        min_distance_m,
        nearest,
    })
}

#[cfg(test)]
mod tests;
