//! A trajectory at one moment.

use super::TrajectoryError;
use super::polynomial::MAX_DEGREE;
use nalgebra::Vector3;
use skein_domain::{AccelerationNed, NodeTime, PositionNed, Trajectory, TrajectoryPiece, VelocityNed};

/// Below this speed a course is not told, in metres per second.
const NO_COURSE_M_S: f64 = 0.2;
/// Pieces meet within this, in metres and metres per second.
const JOINT_TOLERANCE: f64 = 0.01;
/// No trajectory is longer, in seconds.
pub(super) const LONGEST_S: f64 = 86_400.0;

/// Where a trajectory wants its vehicle at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrajectorySample {
    /// Position.
    pub position: PositionNed,
    /// Velocity.
    pub velocity: VelocityNed,
    /// Acceleration.
    pub acceleration: AccelerationNed,
    /// Jerk along north, east and down in metres per second cubed.
    pub jerk_m_s3: Vector3<f64>,
    /// Yaw in radians clockwise from north: the trajectory's own, or its course; none while it has no course.
    pub yaw_rad: Option<f64>,
    /// The rate of it in radians per second.
    pub yaw_rate_rad_s: f64,
    /// It has begun.
    pub begun: bool,
    /// Its end is reached.
    pub finished: bool,
}

/// Value, velocity, acceleration and jerk of one axis.
fn axis_at(coefficients: &[f64], t_s: f64) -> [f64; 4] {
    // Horner with the derivatives over their factorials carried along.
    let mut parts = [0.0_f64; 4];
    for c in coefficients.iter().rev() {
        parts[3] = parts[3] * t_s + parts[2];
        parts[2] = parts[2] * t_s + parts[1];
        parts[1] = parts[1] * t_s + parts[0];
        parts[0] = parts[0] * t_s + c;
    }
    [parts[0], parts[1], 2.0 * parts[2], 6.0 * parts[3]]
}

/// Position, velocity, acceleration and jerk of one piece.
pub(super) fn piece_at(piece: &TrajectoryPiece, t_s: f64) -> [Vector3<f64>; 4] {
    let [north, east, down] = [&piece.north, &piece.east, &piece.down].map(|axis| axis_at(axis, t_s));
    [0, 1, 2, 3].map(|k: usize| {
        let part = |axis: &[f64; 4]| axis.get(k).copied().unwrap_or(0.0);
        Vector3::new(part(&north), part(&east), part(&down))
    })
}

/// How long it takes in seconds.
#[must_use]
pub fn duration_s(trajectory: &Trajectory) -> f64 {
    trajectory.pieces.iter().map(|piece| piece.duration_s).sum()
}

/// Where it ends; the origin if it has no piece.
#[must_use]
pub fn end(trajectory: &Trajectory) -> PositionNed {
    trajectory.pieces.last().map_or_else(PositionNed::default, |piece| {
        piece_at(piece, piece.duration_s)[0].into()
    })
}

/// Where the vehicle should be at `now`. Before the start: at rest where it begins, after the end: at rest there. Numbers that are not
/// finite are handed on, so that the gate refuses them.
#[must_use]
pub fn sample(trajectory: &Trajectory, now: NodeTime) -> TrajectorySample {
    at(trajectory, now.seconds_since(trajectory.start))
}

/// The same by the seconds since its start.
pub(super) fn at(trajectory: &Trajectory, t_s: f64) -> TrajectorySample {
    let begun = t_s >= 0.0;
    if !begun {
        let place = trajectory
            .pieces
            .first()
            .map_or(Vector3::zeros(), |piece| piece_at(piece, 0.0)[0]);
        return standing(place, trajectory.yaw_rad, false, false);
    }
    let mut left_s = t_s;
    for piece in &trajectory.pieces {
        if left_s < piece.duration_s {
            return moving(piece_at(piece, left_s), trajectory.yaw_rad);
        }
        left_s -= piece.duration_s;
    }
    standing(end(trajectory).vector(), trajectory.yaw_rad, true, true)
}

fn standing(place: Vector3<f64>, yaw_rad: Option<f64>, begun: bool, finished: bool) -> TrajectorySample {
    TrajectorySample {
        position: place.into(),
        velocity: VelocityNed::default(),
        acceleration: AccelerationNed::default(),
        jerk_m_s3: Vector3::zeros(),
        yaw_rad,
        yaw_rate_rad_s: 0.0,
        begun,
        finished,
    }
}

fn moving([place, velocity, acceleration, jerk]: [Vector3<f64>; 4], yaw_rad: Option<f64>) -> TrajectorySample {
    let level2 = velocity.xy().norm_squared();
    let course = (level2 > NO_COURSE_M_S * NO_COURSE_M_S).then(|| {
        let turn = (velocity.x * acceleration.y - velocity.y * acceleration.x) / level2;
        (velocity.y.atan2(velocity.x), turn)
    });
    let (yaw_rad, yaw_rate_rad_s) = match (yaw_rad, course) {
        (Some(yaw), _) => (Some(yaw), 0.0),
        (None, Some((course, turn))) => (Some(course), turn),
        (None, None) => (None, 0.0),
    };
    TrajectorySample {
        position: place.into(),
        velocity: velocity.into(),
        acceleration: acceleration.into(),
        jerk_m_s3: jerk,
        yaw_rad,
        yaw_rate_rad_s,
        begun: true,
        finished: false,
    }
}

/// Whether a trajectory from elsewhere can be flown: numbers finite, durations above zero, degrees that are known, and pieces that meet
/// in place and velocity.
///
/// # Errors
/// [`TrajectoryError::Malformed`] says which piece and why.
pub fn check(trajectory: &Trajectory) -> Result<(), TrajectoryError> {
    let wrong = |piece: usize, why: &'static str| Err(TrajectoryError::Malformed { piece, why });
    if trajectory.pieces.is_empty() {
        return wrong(0, "is missing");
    }
    if trajectory.yaw_rad.is_some_and(|yaw| !yaw.is_finite()) {
        return wrong(0, "has a yaw that is not finite");
    }
    let mut before: Option<[Vector3<f64>; 4]> = None;
    for (i, piece) in trajectory.pieces.iter().enumerate() {
        if !(piece.duration_s > 0.0 && piece.duration_s <= LONGEST_S) {
            return wrong(i, "has a duration that is not usable");
        }
        let axes = [&piece.north, &piece.east, &piece.down];
        if axes.iter().any(|axis| axis.is_empty() || axis.len() > MAX_DEGREE + 1) {
            return wrong(i, "has too few or too many coefficients");
        }
        let begin = piece_at(piece, 0.0);
        let end = piece_at(piece, piece.duration_s);
        if axes.iter().any(|axis| axis.iter().any(|c| !c.is_finite())) || !end.iter().all(|v| v.norm().is_finite()) {
            return wrong(i, "has numbers that are not finite");
        }
        let off = before.map_or(0.0, |before| {
            (before[0] - begin[0]).norm().max((before[1] - begin[1]).norm())
        });
        if off > JOINT_TOLERANCE {
            return wrong(i, "does not begin where the one before ends");
        }
        before = Some(end);
    }
    if duration_s(trajectory) > LONGEST_S {
        return Err(TrajectoryError::TooLong { limit_s: LONGEST_S });
    }
    Ok(())
}
