//! The least longest way: a search for the smallest length under which as many get a slot as can at all (Garfinkel, *An improved
//! algorithm for the bottleneck assignment problem*, Operations Research 19, 1971), with maximum matchings by augmenting paths
//! (Hopcroft, Karp, SIAM J. Comput. 2, 1973) over sets of bits.

use super::Costs;

/// No partner.
const NOBODY: usize = usize::MAX;
/// Bits of one word.
const WORD: usize = u64::BITS as usize;

/// The smallest length for which the ways that are not longer give as many vehicles a slot as all ways do.
pub(super) fn threshold(costs: &Costs) -> f64 {
    let longest = costs
        .lengths
        .iter()
        .copied()
        .filter(|length| length.is_finite())
        .fold(0.0, f64::max);
    let mut all = Matching::none(costs);
    let most = if costs.lengths.iter().all(|length| length.is_finite()) {
        costs.vehicles.min(costs.slots)
    } else {
        all.grow(&Allowed::up_to(costs, longest), usize::MAX)
    };
    let mut below = lower_bound(costs, most);
    let mut matching = Matching::none(costs);
    if matching.grow(&Allowed::up_to(costs, below), most) >= most {
        return below;
    }
    // Ever longer until it is enough. What is matched under a shorter length stays matched under a longer one.
    let mut enough = longest;
    let mut factor = 1.05;
    while below * factor < longest && below > 0.0 {
        let tried = below * factor;
        let mut wider = matching.clone();
        if wider.grow(&Allowed::up_to(costs, tried), most) >= most {
            enough = tried;
            break;
        }
        (below, matching) = (tried, wider);
        factor *= factor;
    }
    between(costs, matching, most, below, enough)
}

/// The answer is one of the lengths above `below` and up to `enough`: halve their number until one is left.
fn between(costs: &Costs, mut matching: Matching, most: usize, below: f64, enough: f64) -> f64 {
    let within = |length: &f64| *length > below && *length <= enough;
    let mut open: Vec<f64> = costs.lengths.iter().copied().filter(within).collect();
    let mut enough = enough;
    while !open.is_empty() {
        let middle = (open.len() - 1) / 2;
        let (_, tried, _) = open.select_nth_unstable_by(middle, f64::total_cmp);
        let tried = *tried;
        let mut wider = matching.clone();
        if wider.grow(&Allowed::up_to(costs, tried), most) >= most {
            enough = tried;
            open.retain(|length| *length < tried);
        } else {
            matching = wider;
            open.retain(|length| *length > tried);
        }
    }
    enough
}

/// Everyone needs its shortest way at least, where all of them get a slot; so does every slot where all of those are taken.
fn lower_bound(costs: &Costs, most: usize) -> f64 {
    let mut bound = 0.0_f64;
    if most == costs.vehicles {
        let shortest = |row: &[f64]| row.iter().copied().fold(f64::INFINITY, f64::min);
        bound = costs.rows().map(shortest).fold(bound, f64::max);
    }
    if most == costs.slots {
        let mut shortest = vec![f64::INFINITY; costs.slots];
        for row in costs.rows() {
            for (least, length) in shortest.iter_mut().zip(row) {
                *least = least.min(*length);
            }
        }
        bound = shortest.into_iter().fold(bound, f64::max);
    }
    // A vehicle or slot without any way is not among those that count.
    if bound.is_finite() { bound } else { 0.0 }
}

/// Which slots each vehicle may take, a bit each.
struct Allowed {
    words: usize,
    bits: Vec<u64>,
}

impl Allowed {
    fn up_to(costs: &Costs, longest: f64) -> Self {
        let words = costs.slots.div_ceil(WORD).max(1);
        let mut bits = Vec::with_capacity(words * costs.vehicles);
        for row in costs.rows() {
            let word = |lengths: &[f64]| {
                let bit = |(at, length): (usize, &f64)| u64::from(*length <= longest) << at;
                lengths.iter().enumerate().map(bit).fold(0, |word, bit| word | bit)
            };
            bits.extend(row.chunks(WORD).map(word));
        }
        Self { words, bits }
    }

    fn of(&self, vehicle: usize) -> &[u64] {
        let begin = vehicle * self.words;
        self.bits.get(begin..begin + self.words).unwrap_or_default()
    }
}

/// Who has whom.
#[derive(Debug, Clone)]
struct Matching {
    slot_of: Vec<usize>,
    vehicle_of: Vec<usize>,
    size: usize,
}

impl Matching {
    fn none(costs: &Costs) -> Self {
        Self {
            slot_of: vec![NOBODY; costs.vehicles],
            vehicle_of: vec![NOBODY; costs.slots],
            size: 0,
        }
    }

    /// Makes the matching as large as the allowed ways permit, but stops at `wanted`. Gives its size.
    fn grow(&mut self, allowed: &Allowed, wanted: usize) -> usize {
        loop {
            let before = self.size;
            // Slots not looked at yet. Within one round none is looked at twice, whatever paths were found meanwhile.
            let mut open = vec![u64::MAX; allowed.words];
            for vehicle in 0..self.slot_of.len() {
                if self.size >= wanted {
                    return self.size;
                }
                if self.slot_of.get(vehicle) == Some(&NOBODY) {
                    self.augment(vehicle, allowed, &mut open);
                }
            }
            if self.size == before {
                return self.size;
            }
        }
    }

    /// Looks depth first for a path from a vehicle without slot to a slot without vehicle, and exchanges along it.
    fn augment(&mut self, vehicle: usize, allowed: &Allowed, open: &mut [u64]) {
        // Vehicles on the path, each with the slot it is about to take.
        let mut path: Vec<(usize, usize)> = vec![(vehicle, NOBODY)];
        while let Some((vehicle, slot)) = path.last_mut() {
            let Some(next) = first_common(allowed.of(*vehicle), open) else {
                path.pop();
                continue;
            };
            *slot = next;
            match self.vehicle_of.get(next) {
                Some(&NOBODY) => break,
                Some(&holder) => path.push((holder, NOBODY)),
                None => {}
            }
        }
        if path.is_empty() {
            return;
        }
        for (vehicle, slot) in path {
            if let (Some(own), Some(holder)) = (self.slot_of.get_mut(vehicle), self.vehicle_of.get_mut(slot)) {
                (*own, *holder) = (slot, vehicle);
            }
        }
        self.size += 1;
    }
}

/// The first bit that is set in both; it is cleared in `open`.
fn first_common(allowed: &[u64], open: &mut [u64]) -> Option<usize> {
    for (at, (allowed, open)) in allowed.iter().zip(open).enumerate() {
        let common = allowed & *open;
        if common != 0 {
            *open &= !(common & common.wrapping_neg());
            return Some(at * WORD + common.trailing_zeros() as usize);
        }
    }
    None
}
