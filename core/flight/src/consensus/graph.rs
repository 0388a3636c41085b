//! Who is whose neighbour, and whether that is enough to hold a shape together.

use nalgebra::{DMatrix, Vector3};
use skein_domain::OffsetFrd;
use std::collections::BTreeSet;

/// Up to so many vehicles the graph's rigidity is counted out; the cost grows with the cube of their number.
const COUNTED_UP_TO: usize = 40;
/// A singular value this small against the largest counts as none.
const NO_RANK: f64 = 1e-7;

/// For each slot the places in the list of its neighbours, ascending: mutual, connected, at least the `per_vehicle` nearest (as many as
/// there are), and up to forty slots as rigid in distances and in bearings as if everybody were everybody's neighbour. A flat or straight
/// shape is not rigid in 3-D however many neighbours there are; then the graph holds what can be held.
#[must_use]
pub fn neighbours(slots: &[OffsetFrd], per_vehicle: usize) -> Vec<Vec<usize>> {
    let count = slots.len();
    let others = count.saturating_sub(1);
    let mut each = per_vehicle.clamp(1, others.max(1)).min(others);
    let order = by_distance(slots);
    let complete: Option<(usize, usize)> = (count <= COUNTED_UP_TO).then(|| {
        let all = nearest(&order, others);
        (distance_rank(slots, &all), bearing_rank(slots, &all))
    });
    loop {
        let mut graph = nearest(&order, each);
        connect(slots, &mut graph);
        let enough = complete.is_none_or(|(distances, bearings)| {
            distance_rank(slots, &graph) >= distances && bearing_rank(slots, &graph) >= bearings
        });
        if enough || each >= others {
            return graph;
        }
        each += 1;
    }
}

/// For each slot all others, nearest first; of equally near ones the first in the list.
fn by_distance(slots: &[OffsetFrd]) -> Vec<Vec<usize>> {
    slots
        .iter()
        .enumerate()
        .map(|(i, own)| {
            let mut others: Vec<(f64, usize)> = slots
                .iter()
                .enumerate()
                .filter(|(j, _)| *j != i)
                // Rounded, so that the same distance counted in two ways is the same.
                .map(|(j, other)| (((other.vector() - own.vector()).norm() * 1e6).round(), j))
                .collect();
            others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            others.into_iter().map(|(_, j)| j).collect()
        })
        .collect()
}

/// Everybody's nearest, made mutual.
fn nearest(order: &[Vec<usize>], each: usize) -> Vec<Vec<usize>> {
    let mut graph = vec![BTreeSet::new(); order.len()];
    for (i, others) in order.iter().enumerate() {
        for j in others.iter().take(each) {
            graph.get_mut(i).map(|set| set.insert(*j));
            graph.get_mut(*j).map(|set| set.insert(i));
        }
    }
    graph.into_iter().map(|set| set.into_iter().collect()).collect()
}

/// Joins parts that hang together in themselves only, by the shortest edge from what hangs together with the first.
fn connect(slots: &[OffsetFrd], graph: &mut [Vec<usize>]) {
    for _ in 0..graph.len() {
        let reached = reached_from_first(graph);
        let apart = |(_, is_in): &(usize, &bool)| !**is_in;
        let mut shortest: Option<(f64, usize, usize)> = None;
        for (j, _) in reached.iter().enumerate().filter(apart) {
            for (i, _) in reached.iter().enumerate().filter(|(_, is_in)| **is_in) {
                let (Some(a), Some(b)) = (slots.get(i), slots.get(j)) else {
                    continue;
                };
                let off_m = (a.vector() - b.vector()).norm();
                if shortest.is_none_or(|(least, ..)| off_m < least) {
                    shortest = Some((off_m, i, j));
                }
            }
        }
        let Some((_, i, j)) = shortest else { return };
        for (from, to) in [(i, j), (j, i)] {
            if let Some(list) = graph.get_mut(from) {
                list.push(to);
                list.sort_unstable();
            }
        }
    }
}

fn reached_from_first(graph: &[Vec<usize>]) -> Vec<bool> {
    let mut reached = vec![false; graph.len()];
    let mut open = Vec::new();
    if let Some(first) = reached.first_mut() {
        *first = true;
        open.push(0);
    }
    while let Some(i) = open.pop() {
        for j in graph.get(i).into_iter().flatten() {
            if let Some(seen @ false) = reached.get_mut(*j) {
                *seen = true;
                open.push(*j);
            }
        }
    }
    reached
}

/// Rank of the rigidity matrix: how many directions of change the distances notice. `3n - 6` for a shape that is rigid in 3-D.
#[must_use]
pub fn distance_rank(slots: &[OffsetFrd], graph: &[Vec<usize>]) -> usize {
    rank(slots, graph, |direction| direction * direction.transpose())
}

/// Rank of the bearing rigidity matrix: how many directions of change the bearings notice. `3n - 4` for a shape that bearings fix up to
/// its place and size.
#[must_use]
pub fn bearing_rank(slots: &[OffsetFrd], graph: &[Vec<usize>]) -> usize {
    rank(slots, graph, |direction| {
        nalgebra::Matrix3::identity() - direction * direction.transpose()
    })
}

/// Rank of the Laplacian whose edges are weighted with a matrix of their direction: the same as that of the rigidity matrix, whose product
/// with its transpose it is.
fn rank(slots: &[OffsetFrd], graph: &[Vec<usize>], weight: impl Fn(Vector3<f64>) -> nalgebra::Matrix3<f64>) -> usize {
    let mut laplacian = DMatrix::<f64>::zeros(3 * slots.len(), 3 * slots.len());
    for (i, list) in graph.iter().enumerate().take(slots.len()) {
        for j in list.iter().filter(|j| **j < slots.len() && **j != i) {
            let (Some(a), Some(b)) = (slots.get(i), slots.get(*j)) else {
                continue;
            };
            let Some(direction) = (b.vector() - a.vector()).try_normalize(1e-9) else {
                continue;
            };
            let edge = weight(direction);
            let mut own = laplacian.fixed_view_mut::<3, 3>(3 * i, 3 * i);
            own += edge;
            let mut other = laplacian.fixed_view_mut::<3, 3>(3 * i, 3 * j);
            other -= edge;
        }
    }
    if laplacian.iter().any(|value| !value.is_finite()) {
        return 0;
    }
    let values = laplacian.symmetric_eigenvalues();
    let largest = values.iter().copied().fold(0.0, f64::max);
    values.iter().filter(|value| **value > NO_RANK * largest).count()
}
