//! Who takes which slot: with the shortest longest distance first and then the smallest sum of distances, or the smallest sum alone.
//!
//! As many vehicles as possible get a slot before anything else counts; pairs can be forbidden or made dearer.

mod bottleneck;
mod shortest_paths;

use skein_domain::OffsetFrd;

/// How long each vehicle's way into each slot is, in whatever unit counts: metres, or seconds for vehicles that are not alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Costs {
    vehicles: usize,
    slots: usize,
    /// One row per vehicle. Infinite: forbidden.
    lengths: Vec<f64>,
}

impl Costs {
    /// From what each way costs, asked as `(vehicle, slot)`. Below zero counts as zero; what is not finite is forbidden.
    #[must_use]
    pub fn from_fn(vehicles: usize, slots: usize, length: impl Fn(usize, usize) -> f64) -> Self {
        let mut lengths = Vec::with_capacity(vehicles * slots);
        for vehicle in 0..vehicles {
            lengths.extend((0..slots).map(|slot| usable(length(vehicle, slot))));
        }
        Self {
            vehicles,
            slots,
            lengths,
        }
    }

    /// The straight distances in metres.
    #[must_use]
    pub fn between(from: &[OffsetFrd], slots: &[OffsetFrd]) -> Self {
        let mut lengths = Vec::with_capacity(from.len() * slots.len());
        for a in from.iter().map(OffsetFrd::vector) {
            lengths.extend(slots.iter().map(|b| usable((a - b.vector()).norm())));
        }
        Self {
            vehicles: from.len(),
            slots: slots.len(),
            lengths,
        }
    }

    /// How many vehicles there are.
    #[must_use]
    pub fn vehicles(&self) -> usize {
        self.vehicles
    }

    /// How many slots there are.
    #[must_use]
    pub fn slots(&self) -> usize {
        self.slots
    }

    /// What a way costs; infinite if it is forbidden or there is none.
    #[must_use]
    pub fn length(&self, vehicle: usize, slot: usize) -> f64 {
        self.at(vehicle, slot)
            .and_then(|at| self.lengths.get(at))
            .copied()
            .unwrap_or(f64::INFINITY)
    }

    /// Makes a way dearer.
    pub fn add(&mut self, vehicle: usize, slot: usize, extra: f64) {
        let length = usable(self.length(vehicle, slot) + extra);
        if let Some(entry) = self.at(vehicle, slot).and_then(|at| self.lengths.get_mut(at)) {
            *entry = length;
        }
    }

    /// The vehicle is not to take the slot.
    pub fn forbid(&mut self, vehicle: usize, slot: usize) {
        self.add(vehicle, slot, f64::INFINITY);
    }

    fn at(&self, vehicle: usize, slot: usize) -> Option<usize> {
        (vehicle < self.vehicles && slot < self.slots).then_some(vehicle * self.slots + slot)
    }

    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.lengths.chunks_exact(self.slots.max(1))
    }
}

/// A number that is none comes out as infinite.
fn usable(length: f64) -> f64 {
    if length < f64::INFINITY {
        length.max(0.0)
    } else {
        f64::INFINITY
    }
}

/// What is to be the least in total.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Total {
    /// The sum of all ways.
    Ways,
    /// The sum of their squares: then no two vehicles that move in step on straight ways come near each other unless exchanging
    /// their slots would make the longest way longer.
    Squares,
}

/// Who takes which slot.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// Each vehicle's slot; none where all that are left are forbidden.
    pub slots: Vec<Option<usize>>,
    /// The longest of the ways, zero if there are none.
    pub longest: f64,
    /// The total of the ways (not of their squares).
    pub total: f64,
}

impl Assignment {
    fn new(slots: Vec<Option<usize>>, costs: &Costs) -> Self {
        let ways = || {
            let taken = slots.iter().enumerate();
            taken.filter_map(|(vehicle, slot)| slot.map(|slot| costs.length(vehicle, slot)))
        };
        let (longest, total) = (ways().fold(0.0, f64::max), ways().sum());
        Self { slots, longest, total }
    }
}

/// As many vehicles as possible get a slot; of all ways to do that, those whose longest way is the least; of those, the one with
/// the least total. Ties are broken the same way every time.
#[must_use]
pub fn least_longest(costs: &Costs, total: Total) -> Assignment {
    let longest = bottleneck::threshold(costs);
    Assignment::new(shortest_paths::solve(costs, total, longest), costs)
}

/// As many vehicles as possible get a slot; of all ways to do that, the one with the least total.
#[must_use]
pub fn least_total(costs: &Costs, total: Total) -> Assignment {
    Assignment::new(shortest_paths::solve(costs, total, f64::MAX), costs)
}

/// For each vehicle at `from` the index of the slot it shall take, so that the sum of squared distances is the least.
///
/// If there are more vehicles than slots, or distances that are not finite, those that are left over get `usize::MAX`, or a slot
/// that nobody can reach; callers that must not have that check the lists first.
#[must_use]
pub fn assign(from: &[OffsetFrd], slots: &[OffsetFrd]) -> Vec<usize> {
    let chosen = least_total(&Costs::between(from, slots), Total::Squares).slots;
    let mut taken = vec![false; slots.len()];
    for slot in chosen.iter().flatten() {
        if let Some(taken) = taken.get_mut(*slot) {
            *taken = true;
        }
    }
    let mut left = (0..slots.len()).filter(|slot| !taken.get(*slot).copied().unwrap_or(true));
    chosen
        .into_iter()
        .map(|slot| slot.or_else(|| left.next()).unwrap_or(usize::MAX))
        .collect()
}

#[cfg(test)]
mod tests;
