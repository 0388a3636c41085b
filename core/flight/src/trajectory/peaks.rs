//! The largest speed, climb, descent and acceleration over a trajectory, as proven upper bounds.

use super::polynomial::{Polynomial, axes, squared};
use super::sampling::check;
use super::{MotionState, TrajectoryError};
use skein_domain::{FlightLimits, Trajectory, TrajectoryPiece};

/// Bounds are this much above the true peak at most, as a share of it.
const TOLERANCE: f64 = 2e-3;

/// Upper bounds over a whole trajectory: the true peaks are at most 0.2 % below them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Peaks {
    /// Horizontal speed in metres per second.
    pub speed_m_s: f64,
    /// Climb rate in metres per second; zero if it never climbs.
    pub climb_m_s: f64,
    /// Descent rate in metres per second; zero if it never descends.
    pub descent_m_s: f64,
    /// Acceleration in metres per second squared.
    pub acceleration_m_s2: f64,
}

impl Peaks {
    /// The larger of each.
    fn with(&self, other: &Self) -> Self {
        Self {
            speed_m_s: self.speed_m_s.max(other.speed_m_s),
            climb_m_s: self.climb_m_s.max(other.climb_m_s),
            descent_m_s: self.descent_m_s.max(other.descent_m_s),
            acceleration_m_s2: self.acceleration_m_s2.max(other.acceleration_m_s2),
        }
    }

    /// Those of a motion at one moment.
    pub(super) fn of_state(state: &MotionState) -> Self {
        let velocity = state.velocity.vector();
        Self {
            speed_m_s: velocity.xy().norm(),
            climb_m_s: (-velocity.z).max(0.0),
            descent_m_s: velocity.z.max(0.0),
            acceleration_m_s2: state.acceleration.norm(),
        }
    }

    /// How many times too fast it is for the limits, in time: at twice the duration it is half as fast and has a quarter of the
    /// acceleration. What is within `allowed` counts as within the limits.
    pub(super) fn haste(&self, limits: &FlightLimits, allowed: &Self) -> f64 {
        let share = |value: f64, limit: f64, allowed: f64| value / limit.max(allowed);
        let rates = [
            share(self.speed_m_s, limits.max_speed_m_s, allowed.speed_m_s),
            share(self.climb_m_s, limits.max_climb_m_s, allowed.climb_m_s),
            share(self.descent_m_s, limits.max_descent_m_s, allowed.descent_m_s),
            share(
                self.acceleration_m_s2,
                limits.max_acceleration_m_s2,
                allowed.acceleration_m_s2,
            )
            .sqrt(),
        ];
        rates.into_iter().fold(
            0.0,
            |most, rate| if rate.is_nan() { f64::INFINITY } else { most.max(rate) },
        )
    }
}

/// The peaks of a trajectory.
///
/// # Errors
/// [`TrajectoryError::Malformed`] for pieces that cannot be worked with.
pub fn peaks(trajectory: &Trajectory) -> Result<Peaks, TrajectoryError> {
    check(trajectory)?;
    Ok(trajectory
        .pieces
        .iter()
        .map(of_piece)
        .fold(Peaks::default(), |most, piece| most.with(&piece)))
}

/// The peaks of one piece.
pub(super) fn of_piece(piece: &TrajectoryPiece) -> Peaks {
    let by_time = 1.0 / piece.duration_s;
    let [north, east, down] = axes(piece).map(|axis| scaled(&axis.derivative(), by_time));
    let accelerations = [north, east, down].map(|axis| scaled(&axis.derivative(), by_time));
    let vertical = down.bernstein();
    Peaks {
        speed_m_s: root_of_bound(&squared(&[north, east])),
        climb_m_s: bound(&vertical.negated()).max(0.0),
        descent_m_s: bound(&vertical).max(0.0),
        acceleration_m_s2: root_of_bound(&squared(&accelerations)),
    }
}

fn scaled(polynomial: &Polynomial, by: f64) -> Polynomial {
    let coefficients: Vec<f64> = polynomial.all().iter().map(|c| c * by).collect();
    Polynomial::new(&coefficients)
}

/// An upper bound, with a tolerance that fits the size of the values.
fn bound(polynomial: &Polynomial) -> f64 {
    let largest = polynomial.all().iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    polynomial.at_most_by(|reached| TOLERANCE * reached.max(1e-6 * largest))
}

fn root_of_bound(squares: &Polynomial) -> f64 {
    bound(squares).max(0.0).sqrt()
}
