//! The smoothest piecewise polynomial through places at given times.
//!
//! The cost of a piece (the integral of the squared jerk or snap) is a quadratic form in the derivatives at its two ends (Richter, Bry &
//! Roy 2013), so the derivatives at the waypoints in between are the solution of a block-tridiagonal, positive definite system: one pass
//! forward and one back, in a time proportional to the number of pieces. That the pieces meet in place, velocity and acceleration (with
//! snap: also in jerk) follows from how they are built, not from how well the system was solved.

use super::Smoothness;
use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3};
use skein_domain::TrajectoryPiece;

/// Derivatives at the ends of one piece: place, velocity, acceleration, jerk at its begin, then the same at its end.
type Form = SMatrix<f64, 8, 8>;
/// Place, velocity, acceleration and jerk as rows; north, east and down as columns.
type Derivatives = SMatrix<f64, 4, 3>;
/// Velocity, acceleration and jerk as rows; north, east and down as columns.
type Free = Matrix3<f64>;

/// What to minimise, as matrices over a piece of one second.
pub(super) struct Basis {
    /// How many derivatives (with the place) are given at an end: three for jerk, four for snap.
    given: usize,
    /// From the derivatives at both ends to the coefficients.
    coefficients: Form,
    /// From the derivatives at both ends to the cost.
    cost: Form,
}

/// `i! / (i - k)!`
fn falling(i: usize, k: usize) -> f64 {
    (0..k).map(|step| i as f64 - step as f64).product()
}

impl Basis {
    /// For a smoothness; `None` never for those there are.
    pub fn new(smoothness: Smoothness) -> Option<Self> {
        let given = match smoothness {
            Smoothness::Jerk => 3,
            Smoothness::Snap => 4,
        };
        let used = |i: usize| i < given;
        // Lower coefficients: derivative k at the begin over k!. Upper ones so that the derivatives at the end are right.
        let upper = Matrix4::from_fn(|k, i| {
            if used(k) && used(i) {
                falling(given + i, k)
            } else {
                f64::from(u8::from(k == i))
            }
        })
        .try_inverse()?;
        let lower = Matrix4::from_fn(|i, k| if i == k && used(k) { 1.0 / falling(k, k) } else { 0.0 });
        let carried = Matrix4::from_fn(|k, i| if used(k) && used(i) { falling(i, k) } else { 0.0 });
        let unit = Matrix4::from_fn(|i, k| f64::from(u8::from(i == k && used(i))));
        let from_begin = -(upper * carried * lower);
        let from_end = upper * unit;
        let mut coefficients = Form::zeros();
        for row in 0..4 {
            for column in 0..4 {
                coefficients[(row, column)] += lower[(row, column)];
                if used(row) {
                    coefficients[(given + row, column)] += from_begin[(row, column)];
                    coefficients[(given + row, 4 + column)] += from_end[(row, column)];
                }
            }
        }
        // Integral of the squared derivative of the order `given` over one second.
        let integral = Form::from_fn(|i, j| {
            if i < given || j < given || i >= 2 * given || j >= 2 * given {
                return 0.0;
            }
            falling(i, given) * falling(j, given) / (i + j - 2 * given + 1) as f64
        });
        Some(Self {
            given,
            coefficients,
            cost: coefficients.transpose() * integral * coefficients,
        })
    }

    /// A piece's cost over `duration_s`, as a form in derivatives by seconds.
    fn cost_over(&self, duration_s: f64) -> Form {
        let power = |i: usize| duration_s.powi(i32::try_from(i % 4).unwrap_or(0));
        let shared = duration_s.powi(1 - 2 * i32::try_from(self.given).unwrap_or(0));
        Form::from_fn(|i, j| self.cost[(i, j)] * power(i) * power(j) * shared)
    }

    /// The piece over `duration_s` between two ends.
    fn piece(&self, begin: &Derivatives, end: &Derivatives, duration_s: f64) -> TrajectoryPiece {
        let scale = Vector3::new(duration_s, duration_s.powi(2), duration_s.powi(3));
        let axis = |column: usize| -> Vec<f64> {
            let ends = SMatrix::<f64, 8, 1>::from_fn(|row, _| {
                let end = if row < 4 { begin } else { end };
                match row % 4 {
                    0 => end[(0, column)],
                    k => end[(k, column)] * scale[k - 1],
                }
            });
            let over_share = self.coefficients * ends;
            over_share
                .iter()
                .take(2 * self.given)
                .enumerate()
                .map(|(power, c)| c / duration_s.powi(i32::try_from(power).unwrap_or(0)))
                .collect()
        };
        TrajectoryPiece {
            duration_s,
            north: axis(0),
            east: axis(1),
            down: axis(2),
        }
    }
}

/// Where a spline begins: place, velocity, acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Begin {
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub acceleration: Vector3<f64>,
}

/// The blocks of one waypoint's equations.
struct Row {
    before: Matrix3<f64>,
    own: Matrix3<f64>,
    after: Matrix3<f64>,
    right: Free,
}

