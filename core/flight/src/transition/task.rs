//! A change of formation made ready for planning, the assignments that are tried, and the choice among them.

use super::clearance;
use super::detour::Ways;
use super::{Change, FormationError, MotionLimits};
use crate::assignment::{Assignment, Costs, Total, least_longest, least_total};
use crate::formation::{View, views};
use crate::limits::TURN_SPEED_SHARE;
use crate::time_law::Ability;
use nalgebra::Vector3;
use skein_domain::{FlightLimits, OffsetFrd};

/// Everyone keeps the slot held unless others are this much quicker.
const HELD_MAY_TAKE: f64 = 1.2;
/// However much the formation itself takes of a member's speed, this share of what the change may use is left to it: the change must
/// come to an end.
const LEAST_SPEED_SHARE: f64 = 0.1;

/// Whether a change can be planned at all.
pub(super) fn check(change: &Change<'_>) -> Result<(), FormationError> {
    let members = change.from.len();
    if members == 0 {
        return Err(FormationError::NoMembers);
    }
    if change.slots.len() < members {
        return Err(FormationError::NotEnoughSlots {
            members,
            slots: change.slots.len(),
        });
    }
    for list in [change.from, change.slots] {
        if let Some(index) = list.iter().position(|offset| !offset.is_finite()) {
            return Err(FormationError::NotFinite { index });
        }
    }
    for (list, entries) in [
        ("limits", Some(change.able.len()).filter(|entries| *entries > 0)),
        ("held slots", change.held.map(<[usize]>::len)),
    ] {
        if let Some(entries) = entries.filter(|entries| *entries != members) {
            return Err(FormationError::ListDoesNotFit { list, members, entries });
        }
    }
    let limits = &change.limits;
    let usable = |(limit, value): (&'static str, f64)| {
        if value > 0.0 && value.is_finite() {
            Ok(())
        } else {
            Err(FormationError::InvalidLimit { limit, value })
        }
    };
    [
        ("speed_m_s", limits.speed_m_s),
        ("acceleration_m_s2", limits.acceleration_m_s2),
        ("climb_m_s", limits.climb_m_s),
        ("min_distance_m", limits.min_distance_m),
    ]
    .into_iter()
    .try_for_each(usable)?;
    for able in change.able {
        [
            ("max_speed_m_s", able.max_speed_m_s),
            ("max_acceleration_m_s2", able.max_acceleration_m_s2),
            ("max_climb_m_s", able.max_climb_m_s),
            ("max_descent_m_s", able.max_descent_m_s),
        ]
        .into_iter()
        .try_for_each(usable)?;
    }
    Ok(())
}

/// What a member can do within the formation.
fn ability(limits: &MotionLimits, able: &FlightLimits, taken_m_s: f64) -> Ability {
    let spare_m_s = able.max_speed_m_s * TURN_SPEED_SHARE - taken_m_s.max(0.0);
    let least_m_s = LEAST_SPEED_SHARE * limits.speed_m_s.min(able.max_speed_m_s);
    Ability {
        speed_m_s: limits.speed_m_s.min(spare_m_s.max(least_m_s)),
        acceleration_m_s2: limits.acceleration_m_s2.min(able.max_acceleration_m_s2),
        // A detour goes up and down again.
        climb_m_s: limits.climb_m_s.min(able.max_climb_m_s).min(able.max_descent_m_s),
    }
}

/// A change made ready.
pub(super) struct Task {
    pub starts: Vec<Vector3<f64>>,
    slots: Vec<Vector3<f64>>,
    pub abilities: Vec<Ability>,
    pub min_distance_m: f64,
    /// No detour leads lower than this.
    pub lowest_down_m: f64,
    /// 1 with a leader: so many members from the first on have their slot already, at zero.
    pub pinned: usize,
    held: Option<Vec<usize>>,
    /// Which members must have a free view, and which view each slot has; none if nobody must.
    keeps_view: Vec<bool>,
    views: Vec<View>,
}

impl Task {
    pub fn new(change: &Change<'_>) -> Self {
        let pinned = usize::from(change.led);
        let mut starts: Vec<Vector3<f64>> = change.from.iter().map(OffsetFrd::vector).collect();
        let mut slots: Vec<Vector3<f64>> = change.slots.iter().map(OffsetFrd::vector).collect();
        for list in [&mut starts, &mut slots] {
            list.iter_mut().take(pinned).for_each(|place| *place = Vector3::zeros());
        }
        let limits = &change.limits;
        let alike = Ability {
            speed_m_s: limits.speed_m_s,
            acceleration_m_s2: limits.acceleration_m_s2,
            climb_m_s: limits.climb_m_s,
        };
        let mut abilities: Vec<Ability> = change
            .able
            .iter()
            .map(|able| ability(limits, able, change.taken_m_s))
            .collect();
        abilities.resize(starts.len(), alike);
        let keeps_view: Vec<bool> = change.able.iter().map(|able| able.keeps_view).collect();
        // A view is blocked by whoever else flies, so that slots that stay empty do not count if it is known which.
        let views = if keeps_view.iter().skip(pinned).any(|keeps| *keeps) {
            views(change.slots)
        } else {
            Vec::new()
        };
        Self {
            starts,
            slots,
            abilities,
            min_distance_m: limits.min_distance_m,
            lowest_down_m: change.lowest_down_m.unwrap_or(f64::INFINITY),
            pinned,
            held: change.held.map(<[usize]>::to_vec),
            keeps_view,
            views,
        }
    }

