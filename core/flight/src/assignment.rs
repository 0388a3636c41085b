//! Who takes which slot: the least total squared distance, so that straight paths do not cross.

use pathfinding::prelude::{Matrix, kuhn_munkres_min};
use skein_domain::OffsetFrd;

/// The solver wants integers: squared distances are counted in square millimetres…
const UNITS_PER_M2: f64 = 1e6;
/// …and no single one above this (about 31 km), so that no sum over thousands of vehicles overflows.
const MAX_COST: f64 = 1e15;

/// For each vehicle at `from` the index of the slot it shall take, so that the sum of squared distances is the least.
///
/// A distance that is not finite counts as very long. If there are more vehicles than slots, those that are left over get
/// `usize::MAX`; callers that must not have that check the lengths first.
#[must_use]
pub fn assign(from: &[OffsetFrd], slots: &[OffsetFrd]) -> Vec<usize> {
    assign_by(from.len(), slots.len(), |vehicle, slot| {
        match (from.get(vehicle), slots.get(slot)) {
            (Some(a), Some(b)) => (a.vector() - b.vector()).norm_squared(),
            _ => f64::NAN,
        }
    })
}

/// The same for any cost in square metres.
pub(crate) fn assign_by(vehicles: usize, slots: usize, cost_m2: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    if vehicles == 0 {
        return Vec::new();
    }
    if slots == 0 {
        return vec![usize::MAX; vehicles];
    }
    let units = |vehicle: usize, slot: usize| {
        let units = cost_m2(vehicle, slot) * UNITS_PER_M2;
        // NaN fails the comparison and so counts as the longest.
        if units < MAX_COST {
            units.max(0.0).round() as i64
        } else {
            MAX_COST as i64
        }
    };
    // The solver needs at least as many columns as rows: surplus vehicles take columns that stand for "no slot".
    let costs = Matrix::from_fn(vehicles, slots.max(vehicles), |(vehicle, slot)| {
        if slot < slots {
            units(vehicle, slot)
        } else {
            MAX_COST as i64
        }
    });
    let (_, chosen) = kuhn_munkres_min(&costs);
    chosen
        .into_iter()
        .map(|slot| if slot < slots { slot } else { usize::MAX })
        .collect()
}

#[cfg(test)]
mod tests;
