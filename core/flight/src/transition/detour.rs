//! Vertical detours for members whose straight ways come too close, found by local search over a few heights.

use super::clearance::{TOLERANCE_M, horizontal_m, lifted_m, straight_m};
use super::task::Task;
use crate::time_law::{Ability, duration_s};
use nalgebra::Vector3;
use skein_domain::{NodeTime, SlotMove};

/// Heights of detours that are tried, as multiples of the smallest distance, lowest effort first. Upwards before downwards: there
/// is more room above than below.
const LEVELS: [f64; 19] = [
    0.0, 1.1, -1.1, 1.4, -1.4, 1.8, -1.8, 2.3, -2.3, 2.9, -2.9, 3.6, -3.6, 4.5, -4.5, 5.5, -5.5, 7.0, -7.0,
];
/// Search steps per member before a set of ways is given up.
const STEPS_PER_MEMBER: usize = 8;

/// A pair whose ways come close enough horizontally that heights matter.
struct Near {
    other: usize,
    /// Other minus own at the start, and its change over the way.
    a: Vector3<f64>,
    d: Vector3<f64>,
    required_m: f64,
}

/// The ways of all members with their detours.
pub(super) struct Ways {
    starts: Vec<Vector3<f64>>,
    ends: Vec<Vector3<f64>>,
    lifts_m: Vec<f64>,
    near: Vec<Vec<Near>>,
    levels_m: Vec<f64>,
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
            lifts_m: vec![0.0; ends.len()],
            ends,
            levels_m: LEVELS.iter().map(|level| level * task.min_distance_m).collect(),
            pinned: task.pinned,
        }
    }

    /// Looks for detours until no pair is too close. False if none were found.
    pub fn resolve(&mut self) -> bool {
        let members = self.starts.len();
        // When a member was last moved: of two with as many conflicts the one that rested longer is moved.
        let mut moved_at = vec![0_usize; members];
        let mut tabu_m = vec![f64::NAN; members];
        let mut conflicts: Vec<usize> = (0..members).map(|i| self.conflicts(i, self.lift_m(i))).collect();
        for step in 1..=STEPS_PER_MEMBER * members + 1 {
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
            let present_m = self.lift_m(member);
            let barred_m = tabu_m.get(member).copied().unwrap_or(f64::NAN);
            let Some(level_m) = self.best_level_m(member, present_m, barred_m) else {
                return false;
            };
            self.recount(&mut conflicts, member, level_m);
            if let (Some(lift), Some(tabu), Some(at)) = (
                self.lifts_m.get_mut(member),
                tabu_m.get_mut(member),
                moved_at.get_mut(member),
            ) {
                (*tabu, *lift, *at) = (present_m, level_m, step);
            }
        }
        false
    }

    /// The height with the fewest conflicts, the first of several.
    fn best_level_m(&self, member: usize, present_m: f64, barred_m: f64) -> Option<f64> {
        let mut best: Option<(usize, f64)> = None;
        for level_m in &self.levels_m {
            if *level_m == present_m || *level_m == barred_m {
                continue;
            }
            let count = self.conflicts(member, *level_m);
            if best.is_none_or(|(least, _)| count < least) {
                best = Some((count, *level_m));
            }
            if count == 0 {
                break;
            }
        }
        best.map(|(_, level_m)| level_m)
    }

    /// Brings the numbers of conflicts up to date for a member that goes to another height: only those near it can change.
    fn recount(&self, conflicts: &mut [usize], member: usize, level_m: f64) {
        let mut own = 0;
        let present_m = self.lift_m(member);
        for near in self.near.get(member).map(Vec::as_slice).unwrap_or_default() {
            let other_m = self.lift_m(near.other);
            let (before, after) = (too_close(near, other_m - present_m), too_close(near, other_m - level_m));
            own += usize::from(after);
            if let Some(count) = conflicts.get_mut(near.other) {
                *count = (*count + usize::from(after)).saturating_sub(usize::from(before));
            }
        }
        if let Some(count) = conflicts.get_mut(member) {
            *count = own;
        }
    }

    fn lift_m(&self, member: usize) -> f64 {
        self.lifts_m.get(member).copied().unwrap_or(0.0)
    }

    /// With how many others a member would come too close at this height of its detour.
    fn conflicts(&self, member: usize, lift_m: f64) -> usize {
        let conflict = |near: &&Near| too_close(near, self.lift_m(near.other) - lift_m);
        self.near
            .get(member)
            .map_or(0, |near| near.iter().filter(conflict).count())
    }

    /// Smallest distance between any two members over the whole move; infinite for one alone.
    pub fn min_distance_m(&self) -> f64 {
        let mut least_m = f64::INFINITY;
        let ways = self.starts.iter().zip(&self.ends).zip(&self.lifts_m);
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
        let ways = self.starts.iter().zip(&self.ends).zip(&self.lifts_m).zip(abilities);
        ways.fold(0.0, |so_far_s, (((start, end), lift_m), ability)| {
            let way = end - start;
            duration_s([way.x, way.y, -way.z], *lift_m, ability, so_far_s)
        })
    }

    /// The ways as moves over one common time.
    pub fn moves(&self, start: NodeTime, duration_s: f64) -> Vec<SlotMove> {
        let ways = self.starts.iter().zip(&self.ends).zip(&self.lifts_m);
        ways.map(|((from, to), lift_m)| SlotMove {
            from: (*from).into(),
            to: (*to).into(),
            detour_up_m: *lift_m,
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
fn too_far(a: &Vector3<f64>, d: &Vector3<f64>, reach_m: f64) -> bool {
    let apart = |from: f64, to: f64| (from > reach_m && to > reach_m) || (from < -reach_m && to < -reach_m);
    apart(a.x, a.x + d.x) || apart(a.y, a.y + d.y)
}
