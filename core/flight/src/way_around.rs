//! The shortest safe way between two places around, over or under volumes where nothing may fly.
//!
//! A way is looked for at each height that is of use: those of its two ends, and just over and just under each zone. At one height it is
//! the shortest way in the plane about the corners of the zones in the way, and of the boundary around it. Only zones that are really
//! met are looked at.

mod corners;
mod plane;
mod profile;

use skein_domain::{PositionNed, Refusal};
use skein_safety::{Clearance, Fences};
use thiserror::Error;

/// Why there is no way.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NoWay {
    /// The start or the goal is not finite, or the clearance not usable.
    #[error("{what} must be finite and not below zero")]
    Invalid {
        /// Which of them.
        what: &'static str,
    },
    /// The start is not where a vehicle may be.
    #[error("the start is not inside: {refusal}")]
    Start {
        /// Why.
        refusal: Refusal,
    },
    /// The goal is not where a vehicle may be.
    #[error("the goal is not inside: {refusal}")]
    Goal {
        /// Why.
        refusal: Refusal,
    },
    /// Zones close the way.
    #[error("no way around \"{zone}\"")]
    Blocked {
        /// The zone that is in the straight way.
        zone: String,
    },
    /// There may be a way, but it takes too long to look for it.
    #[error("the way around \"{zone}\" has too many corners to be looked for")]
    TooIntricate {
        /// The zone that is in the straight way.
        zone: String,
    },
}

impl From<NoWay> for Refusal {
    fn from(reason: NoWay) -> Self {
        match reason {
            NoWay::Invalid { .. } => Self::InvalidValue {
                detail: reason.to_string(),
            },
            _ => Self::OutsideFence {
                detail: reason.to_string(),
            },
        }
    }
}

/// A way that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct WayAround {
    /// Where to go, in order; the last is the goal, the start is left out.
    pub waypoints: Vec<PositionNed>,
    /// Its length in metres.
    pub length_m: f64,
    /// The share of the asked clearance that each leg keeps: one, but less on legs that begin or end where there is less.
    pub clearance_shares: Vec<f64>,
}

/// More places than this are not looked at: about thirty zones of ten corners in one way.
const MAX_PLACES: usize = 400;
/// An end that is nearer to a boundary than asked keeps this share of the distance that it has.
const KEPT_AT_ENDS: f64 = 0.95;

/// What a search goes by.
struct Task<'a> {
    fences: &'a Fences,
    start: PositionNed,
    goal: PositionNed,
    clearance: Clearance,
    /// Shares of the clearance that start and goal themselves have.
    start_share: f64,
    goal_share: f64,
}

impl Task<'_> {
    /// Whether a leg is inside and keeps a share of the clearance.
    fn is_clear(&self, from: &PositionNed, to: &PositionNed, share: f64) -> bool {
        let clearance = self.clearance.scaled(share);
        self.fences.keeps_clearance(from, to, &clearance).is_ok()
    }

    /// The way along these places with the share of the clearance that each has, the start being the first of them, if all of its
    /// legs are clear.
    fn way(&self, places: &[(PositionNed, f64)]) -> Option<WayAround> {
        let mut way = WayAround {
            waypoints: Vec::new(),
            length_m: 0.0,
            clearance_shares: Vec::new(),
        };
        for ((from, from_share), (to, to_share)) in places.iter().zip(places.iter().skip(1)) {
            let share = from_share.min(*to_share);
            if !self.is_clear(from, to, share) {
                return None;
            }
            way.length_m += from.distance_m(to);
            way.waypoints.push(*to);
            way.clearance_shares.push(share);
        }
        Some(way)
    }
}

/// The shortest way found from a place to another that is inside and keeps a clearance from all boundaries. An end that has less than
/// the clearance itself does not prevent a way: the leg there keeps nearly what the end has.
///
/// # Errors
/// [`NoWay`], which names the zone in the way.
pub fn way_around(
    fences: &Fences,
    start: &PositionNed,
    goal: &PositionNed,
    clearance: &Clearance,
) -> Result<WayAround, NoWay> {
    check(start, goal, clearance)?;
    fences.contains(start).map_err(|refusal| NoWay::Start { refusal })?;
    fences.contains(goal).map_err(|refusal| NoWay::Goal { refusal })?;
    let task = Task {
        fences,
        start: *start,
        goal: *goal,
        clearance: *clearance,
        start_share: kept_share(fences, start, clearance),
        goal_share: kept_share(fences, goal, clearance),
    };
    if let Some(straight) = task.way(&[(*start, task.start_share), (*goal, task.goal_share)]) {
        return Ok(straight);
    }
    let mut best: Option<WayAround> = None;
    let mut gave_up = false;
    for band in profile::bands(&task) {
        // No way at this height can be shorter than straight up, over and down.
        let least_m = profile::least_m(&task, &band);
        if best.as_ref().is_some_and(|way| way.length_m <= least_m) {
            continue;
        }
        match plane::shortest(&task, &band) {
            Ok(Some(path)) => {
                let way = profile::flown(&task, &band, &path);
                best = shorter(best, way);
            }
            Ok(None) => {}
            Err(plane::GaveUp) => gave_up = true,
        }
    }
    best.ok_or_else(|| {
        let zone = in_the_way(&task);
        if gave_up {
            NoWay::TooIntricate { zone }
        } else {
            NoWay::Blocked { zone }
        }
    })
}

fn check(start: &PositionNed, goal: &PositionNed, clearance: &Clearance) -> Result<(), NoWay> {
    let usable = |value: f64| value >= 0.0 && value.is_finite();
    for (what, holds) in [
        ("the start", start.is_finite()),
        ("the goal", goal.is_finite()),
        (
            "the clearance",
            usable(clearance.horizontal_m) && usable(clearance.vertical_m),
        ),
    ] {
        if !holds {
            return Err(NoWay::Invalid { what });
        }
    }
    Ok(())
}

/// How much of the clearance a place has: all of it, or nearly what there is.
fn kept_share(fences: &Fences, place: &PositionNed, clearance: &Clearance) -> f64 {
    let keeps = |share: f64| fences.keeps_clearance(place, place, &clearance.scaled(share)).is_ok();
    if keeps(1.0) {
        return 1.0;
    }
    let (mut kept, mut not_kept) = (0.0, 1.0);
    for _ in 0..20 {
        let middle = 0.5 * (kept + not_kept);
        if keeps(middle) {
            kept = middle;
        } else {
            not_kept = middle;
        }
    }
    kept * KEPT_AT_ENDS
}

fn shorter(best: Option<WayAround>, other: Option<WayAround>) -> Option<WayAround> {
    match (best, other) {
        (Some(a), Some(b)) => Some(if b.length_m < a.length_m { b } else { a }),
        (a, b) => a.or(b),
    }
}

/// The zone that the straight way meets.
fn in_the_way(task: &Task) -> String {
    let clearance = task.clearance.scaled(task.start_share.min(task.goal_share));
    let crossed = task.fences.crossed(&task.start, &task.goal);
    let zone = crossed.or_else(|| task.fences.too_near(&task.start, &task.goal, &clearance));
    zone.or_else(|| task.fences.zones().first())
        .map_or_else(String::new, |zone| zone.name.clone())
}

#[cfg(test)]
mod tests;
