//! The change from one formation into another: who takes which slot, on which way, over which time, with a verified distance
//! between any two vehicles over the whole move.
//!
//! All members move on one common time law, so that what two of them do relative to each other depends on the share of the way
//! alone, and a distance can be verified once, whatever the speed and however the formation as a whole moves and turns.

mod clearance;
mod detour;
mod pace;
mod task;

use crate::assignment;
use crate::formation::FormationError;
use crate::time_law::{bump_over_time, progress};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use skein_domain::{FlightLimits, NodeTime, OffsetFrd, SlotMove};
use skein_safety::avoidance::AvoidanceSettings;
use task::{Task, Tried, check};

/// What the vehicles can do and how close they may come, for a transition.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MotionLimits {
    /// Largest speed relative to the leader in metres per second.
    pub speed_m_s: f64,
    /// Largest acceleration relative to the leader in metres per second squared.
    pub acceleration_m_s2: f64,
    /// Largest climb and descent rate in metres per second.
    pub climb_m_s: f64,
    /// Smallest distance between any two vehicles on the way in metres.
    pub min_distance_m: f64,
}

/// A planned transition.
#[derive(Debug, Clone, PartialEq)]
pub struct TransitionPlan {
    /// Each member's way, in the order in which the members were given.
    pub moves: Vec<SlotMove>,
    /// How long all of them take, in seconds.
    pub duration_s: f64,
    /// Smallest distance between any two members over the whole move in metres (infinite for one alone). It is below the asked
    /// one only if two members start or end closer than a quarter above it; then they come no more than a fifth closer than that.
    pub min_distance_m: f64,
}

/// Where a slot is now, relative to the anchor, in the formation's own turning axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlotSample {
    /// The offset.
    pub offset: OffsetFrd,
    /// Its rate of change along forward, right and down in metres per second.
    pub velocity: Vector3<f64>,
    /// The second rate of change in metres per second squared.
    pub acceleration: Vector3<f64>,
}

/// A change of formation to be planned. Offsets of both lists are relative to the new heading.
#[derive(Debug, Clone, Copy)]
pub struct Change<'a> {
    /// Where the members are. With a leader it is the first; it stays at zero offset.
    pub from: &'a [OffsetFrd],
    /// Where slots are; at least as many. With a leader the first is its own, at zero. The others' order does not matter.
    pub slots: &'a [OffsetFrd],
    /// What all of them keep to.
    pub limits: MotionLimits,
    /// What each can do beside that, in the order of `from`; none if all are alike.
    pub able: &'a [FlightLimits],
    /// How much of each one's speed the formation itself takes, in metres per second: its leader's speed and its turning.
    pub taken_m_s: f64,
    /// Whether the first member is a leader. Without one the anchor is no vehicle, and every member is given a slot.
    pub led: bool,
    /// The slot that each member has now, in the order of `from`, where the shape stays the same and only its parameters change:
    /// then everyone keeps it, unless the move cannot be flown so, or takes much longer than with others. See [`held_slots`].
    pub held: Option<&'a [usize]>,
    /// What keeps them apart in flight, if anything does: the change takes as long as it takes so that it has nothing to change.
    pub filter: Option<&'a AvoidanceSettings>,
    /// No detour leads lower than this below the anchor, in metres; none if there is room.
    pub lowest_down_m: Option<f64>,
}

impl<'a> Change<'a> {
    /// Members that are all alike, behind a leader.
    #[must_use]
    pub fn new(from: &'a [OffsetFrd], slots: &'a [OffsetFrd], limits: &MotionLimits) -> Self {
        Self {
            from,
            slots,
            limits: *limits,
            able: &[],
            taken_m_s: 0.0,
            led: true,
            held: None,
            filter: None,
            lowest_down_m: None,
        }
    }

    /// Plans the way of all members into the slots.
    ///
    /// # Errors
    /// [`FormationError`] for lists that do not fit, numbers that are not usable, or if no way keeps the distance.
    pub fn plan(&self, start: NodeTime) -> Result<TransitionPlan, FormationError> {
        check(self)?;
        let task = Task::new(self);
        let mut tried = Tried::default();
        for keep in [1.0, RELAXED_SHARE] {
            let kept = task.held_ends().and_then(|ends| tried.resolve(&task, ends, keep));
            for ends in task.candidates() {
                let found = tried.resolve(&task, ends, keep);
                tried.keep_shorter(found);
            }
            if let Some((ways, least_s)) = tried.chosen(kept) {
                let duration_s = self
                    .filter
                    .map_or(least_s, |filter| pace::duration_s(&ways, filter, least_s));
                return Ok(TransitionPlan {
                    moves: ways.moves(start, duration_s),
                    duration_s,
                    min_distance_m: ways.min_distance_m(),
                });
            }
        }
        Err(FormationError::NoSafeTransition {
            best_m: tried.best_failed_m,
            limit_m: self.limits.min_distance_m,
        })
    }
}

/// Which of the former slots each member is in or on its way to: who is where, whatever the order of the lists.
#[must_use]
pub fn held_slots(from: &[OffsetFrd], former: &[OffsetFrd]) -> Vec<usize> {
    assignment::assign(from, former)
}

/// [`Change::plan`] for members that are all alike behind their leader.
///
/// # Errors
/// As [`Change::plan`].
pub fn plan(
    from: &[OffsetFrd],
    slots: &[OffsetFrd],
    limits: &MotionLimits,
    start: NodeTime,
) -> Result<TransitionPlan, FormationError> {
    Change::new(from, slots, limits).plan(start)
}

/// Two members that start or end nearly as close as allowed cannot but come a little closer on most ways; this share of their
/// distance at the ends must remain if nothing better is found.
const RELAXED_SHARE: f64 = 0.8;

/// Where the slot is at `now`: at its start before the move, at its end after it. Numbers that are not finite come out as such.
#[must_use]
pub fn sample(slot: &SlotMove, now: NodeTime) -> SlotSample {
    let (from, to) = (slot.from.vector(), slot.to.vector());
    let t_s = now.seconds_since(slot.start);
    // Written so that a duration that is not a number is over.
    let moving = t_s < slot.duration_s;
    if t_s <= 0.0 || !moving {
        let offset = if moving { slot.from } else { slot.to };
        return SlotSample {
            offset,
            velocity: Vector3::zeros(),
            acceleration: Vector3::zeros(),
        };
    }
    let s = progress(t_s, slot.duration_s);
    let b = bump_over_time(s);
    let (way, lift) = (to - from, Vector3::new(0.0, 0.0, -slot.detour_up_m));
    SlotSample {
        offset: (from + way * s.value + lift * b.value).into(),
        velocity: way * s.first + lift * b.first,
        acceleration: way * s.second + lift * b.second,
    }
}

#[cfg(test)]
mod tests;
