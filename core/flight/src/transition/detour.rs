//! Vertical detours for members whose straight ways come too close, found by local search over a few heights.

use super::MotionLimits;
use super::clearance::{TOLERANCE_M, horizontal_m, lifted_m};
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
}

impl Ways {
    /// Straight ways. A pair must keep `min_distance_m`, or the share `keep` of its distance at the ends if that is less.
    pub fn new(starts: &[Vector3<f64>], ends: &[Vector3<f64>], min_distance_m: f64, keep: f64) -> Self {
        let ways: Vec<_> = starts.iter().zip(ends).collect();
        let near_of = |(i, own): (usize, &(&Vector3<f64>, &Vector3<f64>))| {
            let near = |(other, way): (usize, &(&Vector3<f64>, &Vector3<f64>))| {
                let (a, b) = (way.0 - own.0, way.1 - own.1);
                let required_m = min_distance_m.min(keep * a.norm()).min(keep * b.norm()) - 2.0 * TOLERANCE_M;
                let d = b - a;
                (other != i && horizontal_m(&a, &d) < required_m).then_some(Near {
                    other,
                    a,
                    d,
                    required_m,
                })
            };
            ways.iter().enumerate().filter_map(near).collect()
        };
        Self {
            near: ways.iter().enumerate().map(near_of).collect(),
            starts: starts.to_vec(),
            ends: ends.to_vec(),
            lifts_m: vec![0.0; starts.len()],
            levels_m: LEVELS.iter().map(|level| level * min_distance_m).collect(),
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
            // The leader (0) stays where it is.
            let Some(member) = (1..members)
                .filter(|i| conflicts.get(*i).is_some_and(|n| *n > 0))
                .max_by_key(most)
            else {
                return true;
            };
            let present_m = self.lift_m(member);
            let barred_m = tabu_m.get(member).copied().unwrap_or(f64::NAN);
            let chosen = self
                .levels_m
                .iter()
                .filter(|level| **level != present_m && **level != barred_m)
                .map(|level| (self.conflicts(member, *level), *level))
                .min_by_key(|(count, _)| *count);
            let Some((_, level_m)) = chosen else { return false };
            if let (Some(lift), Some(tabu), Some(at)) = (
                self.lifts_m.get_mut(member),
                tabu_m.get_mut(member),
                moved_at.get_mut(member),
            ) {
                (*tabu, *lift, *at) = (present_m, level_m, step);
            }
            conflicts = (0..members).map(|i| self.conflicts(i, self.lift_m(i))).collect();
        }
        false
    }

    fn lift_m(&self, member: usize) -> f64 {
        self.lifts_m.get(member).copied().unwrap_or(0.0)
    }

    /// With how many others a member would come too close at this height of its detour.
    fn conflicts(&self, member: usize, lift_m: f64) -> usize {
        let too_close = |near: &&Near| {
            lifted_m(&near.a, &near.d, self.lift_m(near.other) - lift_m, near.required_m)
                < near.required_m - TOLERANCE_M
        };
        self.near
            .get(member)
            .map_or(0, |near| near.iter().filter(too_close).count())
    }

    /// Smallest distance between any two members over the whole move; infinite for one alone.
    pub fn min_distance_m(&self) -> f64 {
        let mut least_m = f64::INFINITY;
        let ways = self.starts.iter().zip(&self.ends).zip(&self.lifts_m);
        for (i, ((start, end), lift_m)) in ways.clone().enumerate() {
            for ((other_start, other_end), other_lift_m) in ways.clone().skip(i + 1) {
                let (a, b) = (other_start - start, other_end - end);
                if horizontal_m(&a, &(b - a)) < least_m {
                    least_m = least_m.min(lifted_m(&a, &(b - a), other_lift_m - lift_m, least_m));
                }
            }
        }
        least_m
    }

    /// The duration that the slowest member needs.
    pub fn longest_s(&self, limits: &MotionLimits) -> f64 {
        let ability = Ability {
            speed_m_s: limits.speed_m_s,
            acceleration_m_s2: limits.acceleration_m_s2,
            climb_m_s: limits.climb_m_s,
        };
        let ways = self.starts.iter().zip(&self.ends).zip(&self.lifts_m);
        ways.fold(0.0, |so_far_s, ((start, end), lift_m)| {
            let way = end - start;
            duration_s([way.x, way.y, -way.z], *lift_m, &ability, so_far_s)
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