    /// Where everyone ends who keeps the slot held; none if they are not known, or two hold one.
    pub fn held_ends(&self) -> Option<Vec<Vector3<f64>>> {
        let held = self.held.as_deref()?;
        let mut taken = vec![false; self.slots.len()];
        for (member, slot) in held.iter().enumerate() {
            let free = taken.get_mut(*slot)?;
            if std::mem::replace(free, true) || (member < self.pinned && *slot != member) {
                return None;
            }
        }
        held.iter().map(|slot| self.slots.get(*slot).copied()).collect()
    }

    /// The ends of all members in every assignment worth trying.
    pub fn candidates(&self) -> Vec<Vec<Vector3<f64>>> {
        // Least squares: pairs of followers cannot cross, only the leader may be in the way. The other has ways around the leader
        // preferred; that pays where a detour over it would be too steep. The assignment with the shortest longest distance is often the quickest.
        let plain = self.costs(false);
        let mut found = vec![
            least_total(&plain, Total::Squares),
            least_longest(&plain, Total::Squares),
        ];
        if self.pinned > 0 {
            let around = self.costs(true);
            if around != plain {
                found.push(least_total(&around, Total::Squares));
                found.push(least_longest(&around, Total::Squares));
            }
        }
        let mut candidates: Vec<Vec<Vector3<f64>>> = Vec::with_capacity(found.len());
        for ends in found.iter().map(|assignment| self.ends(assignment)) {
            if !candidates.contains(&ends) {
                candidates.push(ends);
            }
        }
        candidates
    }

    /// How long every member's way into every slot is, as if all were as quick as the quickest: a slow one's way counts for more.
    fn costs(&self, around_the_leader: bool) -> Costs {
        let quickest_m_s = self
            .abilities
            .iter()
            .map(|ability| ability.speed_m_s)
            .fold(0.0, f64::max);
        let followers = self.starts.get(self.pinned..).unwrap_or_default();
        let free = self.slots.get(self.pinned..).unwrap_or_default();
        let farthest_m = followers
            .iter()
            .chain(free)
            .map(|place| place.norm())
            .fold(1.0, f64::max);
        let length = |i: usize, j: usize| {
            let (Some(a), Some(b), Some(ability)) =
                (followers.get(i), free.get(j), self.abilities.get(i + self.pinned))
            else {
                return f64::NAN;
            };
            let mut length = (b - a).norm() * quickest_m_s / ability.speed_m_s;
            if around_the_leader && clearance::straight_m(a, &(b - a)) < self.min_distance_m {
                length = (5.0 * length * length + 100.0).sqrt();
            }
            length + self.view_cost(i + self.pinned, j + self.pinned) * farthest_m
        };
        Costs::from_fn(followers.len(), free.len(), length)
    }

    /// What a slot without the wanted view costs, in sizes of the formation: more than any way could make up for.
    fn view_cost(&self, member: usize, slot: usize) -> f64 {
        if self.keeps_view.get(member) != Some(&true) {
            return 0.0;
        }
        match self.views.get(slot) {
            Some(View::Blocked) => 20.0,
            Some(View::Outward) => 5.0,
            Some(View::Ahead) | None => 0.0,
        }
    }

    /// Ends for all members: the leader's is zero. Who got no slot stays.
    fn ends(&self, assignment: &Assignment) -> Vec<Vector3<f64>> {
        let free = self.slots.get(self.pinned..).unwrap_or_default();
        let followers = self.starts.iter().skip(self.pinned);
        let ends = assignment
            .slots
            .iter()
            .zip(followers)
            .map(|(slot, start)| slot.and_then(|slot| free.get(slot)).copied().unwrap_or(*start));
        std::iter::repeat_n(Vector3::zeros(), self.pinned).chain(ends).collect()
    }
}

/// What came of the assignments tried so far.
#[derive(Default)]
pub(super) struct Tried {
    shortest: Option<(Ways, f64)>,
    pub best_failed_m: f64,
}

impl Tried {
    /// The ways into these ends with detours that keep the distance, and how long they take; none if there are none.
    pub fn resolve(&mut self, task: &Task, ends: Vec<Vector3<f64>>, keep: f64) -> Option<(Ways, f64)> {
        let mut ways = Ways::new(task, ends, keep);
        if !ways.resolve() {
            self.best_failed_m = self.best_failed_m.max(ways.min_distance_m());
            return None;
        }
        let duration_s = ways.longest_s(&task.abilities);
        Some((ways, duration_s))
    }

    /// Keeps the quicker.
    pub fn keep_shorter(&mut self, found: Option<(Ways, f64)>) {
        let Some((ways, duration_s)) = found else { return };
        let shorter = |(_, shortest_s): &(Ways, f64)| duration_s < shortest_s - 1e-9;
        if self.shortest.as_ref().is_none_or(shorter) {
            self.shortest = Some((ways, duration_s));
        }
    }

    /// The held slots unless others are much quicker.
    pub fn chosen(&mut self, kept: Option<(Ways, f64)>) -> Option<(Ways, f64)> {
        match (kept, self.shortest.take()) {
            (Some(kept), Some(shortest)) if kept.1 > HELD_MAY_TAKE * shortest.1 + 1e-9 => Some(shortest),
            (Some(kept), _) => Some(kept),
            (None, shortest) => shortest,
        }
    }
}
