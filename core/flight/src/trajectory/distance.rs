//! How near trajectories come to each other: a proven lower bound.

use super::polynomial::{Polynomial, axes, squared};
use super::sampling::check;
use nalgebra::Vector3;
use skein_domain::{NodeTime, Trajectory};

/// The bound is at most this much below the true distance, in metres.
const TOLERANCE_M: f64 = 1e-3;

/// What rounding may hide, in metres: taken off every bound.
const ROUNDING_M: f64 = 1e-4;

/// A stretch of time with one polynomial per axis; standing before the start and after the end.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    begin_s: f64,
    end_s: f64,
    axes: [Polynomial; 3],
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Stretch {
    fn new(begin_s: f64, end_s: f64, axes: [Polynomial; 3]) -> Self {
        let ranges = axes.map(|axis| axis.bernstein().enclosure());
        Self {
            begin_s,
            end_s,
            axes,
            low: Vector3::from(ranges.map(|(low, _)| low)),
            high: Vector3::from(ranges.map(|(_, high)| high)),
        }
    }

    /// Its axes over a part of its time.
    fn over(&self, begin_s: f64, end_s: f64) -> [Polynomial; 3] {
        if begin_s <= self.begin_s && end_s >= self.end_s {
            return self.axes;
        }
        let whole_s = self.end_s - self.begin_s;
        let (begin, length) = ((begin_s - self.begin_s) / whole_s, (end_s - begin_s) / whole_s);
        self.axes.map(|axis| axis.part(begin, length))
    }

    /// The squared distance of the boxes that hold both.
    fn boxes_apart2(&self, other: &Self) -> f64 {
        let gap = |i: usize| (self.low[i] - other.high[i]).max(other.low[i] - self.high[i]).max(0.0);
        gap(0).powi(2) + gap(1).powi(2) + gap(2).powi(2)
    }
}

/// A trajectory as stretches from `from_s` to `to_s`; empty if it is malformed.
fn stretches(trajectory: &Trajectory, zero: NodeTime, to_s: f64) -> Vec<Stretch> {
    if check(trajectory).is_err() {
        return Vec::new();
    }
    let mut all = Vec::with_capacity(trajectory.pieces.len() + 2);
    let mut at_s = trajectory.start.seconds_since(zero);
    let standing = |axes: [Polynomial; 3], at_end: bool| {
        axes.map(|axis| {
            let sum = axis.all().iter().sum();
            Polynomial::new(&[if at_end {
                sum
            } else {
                axis.all().first().copied().unwrap_or(0.0)
            }])
        })
    };
    if let Some(first) = trajectory.pieces.first().filter(|_| at_s > 0.0) {
        all.push(Stretch::new(0.0, at_s, standing(axes(first), false)));
    }
    for piece in &trajectory.pieces {
        all.push(Stretch::new(at_s, at_s + piece.duration_s, axes(piece)));
        at_s += piece.duration_s;
    }
    if let Some(last) = trajectory.pieces.last().filter(|_| at_s < to_s) {
        all.push(Stretch::new(at_s, to_s, standing(axes(last), true)));
    }
    all
}

/// The smaller of `known2` and a lower bound of the squared distance of two.
fn lower_bound2(a: &[Stretch], b: &[Stretch], known2: f64) -> f64 {
    let mut bound2 = known2;
    let (mut of_a, mut of_b) = (a.iter().peekable(), b.iter().peekable());
    while let (Some(one), Some(other)) = (of_a.peek(), of_b.peek()) {
        let (begin_s, end_s) = (one.begin_s.max(other.begin_s), one.end_s.min(other.end_s));
        if one.boxes_apart2(other) < bound2 && end_s > begin_s {
            bound2 = bound2.min(over_stretch2(one, other, (begin_s, end_s), bound2));
        }
        let (one_ends_s, other_ends_s) = (one.end_s, other.end_s);
        if one_ends_s <= other_ends_s {
            of_a.next();
        }
        if other_ends_s <= one_ends_s {
            of_b.next();
        }
    }
    bound2
}

fn over_stretch2(one: &Stretch, other: &Stretch, (begin_s, end_s): (f64, f64), known2: f64) -> f64 {
    let [north, east, down] = one.over(begin_s, end_s);
    let [other_north, other_east, other_down] = other.over(begin_s, end_s);
    let apart = [
        north.minus(&other_north),
        east.minus(&other_east),
        down.minus(&other_down),
    ];
    let tolerance = |reached: f64| TOLERANCE_M * (2.0 * (-reached).max(0.0).sqrt()).max(TOLERANCE_M);
    // The smallest square is the largest of the negated.
    -squared(&apart).negated().at_most_above(-known2, tolerance)
}

/// A lower bound of the distance of two trajectories over all time, at most a millimetre (or a thousandth where rounding counts) below
/// the true one; zero for one that is malformed, so that it is refused. Before its start and after its end a vehicle stands.
#[must_use]
pub fn min_distance_m(a: &Trajectory, b: &Trajectory) -> f64 {
    let (distance_m, _) = nearest(&[a.clone(), b.clone()]);
    distance_m
}

/// The lower bound over all pairs, and which pair it is of.
pub(super) fn nearest(trajectories: &[Trajectory]) -> (f64, Option<(usize, usize)>) {
    let zero = trajectories.iter().map(|t| t.start).min().unwrap_or_default();
    let to_s = trajectories
        .iter()
        .map(|t| t.start.seconds_since(zero) + super::duration_s(t))
        .fold(0.0, f64::max);
    let all: Vec<Vec<Stretch>> = trajectories.iter().map(|t| stretches(t, zero, to_s)).collect();
    let (mut bound2, mut pair) = (f64::INFINITY, None);
    for (j, one) in all.iter().enumerate() {
        for (i, other) in all.iter().enumerate().take(j) {
            if one.is_empty() || other.is_empty() {
                return (0.0, Some((i, j)));
            }
            let found2 = lower_bound2(one, other, bound2);
            if found2 < bound2 {
                (bound2, pair) = (found2, Some((i, j)));
            }
        }
    }
    ((bound2.max(0.0).sqrt() - ROUNDING_M).max(0.0), pair)
}
