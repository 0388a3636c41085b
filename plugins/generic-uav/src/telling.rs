//! What others are told of a flight by setpoints: how far it is off, and a leader's anchor.
//!
//! Must never do: let a leader that is not heard look as if it were, or put what a vehicle takes against its own drag into an anchor.

use crate::blend::Motion;
use crate::flight::{Flying, Plan, Purpose};
use crate::model::GenericUav;
use crate::way::Sample;
use skein_domain::AnchorReference;
use skein_plugin_sdk::Effects;

/// A formation whose turning changes faster than this was stopped or begun at once: that is no acceleration to be flown, in radians per
/// second squared.
const TURNING_CHANGE_MAX_RAD_S2: f64 = 1.0;

/// A leader is where its reference is if it is no farther from it than this, in metres.
const REFERENCE_WITHIN_M: f64 = 2.0;
/// From what is measured to the reference it takes so long, in seconds, and back.
const FADE_S: f64 = 2.0;

impl GenericUav {
    /// What others want to know of this flight.
    pub(crate) fn publish(
        &mut self,
        flying: &Flying,
        sample: &Sample,
        reference: &Motion,
        turning_rad_s2: f64,
        dt_s: f64,
        out: &mut Effects,
    ) {
        let Some(here) = self.measured() else { return };
        if !matches!(flying.purpose, Purpose::Lead(_)) {
            self.flight.told_reference = 0.0;
        }
        let goal = flying.purpose.goal().unwrap_or(sample.motion.position);
        let distance_m = match (&flying.purpose, &flying.plan) {
            (_, Plan::Kept(kept)) => kept.error_m,
            (Purpose::LandAt { .. } | Purpose::Home { .. }, _) => here.position.horizontal_distance_m(&goal),
            _ => here.position.distance_m(&goal),
        };
        self.tell_distance(distance_m, out);
        // Followers must see that a leader which is not heard is not heard.
        if let Purpose::Lead(lead) = &flying.purpose
            && !self.flight.link_lost
        {
            let held_back = self.flight.gate_refusal.is_some();
            let told = self.told_of_leader(&here, reference, held_back, dt_s);
            out.anchor(AnchorReference {
                position: told.position,
                velocity: told.velocity,
                acceleration: if held_back {
                    Default::default()
                } else {
                    reference.acceleration
                },
                heading_rad: lead.heading_rad,
                heading_rate_rad_s: lead.heading_rate_rad_s,
                heading_acceleration_rad_s2: turning_rad_s2,
                // Not the present, if it is not heard any more: its followers then carry it on as it was, instead of seeing it stop.
                time: self.now.plus_seconds(-self.not_heard_s()),
            });
        }
    }

    /// Where followers are told that their leader is: where its reference is, as long as it is there, so that they do not repeat how it lags
    /// and sways; else where it is measured. From one to the other it fades.
    fn told_of_leader(&mut self, here: &Motion, reference: &Motion, held_back: bool, dt_s: f64) -> Motion {
        // What is not heard any more is told as of when it was heard last: the reference, too.
        let late_s = self.not_heard_s();
        let then = reference.position.after(&reference.velocity, -late_s);
        let ahead = then.vector() - here.position.vector();
        let is_there = !held_back && late_s <= 0.0 && ahead.norm() < REFERENCE_WITHIN_M;
        let before = self.flight.told_reference;
        let step = if is_there { dt_s / FADE_S } else { -dt_s / FADE_S };
        let share = (before + step).clamp(0.0, 1.0);
        // Also what was saved by something that is no number.
        let share = if share.is_finite() { share } else { 0.0 };
        self.flight.told_reference = share;
        let faster = reference.velocity.vector() - here.velocity.vector();
        let fading = if dt_s > 0.0 { (share - before) / dt_s } else { 0.0 };
        Motion {
            position: here.position.moved(ahead * share),
            velocity: (here.velocity.vector() + faster * share + ahead * fading).into(),
            acceleration: reference.acceleration,
        }
    }

    /// A goal may be farther than numbers go.
    pub(crate) fn tell_distance(&self, distance_m: f64, out: &mut Effects) {
        if distance_m.is_finite() {
            out.tracking_error(distance_m);
        }
    }
}

/// How a formation's turning changed over a period, in radians per second squared.
pub(crate) fn change_of_turning_rad_s2(before_rad_s: f64, after_rad_s: f64, dt_s: f64) -> f64 {
    let change = (after_rad_s - before_rad_s) / dt_s;
    if dt_s > 0.0 && change.abs() <= TURNING_CHANGE_MAX_RAD_S2 {
        change
    } else {
        0.0
    }
}

impl Purpose {
    /// How fast a formation is turned in it, in radians per second.
    pub(crate) fn turning_rad_s(&self) -> f64 {
        match self {
            Self::Lead(lead) => lead.heading_rate_rad_s,
            _ => 0.0,
        }
    }
}
