//! Where a formation stands whose reference leads it out of the fences: as far along as all its places are inside, until the reference leads
//! back.
//!
//! Must never do: bring a place outside that is inside. One that is outside already, for a fence that came later, holds nobody up.

use nalgebra::Vector3;
use skein_domain::{AccelerationNed, AnchorReference, OffsetFrd, PositionNed, VelocityNed};
use skein_safety::Fences;

/// How hard it stops and starts again, in metres per second squared: no harder than followers do with something to spare.
const ACCELERATION_M_S2: f64 = 2.0;
/// How much sooner than it must it begins to brake, in seconds: followers are a little late.
const EARLY_S: f64 = 0.5;
/// How much faster than the reference it comes after it when it may again, in metres per second.
const CATCH_UP_M_S: f64 = 3.0;
/// How fast it closes what is left to the reference, per second.
const CLOSING_PER_S: f64 = 0.6;
/// Nearer than this, in metres, and no more than this slower or faster, in metres per second, it is with the reference again.
const TOGETHER_M: f64 = 0.01;
const TOGETHER_M_S: f64 = 0.05;

/// What a formation needs room for.
#[derive(Debug, Clone, Copy)]
pub struct Room<'a> {
    /// What is closed.
    pub fences: &'a Fences,
    /// Its places about the anchor.
    pub places: &'a [OffsetFrd],
}

impl Room<'_> {
    /// How many of the places are outside, with the anchor here.
    pub fn outside(&self, position: &PositionNed, heading_rad: f64) -> usize {
        let is_outside = |place: &&OffsetFrd| {
            let there = position.moved(place.rotated(heading_rad));
            self.fences.contains(&there).is_err()
        };
        self.places.iter().filter(is_outside).count()
    }
}

/// The anchor between the reference and the fences.
#[derive(Debug, Clone, Default)]
pub struct Tether {
    /// Where the anchor is, once it is not where the reference is.
    apart: Option<(PositionNed, VelocityNed)>,
    /// The reference leads where not all may go.
    held: bool,
    before: Option<PositionNed>,
}

impl Tether {
    /// Whether the formation waits for its reference to come back.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.held
    }

    /// The anchor for a reference that is there now, `dt_s` after the last.
    pub fn lead(&mut self, wanted: AnchorReference, heading_rad: f64, room: &Room<'_>, dt_s: f64) -> AnchorReference {
        if room.fences.is_empty() {
            *self = Self::default();
            return wanted;
        }
        let here = self.apart.map(|(position, _)| position).or(self.before);
        let outside_now = here.map_or(usize::MAX, |here| room.outside(&here, heading_rad));
        self.held = room.outside(&where_it_stops(&wanted), heading_rad) > outside_now;
        if self.held && self.apart.is_none() {
            self.apart = self.before.map(|before| (before, wanted.velocity));
        }
        self.before = Some(wanted.position);
        let Some((position, velocity)) = self.apart else {
            return wanted;
        };
        let asked = if self.held {
            Vector3::zeros()
        } else {
            towards(&wanted, &position)
        };
        let change = (asked - velocity.vector()).cap_magnitude(ACCELERATION_M_S2 * dt_s);
        let velocity = velocity.vector() + change;
        let next = position.moved(velocity * dt_s);
        // What braking too late would still carry outside, or a way back that cuts a corner, is not flown.
        let (position, velocity) = if room.outside(&next, heading_rad) > outside_now {
            (position, Vector3::zeros())
        } else {
            (next, velocity)
        };
        self.apart = Some((position, velocity.into()));
        let off_m_s = (wanted.velocity.vector() - velocity).norm();
        if !self.held && wanted.position.distance_m(&position) < TOGETHER_M && off_m_s < TOGETHER_M_S {
            self.apart = None;
        }
        AnchorReference {
            position,
            velocity: velocity.into(),
            acceleration: AccelerationNed::default(),
            ..wanted
        }
    }
}

/// Where an anchor comes to stand that begins to brake now.
fn where_it_stops(anchor: &AnchorReference) -> PositionNed {
    let velocity = anchor.velocity.vector();
    let time_s = EARLY_S + 0.5 * velocity.norm() / ACCELERATION_M_S2;
    anchor.position.moved(velocity * time_s)
}

/// The velocity of an anchor that comes after its reference.
fn towards(wanted: &AnchorReference, position: &PositionNed) -> Vector3<f64> {
    let left = wanted.position.vector() - position.vector();
    // Slow enough to stop beside it.
    let most_m_s = CATCH_UP_M_S.min((ACCELERATION_M_S2 * left.norm()).sqrt());
    wanted.velocity.vector() + (left * CLOSING_PER_S).cap_magnitude(most_m_s)
}

#[cfg(test)]
mod tests;
