//! A trajectory as a list of waypoints with speeds, for an autopilot that holds a mission itself.

use super::TrajectoryError;
use super::polynomial::{MAX_DEGREE, Polynomial, axes};
use super::sampling::check;
use nalgebra::Vector3;
use skein_domain::{PositionNed, Trajectory};

/// A piece is cut into at most 2 to this power legs.
const DEEPEST: u8 = 10;

/// A place to fly to straight, and how fast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedWaypoint {
    /// The place.
    pub position: PositionNed,
    /// Mean speed on the way to it, in metres per second.
    pub speed_m_s: f64,
    /// When it is passed, in seconds after the start.
    pub passed_s: f64,
}

/// The trajectory as straight legs no farther than `tolerance_m` from it, from its start (which is not in the list) to its end. Every
/// joint of two pieces is in it. The times are kept on the mean: an autopilot that follows the legs is early or late within one.
///
/// # Errors
/// [`TrajectoryError::Malformed`] for pieces that cannot be worked with.
pub fn to_waypoints(trajectory: &Trajectory, tolerance_m: f64) -> Result<Vec<SpeedWaypoint>, TrajectoryError> {
    check(trajectory)?;
    let tolerance_m = if tolerance_m.is_finite() {
        tolerance_m.max(1e-3)
    } else {
        1e-3
    };
    let mut list = Vec::new();
    let mut begin_s = 0.0;
    for piece in &trajectory.pieces {
        // One degree for all axes, so that their control points go together.
        let whole = axes(piece).map(|axis| axis.of_degree(MAX_DEGREE).bernstein());
        let mut open = vec![(whole, 0.0, 1.0, 0_u8)];
        while let Some((part, from, to, depth)) = open.pop() {
            let controls = controls(&part);
            let (Some(begin), Some(end)) = (controls.first(), controls.last()) else {
                continue;
            };
            if depth >= DEEPEST || controls.iter().all(|c| off_leg_m(c, begin, end) <= tolerance_m) {
                let duration_s = (to - from) * piece.duration_s;
                list.push(SpeedWaypoint {
                    position: (*end).into(),
                    speed_m_s: (end - begin).norm() / duration_s,
                    passed_s: begin_s + to * piece.duration_s,
                });
            } else {
                let middle = 0.5 * (from + to);
                let [north, east, down] = part.map(|axis| axis.halves());
                // The first half comes off first.
                open.push(([north.1, east.1, down.1], middle, to, depth + 1));
                open.push(([north.0, east.0, down.0], from, middle, depth + 1));
            }
        }
        begin_s += piece.duration_s;
    }
    Ok(list)
}

/// The control points of a part whose axes are in Bernstein form and of one degree.
fn controls([north, east, down]: &[Polynomial; 3]) -> Vec<Vector3<f64>> {
    north
        .all()
        .iter()
        .zip(east.all())
        .zip(down.all())
        .map(|((north, east), down)| Vector3::new(*north, *east, *down))
        .collect()
}

/// Distance of a point to the leg from `begin` to `end`.
fn off_leg_m(point: &Vector3<f64>, begin: &Vector3<f64>, end: &Vector3<f64>) -> f64 {
    let leg = end - begin;
    let length2 = leg.norm_squared();
    let share = if length2 > 0.0 {
        ((point - begin).dot(&leg) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (point - begin - leg * share).norm()
}
