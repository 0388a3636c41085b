//! Vertical detours for members whose straight ways come too close, found by local search over a few heights.

use super::clearance::{TOLERANCE_M, horizontal_m, lifted_m, straight_m};
use super::task::Task;
use crate::time_law::{Ability, duration_s};
use nalgebra::Vector3;
use skein_domain::{NodeTime, SlotMove};
use std::cell::Cell;

/// Heights of detours that are tried, as multiples of the smallest distance, lowest effort first. Upwards before downwards: there
/// is more room above than below.
const LEVELS: [f64; 19] = [
    0.0, 1.1, -1.1, 1.4, -1.4, 1.8, -1.8, 2.3, -2.3, 2.9, -2.9, 3.6, -3.6, 4.5, -4.5, 5.5, -5.5, 7.0, -7.0,
];
/// The index in [`LEVELS`] of no detour.
const STRAIGHT: usize = 0;
/// Search steps per member before a set of ways is given up.
const STEPS_PER_MEMBER: usize = 8;
/// It is given up too when so many steps have not made it better.
const STEPS_IN_VAIN: usize = 300;
/// Words of a set of bits for every two levels.
const WORDS: usize = (LEVELS.len() * LEVELS.len()).div_ceil(64);

/// A pair whose ways come close enough horizontally that heights matter.
struct Near {
    other: usize,
    /// Other minus own at the start, and its change over the way.
    a: Vector3<f64>,
    d: Vector3<f64>,
    required_m: f64,
    /// For which two levels it is known whether the pair comes too close, and whether it does: a bit each.
    known: Cell<[u64; WORDS]>,
    close: Cell<[u64; WORDS]>,
}

impl Near {
    fn is_too_close(&self, level: usize, other: usize, levels_m: &[f64]) -> bool {
        let at = level * LEVELS.len() + other;
        let (word, bit) = (at / 64, 1_u64 << (at % 64));
        let has = |set: &Cell<[u64; WORDS]>| set.get().get(word).is_some_and(|bits| bits & bit != 0);
        if has(&self.known) {
            return has(&self.close);
        }
        let height_m = |level: usize| levels_m.get(level).copied().unwrap_or(0.0);
        let close = too_close(self, height_m(other) - height_m(level));
        for (set, add) in [(&self.known, true), (&self.close, close)] {
            let mut bits = set.get();
            if let Some(bits) = bits.get_mut(word).filter(|_| add) {
                *bits |= bit;
            }
            set.set(bits);
        }
        close
    }
}

/// The ways of all members with their detours.
pub(super) struct Ways {
    starts: Vec<Vector3<f64>>,
    ends: Vec<Vector3<f64>>,
    levels: Vec<usize>,
    near: Vec<Vec<Near>>,
    levels_m: Vec<f64>,
    lowest_down_m: f64,
    pinned: usize,
}

impl Ways {
    /// Straight ways. A pair must keep the smallest distance, or the share `keep` of its distance at the ends if that is less.
    pub fn new(task: &Task, ends: Vec<Vector3<f64>>, keep: f64) -> Self {
        let mut near: Vec<Vec<Near>> = task.starts.iter().map(|_| Vec::new()).collect();
        let mut pair = |i: usize, j: usize, a: Vector3<f64>, b: Vector3<f64>| {
            let d = b - a;
            // Most pairs are out of reach of each other: seen without a root or a division.
            if too_far(&a, &d, task.min_distance_m) {
                return;
            }
            let ends_m = keep * a.norm().min(b.norm());
            let required_m = task.min_distance_m.min(ends_m) - 2.0 * TOLERANCE_M;
            if horizontal_m(&a, &d) >= required_m {
                return;
            }
            for (own, other, sign) in [(i, j, 1.0), (j, i, -1.0)] {
                if let Some(list) = near.get_mut(own) {
                    list.push(Near {
                        other,
                        a: a * sign,
                        d: d * sign,
                        required_m,
                        known: Cell::default(),
                        close: Cell::default(),
                    });
                }
            }
        };
        let ways = || task.starts.iter().zip(&ends).enumerate();
        for (i, (start, end)) in ways() {
            for (j, (other_start, other_end)) in ways().skip(i + 1) {
                pair(i, j, other_start - start, other_end - end);
            }
        }
        Self {
            near,
            starts: task.starts.clone(),
            levels: vec![STRAIGHT; ends.len()],
            ends,
            levels_m: LEVELS.iter().map(|level| level * task.min_distance_m).collect(),
            lowest_down_m: task.lowest_down_m,
            pinned: task.pinned,
        }
    }