/// The smoothest way from `begin` through `places` in `durations_s` (as many), at rest at the end. `None` if the system has no solution,
/// which finite places and durations above zero do not lead to.
pub(super) fn through(
    basis: &Basis,
    begin: &Begin,
    places: &[Vector3<f64>],
    durations_s: &[f64],
) -> Option<Vec<TrajectoryPiece>> {
    let zero = Vector3::zeros();
    let start = derivatives(&begin.position, &begin.velocity, &begin.acceleration);
    let all: Vec<Derivatives> = std::iter::once(start)
        .chain(places.iter().map(|place| derivatives(place, &zero, &zero)))
        .collect();
    let free = inner_derivatives(basis, &all, durations_s)?;
    let nodes: Vec<Derivatives> = all
        .iter()
        .enumerate()
        .map(|(i, node)| {
            let mut node = *node;
            if let Some(found) = i.checked_sub(1).and_then(|i| free.get(i)) {
                node.fixed_view_mut::<3, 3>(1, 0).copy_from(found);
            }
            node
        })
        .collect();
    let pieces = nodes
        .windows(2)
        .zip(durations_s)
        .filter_map(|(ends, duration_s)| match ends {
            [from, to] => {
                let place = from.row(0).transpose();
                let piece = basis.piece(
                    &placed(from, &zero),
                    &placed(to, &(to.row(0).transpose() - place)),
                    *duration_s,
                );
                Some(moved(piece, &place))
            }
            _ => None,
        });
    Some(pieces.collect())
}

/// The same derivatives at another place.
fn placed(node: &Derivatives, place: &Vector3<f64>) -> Derivatives {
    let mut node = *node;
    node.set_row(0, &place.transpose());
    node
}

fn moved(mut piece: TrajectoryPiece, by_m: &Vector3<f64>) -> TrajectoryPiece {
    for (axis, by_m) in [&mut piece.north, &mut piece.east, &mut piece.down]
        .into_iter()
        .zip(by_m)
    {
        if let Some(constant) = axis.first_mut() {
            *constant += by_m;
        }
    }
    piece
}

fn derivatives(place: &Vector3<f64>, velocity: &Vector3<f64>, acceleration: &Vector3<f64>) -> Derivatives {
    Derivatives::from_fn(|row, column| match row {
        0 => place[column],
        1 => velocity[column],
        2 => acceleration[column],
        _ => 0.0,
    })
}

/// Velocity, acceleration and jerk at all waypoints but the first and the last.
fn inner_derivatives(basis: &Basis, nodes: &[Derivatives], durations_s: &[f64]) -> Option<Vec<Free>> {
    let costs: Vec<Form> = durations_s.iter().map(|t| basis.cost_over(*t)).collect();
    let rows: Vec<Row> = nodes
        .windows(3)
        .zip(costs.windows(2))
        .enumerate()
        .filter_map(|(i, (around, costs))| match (around, costs) {
            ([from, here, to], [before, after]) => {
                let ends_here = (i == 0, i + 3 == nodes.len());
                Some(row(basis, [from, here, to], [before, after], ends_here))
            }
            _ => None,
        })
        .collect();
    // Forward.
    let mut passed: Vec<(Matrix3<f64>, Free)> = Vec::with_capacity(rows.len());
    for row in &rows {
        let (own, right) = match passed.last() {
            Some((after, right)) => (row.own - row.before * after, row.right - row.before * right),
            None => (row.own, row.right),
        };
        let inverse = scaled_inverse(&own)?;
        passed.push((inverse * row.after, inverse * right));
    }
    // And back.
    let mut found: Vec<Free> = Vec::with_capacity(rows.len());
    for (after, right) in passed.iter().rev() {
        found.push(found.last().map_or(*right, |next| right - after * next));
    }
    found.reverse();
    Some(found)
}

/// The inverse of a symmetric matrix whose rows differ in size by many orders: a short piece beside a long one.
fn scaled_inverse(m: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let scale = Matrix3::from_diagonal(&m.diagonal().map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { 1.0 }));
    let inverse = (scale * m * scale).try_inverse()?;
    Some(scale * inverse * scale)
}

/// The equations of one waypoint between two others: the cost of both pieces about it does not change with its derivatives.
fn row(basis: &Basis, around: [&Derivatives; 3], costs: [&Form; 2], at_ends: (bool, bool)) -> Row {
    let ([from, here, to], [before, after]) = (around, costs);
    let block = |form: &Form, row: usize, column: usize| form.fixed_view::<4, 4>(row, column).into_owned();
    let (to_before, own_before) = (block(before, 4, 0), block(before, 4, 4));
    let (own_after, to_after) = (block(after, 0, 0), block(after, 0, 4));
    let own = own_before + own_after;
    let free = |m: &Matrix4<f64>| m.fixed_view::<3, 3>(1, 1).into_owned();
    // What is given goes to the right-hand side: the ways of both pieces, and everything at the two ends. The cost does not depend on
    // where a piece begins; with ways instead of places, a short piece beside a long one does not lose all digits.
    let known = |node: &Derivatives, way: Vector3<f64>, whole: bool| {
        let mut known = placed(node, &way);
        if !whole {
            known.fixed_view_mut::<3, 3>(1, 0).fill(0.0);
        }
        known
    };
    let way = |from: &Derivatives, to: &Derivatives| (to.row(0) - from.row(0)).transpose();
    let sum = to_before * known(from, Vector3::zeros(), at_ends.0)
        + own_before * known(here, way(from, here), false)
        + to_after * known(to, way(here, to), at_ends.1);
    let mut row = Row {
        before: free(&to_before),
        own: free(&own),
        after: free(&to_after),
        right: -sum.fixed_view::<3, 3>(1, 0).into_owned(),
    };
    if basis.given == 3 {
        // The jerk is no unknown here.
        row.own[(2, 2)] = 1.0;
    }
    row
}
