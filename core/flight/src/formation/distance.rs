//! How close the slots of a formation are to each other.

use nalgebra::Vector3;
use skein_domain::OffsetFrd;

/// One vehicle above another needs this many times the spacing: the air that keeps the upper one up pushes the lower one down.
pub const VERTICAL_FACTOR: f64 = 1.5;

/// Smallest distance between any two offsets in metres. Infinite for fewer than two; zero if a number is not finite, so that no
/// check of it passes.
#[must_use]
pub fn smallest_distance_m(offsets: &[OffsetFrd]) -> f64 {
    let points: Vec<_> = offsets.iter().map(OffsetFrd::vector).collect();
    closest_pair(&points).map_or(f64::INFINITY, |pair| pair.distance_m)
}

/// The same with vertical distances divided by [`VERTICAL_FACTOR`]: what shapes that have heights of their own are laid out by.
#[must_use]
pub fn smallest_separation_m(offsets: &[OffsetFrd]) -> f64 {
    let points: Vec<_> = offsets.iter().map(|offset| flattened(offset.vector())).collect();
    closest_pair(&points).map_or(f64::INFINITY, |pair| pair.distance_m)
}

/// Heights count for less.
pub(super) fn flattened(point: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(point.x, point.y, point.z / VERTICAL_FACTOR)
}

/// Two points and how far apart they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pair {
    pub first: usize,
    pub second: usize,
    pub distance_m: f64,
}

/// The two points that are nearest to each other. Points that are not finite are at no distance from each other.
///
/// A sweep along the axis in which the points spread widest: only those within the best distance so far are compared.
pub(super) fn closest_pair(points: &[Vector3<f64>]) -> Option<Pair> {
    if points.len() < 2 {
        return None;
    }
    if let Some(first) = points.iter().position(|point| !point.iter().all(|x| x.is_finite())) {
        return Some(Pair {
            first,
            second: first,
            distance_m: 0.0,
        });
    }
    let spread = |axis: &usize| {
        let along = || points.iter().filter_map(|point| point.get(*axis));
        along().fold(f64::NEG_INFINITY, |a, b| a.max(*b)) - along().fold(f64::INFINITY, |a, b| a.min(*b))
    };
    let axis = (0..3).max_by(|a, b| spread(a).total_cmp(&spread(b))).unwrap_or(0);
    let mut sorted: Vec<(f64, usize, Vector3<f64>)> = points
        .iter()
        .enumerate()
        .map(|(i, point)| (point.get(axis).copied().unwrap_or(0.0), i, *point))
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut best: Option<Pair> = None;
    for (at, (along, i, point)) in sorted.iter().enumerate() {
        for (other_along, j, other) in sorted.iter().skip(at + 1) {
            if best.is_some_and(|pair| other_along - along >= pair.distance_m) {
                break;
            }
            let distance_m = (other - point).norm();
            if best.is_none_or(|pair| distance_m < pair.distance_m) {
                best = Some(Pair {
                    first: *i.min(j),
                    second: *i.max(j),
                    distance_m,
                });
            }
        }
    }
    best
}