    /// Whether a detour at this level leads a member lower than it may fly. Straight ways are as low as their ends.
    fn is_too_low(&self, member: usize, level: usize) -> bool {
        let lift_m = self.levels_m.get(level).copied().unwrap_or(0.0);
        let lower_end_m = [&self.starts, &self.ends]
            .iter()
            .filter_map(|places| places.get(member))
            .map(|place| place.z)
            .fold(f64::NEG_INFINITY, f64::max);
        lift_m < 0.0 && lower_end_m - lift_m > self.lowest_down_m
    }

    /// Looks for detours until no pair is too close. False if none were found.
    pub fn resolve(&mut self) -> bool {
        let members = self.starts.len();
        // When a member was last moved: of two with as many conflicts the one that rested longer is moved.
        let mut moved_at = vec![0_usize; members];
        let mut barred = vec![usize::MAX; members];
        let mut conflicts: Vec<usize> = (0..members).map(|i| self.conflicts(i, self.level(i))).collect();
        let (mut fewest, mut found_at) = (usize::MAX, 0);
        for step in 1..=STEPS_PER_MEMBER * members + 1 {
            let left: usize = conflicts.iter().sum();
            if left < fewest {
                (fewest, found_at) = (left, step);
            }
            let most = |i: &usize| {
                (
                    conflicts.get(*i).copied().unwrap_or(0),
                    usize::MAX - moved_at.get(*i).copied().unwrap_or(0),
                )
            };
            // A leader stays where it is.
            let Some(member) = (self.pinned..members)
                .filter(|i| conflicts.get(*i).is_some_and(|n| *n > 0))
                .max_by_key(most)
            else {
                return true;
            };
            let present = self.level(member);
            let barred_here = barred.get(member).copied().unwrap_or(usize::MAX);
            let Some(level) = self
                .best_level(member, present, barred_here)
                .filter(|_| step - found_at < STEPS_IN_VAIN)
            else {
                return false;
            };
            self.recount(&mut conflicts, member, level);
            if let (Some(own), Some(barred), Some(at)) = (
                self.levels.get_mut(member),
                barred.get_mut(member),
                moved_at.get_mut(member),
            ) {
                (*barred, *own, *at) = (present, level, step);
            }
        }
        false
    }

    /// The height with the fewest conflicts, the first of several.
    fn best_level(&self, member: usize, present: usize, barred: usize) -> Option<usize> {
        let mut best: Option<(usize, usize)> = None;
        let open = |level: &usize| *level != present && *level != barred && !self.is_too_low(member, *level);
        for level in (0..self.levels_m.len()).filter(open) {
            let count = self.conflicts(member, level);
            if best.is_none_or(|(least, _)| count < least) {
                best = Some((count, level));
            }
            if count == 0 {
                break;
            }
        }
        best.map(|(_, level)| level)
    }

