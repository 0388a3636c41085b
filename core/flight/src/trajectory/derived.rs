//! Trajectories made of others: what is left of one at a time, one that stands, one with its heights scaled.
//!
//! Must never do: change where a trajectory leads, but for the scaling that was asked for.

use super::duration_s;
use super::sampling::{end, piece_at};
use nalgebra::Vector3;
use skein_domain::{NodeTime, PositionNed, Trajectory, TrajectoryPiece};

/// How long the single piece of a standing trajectory is, in seconds. It stands before and after it as well.
const STANDING_S: f64 = 1.0;

/// What is left of a trajectory from a time on: the same way at the same times. Before its start it is the trajectory itself, after its
/// end one that stands there.
#[must_use]
pub fn rest(trajectory: &Trajectory, from: NodeTime) -> Trajectory {
    let mut gone_s = from.seconds_since(trajectory.start);
    if gone_s <= 0.0 {
        return trajectory.clone();
    }
    if gone_s >= duration_s(trajectory) {
        return standing(end(trajectory), from);
    }
    let mut pieces = Vec::with_capacity(trajectory.pieces.len());
    for piece in &trajectory.pieces {
        if gone_s >= piece.duration_s {
            gone_s -= piece.duration_s;
            continue;
        }
        pieces.push(TrajectoryPiece {
            duration_s: piece.duration_s - gone_s,
            north: shifted(&piece.north, gone_s),
            east: shifted(&piece.east, gone_s),
            down: shifted(&piece.down, gone_s),
        });
        gone_s = 0.0;
    }
    Trajectory {
        start: from,
        pieces,
        yaw_rad: trajectory.yaw_rad,
    }
}

/// A trajectory that stands at a place.
#[must_use]
pub fn standing(place: PositionNed, start: NodeTime) -> Trajectory {
    Trajectory {
        start,
        pieces: vec![TrajectoryPiece {
            duration_s: STANDING_S,
            north: vec![place.north_m],
            east: vec![place.east_m],
            down: vec![place.down_m],
        }],
        yaw_rad: None,
    }
}

/// The same with all heights times `factor`: distances in it count heights by that much.
#[must_use]
pub fn with_heights_scaled(trajectory: &Trajectory, factor: f64) -> Trajectory {
    let scaled = |piece: &TrajectoryPiece| TrajectoryPiece {
        down: piece.down.iter().map(|c| c * factor).collect(),
        ..piece.clone()
    };
    Trajectory {
        pieces: trajectory.pieces.iter().map(scaled).collect(),
        ..trajectory.clone()
    }
}

/// How long its way is in metres, from places `step_s` apart on each piece: a lower bound, and near the true length where that is
/// short against the pieces.
#[must_use]
pub fn length_m(trajectory: &Trajectory, step_s: f64) -> f64 {
    let mut length_m = 0.0;
    for piece in &trajectory.pieces {
        // Written so that what is not a number counts as one step.
        let steps = (piece.duration_s / step_s.max(1e-3)).ceil().clamp(1.0, 1e5) as u32;
        let at = |step: u32| piece_at(piece, piece.duration_s * f64::from(step) / f64::from(steps))[0];
        let mut before: Vector3<f64> = at(0);
        for step in 1..=steps {
            let here = at(step);
            length_m += (here - before).norm();
            before = here;
        }
    }
    length_m
}

/// The coefficients of the same polynomial about `t_s`: a Taylor shift by synthetic division.
fn shifted(coefficients: &[f64], t_s: f64) -> Vec<f64> {
    let mut shifted = coefficients.to_vec();
    for lowest in 0..shifted.len().saturating_sub(1) {
        for power in (lowest..shifted.len() - 1).rev() {
            let above = shifted.get(power + 1).copied().unwrap_or(0.0);
            if let Some(here) = shifted.get_mut(power) {
                *here += t_s * above;
            }
        }
    }
    shifted
}

#[cfg(test)]
mod tests;
