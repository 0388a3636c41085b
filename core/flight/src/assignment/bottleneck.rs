//! Bottleneck assignment, whose longest distance is as short as possible: a search for the smallest length under which as many get a slot
//! as can at all (Garfinkel, *An improved algorithm for the bottleneck assignment problem*, Operations Research 19, 1971), with maximum
//! matchings by augmenting paths (Hopcroft, Karp, SIAM J. Comput. 2, 1973) over sets of bits.

use super::Costs;

/// No partner.
const NOBODY: usize = usize::MAX;
/// Bits of one word.
const WORD: usize = u64::BITS as usize;
/// So many numbers are compared at once.
const LANES: usize = 8;

/// The ways between two lengths are looked at one by one once these are within this share of each other.
const NEAR: f64 = 1.004;

/// The smallest length for which the ways that are not longer give as many vehicles a slot as all ways do.
pub(super) fn threshold(costs: &Costs) -> f64 {
    let mut longest = largest(&costs.lengths, f64::INFINITY);
    let mut most = costs.vehicles.min(costs.slots);
    if longest == f64::INFINITY {
        longest = largest(&costs.lengths, f64::MAX);
        most = Matching::none(costs).grow(&Allowed::up_to(costs, longest), usize::MAX);
    }
    let mut below = lower_bound(costs, most);
    let mut matching = Matching::none(costs);
    if matching.grow(&Allowed::up_to(costs, below), most) >= most {
        return below;
    }
    // Ever longer until it is enough, then halfway again and again. What is matched under a shorter length stays matched under a
    // longer one.
    let mut enough = longest;
    let mut factor = 1.05;
    while below > 0.0 && below * NEAR < enough {
        let tried = if enough < longest {
            0.5 * (below + enough)
        } else {
            below * factor
        };
        if tried >= longest {
            break;
        }
        let mut wider = matching.clone();
        if wider.grow(&Allowed::up_to(costs, tried), most) >= most {
            enough = tried;
        } else {
            (below, matching) = (tried, wider);
            factor *= factor;
        }
    }
    between(costs, matching, most, below, enough)
}

/// The answer is one of the lengths above `below` and up to `enough`: halve their number until one is left.
fn between(costs: &Costs, mut matching: Matching, most: usize, below: f64, mut enough: f64) -> f64 {
    let mut allowed = Allowed::up_to(costs, below);
    let mut open = ways_between(costs, below, enough);
    while !open.is_empty() {
        let middle = (open.len() - 1) / 2;
        let (_, tried, _) = open.select_nth_unstable_by(middle, |a, b| a.length.total_cmp(&b.length));
        let tried = tried.length;
        let mut wider = matching.clone();
        let mut more = allowed.clone();
        open.iter()
            .filter(|way| way.length <= tried)
            .for_each(|way| more.add(way));
        if wider.grow(&more, most) >= most {
            enough = tried;
            open.retain(|way| way.length < tried);
        } else {
            (matching, allowed) = (wider, more);
            open.retain(|way| way.length > tried);
        }
    }
    enough
}

/// The way of a vehicle into a slot.
struct Way {
    length: f64,
    vehicle: usize,
    slot: usize,
}

fn ways_between(costs: &Costs, below: f64, enough: f64) -> Vec<Way> {
    let mut ways = Vec::new();
    for (vehicle, row) in costs.rows().enumerate() {
        for (number, lengths) in row.chunks(WORD).enumerate() {
            // Most stretches of a row have none.
            let within = |length: &f64| usize::from(*length > below) & usize::from(*length <= enough);
            if lengths.iter().map(within).sum::<usize>() == 0 {
                continue;
            }
            let some = lengths.iter().enumerate().filter(|(_, length)| within(length) > 0);
            ways.extend(some.map(|(at, length)| Way {
                length: *length,
                vehicle,
                slot: number * WORD + at,
            }));
        }
    }
    ways
}

/// The largest of the numbers that are not above `most`; zero if there are none. Several at a time: one after the other would have
/// each comparison wait for the last.
pub(super) fn largest(numbers: &[f64], most: f64) -> f64 {
    let mut lanes = [0.0; LANES];
    let (chunks, rest) = numbers.as_chunks::<LANES>();
    for chunk in chunks {
        for (largest, number) in lanes.iter_mut().zip(chunk) {
            let number = if *number <= most { *number } else { 0.0 };
            *largest = if number > *largest { number } else { *largest };
        }
    }
    let rest = rest.iter().filter(|number| **number <= most);
    lanes.iter().chain(rest).copied().fold(0.0, f64::max)
}

/// The smallest of the numbers; infinite if there are none.
fn smallest(numbers: &[f64]) -> f64 {
    let mut lanes = [f64::INFINITY; LANES];
    let (chunks, rest) = numbers.as_chunks::<LANES>();
    for chunk in chunks {
        lower(&mut lanes, chunk);
    }
    lanes.iter().chain(rest).copied().fold(f64::INFINITY, f64::min)
}

/// Each becomes the smaller of the two.
fn lower(least: &mut [f64], numbers: &[f64]) {
    for (least, number) in least.iter_mut().zip(numbers) {
        *least = if *number < *least { *number } else { *least };
    }
}

/// Everyone needs its shortest way at least, where all of them get a slot; so does every slot where all of those are taken.
fn lower_bound(costs: &Costs, most: usize) -> f64 {
    let mut bound = 0.0_f64;
    if most == costs.vehicles {
        bound = costs.rows().map(smallest).fold(bound, f64::max);
    }
    if most == costs.slots {
        let mut shortest = vec![f64::INFINITY; costs.slots];
        for row in costs.rows() {
            lower(&mut shortest, row);
        }
        bound = shortest.into_iter().fold(bound, f64::max);
    }
    // A vehicle or slot without any way is not among those that count.
    if bound.is_finite() { bound } else { 0.0 }
}

/// Which slots each vehicle may take, a bit each: slot `bit * words + word`, so that a row is compared several words at a time.
#[derive(Clone)]
struct Allowed {
    words: usize,
    bits: Vec<u64>,
}

impl Allowed {
    fn up_to(costs: &Costs, longest: f64) -> Self {
        let words = costs.slots.div_ceil(WORD).max(1);
        let mut bits = vec![0; words * costs.vehicles];
        for (row, bits) in costs.rows().zip(bits.chunks_exact_mut(words)) {
            for (bit, lengths) in row.chunks(words).enumerate() {
                let bit = 1_u64 << bit;
                for (word, length) in bits.iter_mut().zip(lengths) {
                    *word |= if *length <= longest { bit } else { 0 };
                }
            }
        }
        Self { words, bits }
    }

    fn add(&mut self, way: &Way) {
        let (word, bit) = (way.slot % self.words, way.slot / self.words);
        if let Some(word) = self.bits.get_mut(way.vehicle * self.words + word) {
            *word |= 1 << bit;
        }
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
    let words = allowed.len();
    for (at, (allowed, open)) in allowed.iter().zip(open).enumerate() {
        let common = allowed & *open;
        if common != 0 {
            *open &= !(common & common.wrapping_neg());
            return Some(common.trailing_zeros() as usize * words + at);
        }
    }
    None
}