    /// Brings the numbers of conflicts up to date for a member that goes to another height: only those near it can change.
    fn recount(&self, conflicts: &mut [usize], member: usize, level: usize) {
        let mut own = 0;
        let present = self.level(member);
        for near in self.near.get(member).map(Vec::as_slice).unwrap_or_default() {
            let other = self.level(near.other);
            let before = near.is_too_close(present, other, &self.levels_m);
            let after = near.is_too_close(level, other, &self.levels_m);
            own += usize::from(after);
            if let Some(count) = conflicts.get_mut(near.other) {
                *count = (*count + usize::from(after)).saturating_sub(usize::from(before));
            }
        }
        if let Some(count) = conflicts.get_mut(member) {
            *count = own;
        }
    }

    fn level(&self, member: usize) -> usize {
        self.levels.get(member).copied().unwrap_or(STRAIGHT)
    }

    /// The height of every member's detour.
    fn lifts_m(&self) -> impl Iterator<Item = f64> + Clone {
        self.levels
            .iter()
            .map(|level| self.levels_m.get(*level).copied().unwrap_or(0.0))
    }

    /// Every member's start, end and height of its detour.
    pub fn each(&self) -> impl Iterator<Item = (&Vector3<f64>, &Vector3<f64>, f64)> {
        let ways = self.starts.iter().zip(&self.ends).zip(self.lifts_m());
        ways.map(|((start, end), lift_m)| (start, end, lift_m))
    }

    /// With how many others a member would come too close at this height of its detour.
    fn conflicts(&self, member: usize, level: usize) -> usize {
        let conflict = |near: &&Near| near.is_too_close(level, self.level(near.other), &self.levels_m);
        self.near
            .get(member)
            .map_or(0, |near| near.iter().filter(conflict).count())
    }

    /// Smallest distance between any two members over the whole move; infinite for one alone.
    pub fn min_distance_m(&self) -> f64 {
        let mut least_m = f64::INFINITY;
        let ways = self.starts.iter().zip(&self.ends).zip(self.lifts_m());
        for (i, ((start, end), lift_m)) in ways.clone().enumerate() {
            for ((other_start, other_end), other_lift_m) in ways.clone().skip(i + 1) {
                let (a, b) = (other_start - start, other_end - end);
                let d = b - a;
                if !too_far(&a, &d, least_m) && horizontal_m(&a, &d) < least_m {
                    least_m = least_m.min(lifted_m(&a, &d, other_lift_m - lift_m, least_m));
                }
            }
        }
        least_m
    }

    /// The duration that the slowest member needs for its way.
    pub fn longest_s(&self, abilities: &[Ability]) -> f64 {
        let ways = self.starts.iter().zip(&self.ends).zip(self.lifts_m()).zip(abilities);
        ways.fold(0.0, |so_far_s, (((start, end), lift_m), ability)| {
            let way = end - start;
            duration_s([way.x, way.y, -way.z], lift_m, ability, so_far_s)
        })
    }

    /// The ways as moves over one common time.
    pub fn moves(&self, start: NodeTime, duration_s: f64) -> Vec<SlotMove> {
        let ways = self.starts.iter().zip(&self.ends).zip(self.lifts_m());
        ways.map(|((from, to), lift_m)| SlotMove {
            from: (*from).into(),
            to: (*to).into(),
            detour_up_m: lift_m,
            start,
            duration_s,
        })
        .collect()
    }
}

/// Whether a pair comes too close with this difference of heights.
fn too_close(near: &Near, lift_m: f64) -> bool {
    let limit_m = near.required_m - TOLERANCE_M;
    if lift_m == 0.0 {
        return straight_m(&near.a, &near.d) < limit_m;
    }
    lifted_m(&near.a, &near.d, lift_m, near.required_m) < limit_m
}

/// Whether `a + s·d` stays further than `reach_m` away on one of the two level axes: then no distance can be smaller.
pub(super) fn too_far(a: &Vector3<f64>, d: &Vector3<f64>, reach_m: f64) -> bool {
    let apart = |from: f64, to: f64| (from > reach_m && to > reach_m) || (from < -reach_m && to < -reach_m);
    apart(a.x, a.x + d.x) || apart(a.y, a.y + d.y)
}
