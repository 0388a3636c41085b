//! Who flies: noticing that a pilot or the autopilot's own failsafe has taken over, that the autopilot restarted, that a vehicle in
//! nobody's control is on the ground again.
//!
//! Must never do: take the vehicle back without an operator's command.

use crate::flight::Phase;
use crate::model::{GenericUav, is_airborne};
use skein_domain::exchange::{OwnState, Severity};
use skein_domain::{FlightMode, LandedState, Refusal};
use skein_plugin_sdk::Effects;

/// Why a vehicle on the ground is idle when it is armed.
pub(crate) const ARMED: &str = "armed";

impl GenericUav {
    /// Whether the autopilot is in a mode that this phase has not asked for.
    pub(crate) fn watch_modes(&mut self, own: &OwnState, out: &mut Effects) {
        // Disarmed it is under nobody's control. After a landing out of OFFBOARD it shows OFFBOARD again, unasked.
        if !own.armed {
            return;
        }
        let unasked = &self.flight.unasked_modes;
        let unasked_but = |expected: &[FlightMode]| unasked.iter().map(|(_, to)| *to).find(|to| !expected.contains(to));
        let other_than = |expected: &[FlightMode]| {
            let other = own.mode != FlightMode::Unknown && !expected.contains(&own.mode);
            other.then_some(own.mode)
        };
        let by_whom = match &self.flight.phase {
            Phase::Flying(flying) if flying.engaging.is_none() => {
                let left = unasked
                    .iter()
                    .find(|(from, _)| *from == FlightMode::Offboard)
                    .map(|(_, to)| *to);
                left.or_else(|| other_than(&[FlightMode::Offboard]))
            }
            Phase::Flying(_) => unasked_but(&[FlightMode::Offboard, FlightMode::Hold, FlightMode::TakeOff]),
            Phase::TakingOff(taking_off) if taking_off.accepted => {
                unasked_but(&[FlightMode::TakeOff, FlightMode::Hold])
            }
            Phase::Landing(landing) if landing.accepted => {
                let expected: &[FlightMode] = if landing.returning {
                    &[FlightMode::Return, FlightMode::Land, FlightMode::Descend]
                } else {
                    &[FlightMode::Land, FlightMode::Descend]
                };
                unasked_but(expected).or_else(|| other_than(expected))
            }
            _ => None,
        };
        if let Some(mode) = by_whom {
            self.lose_control(format!("mode {mode}"), out);
        }
    }

    /// The vehicle is in a pilot's or the autopilot's own control.
    pub(crate) fn lose_control(&mut self, detail: String, out: &mut Effects) {
        self.stop_stream(out);
        self.command_refused(Refusal::PilotInControl, out);
        if let Some(waiting) = self.flight.waiting.take() {
            out.refused(waiting.id, Refusal::PilotInControl);
        }
        let text = format!("the pilot or the autopilot's failsafe is in control ({detail})");
        out.notice(Severity::Warning, text);
        self.enter(Phase::PilotControl, detail);
    }

    /// Out of our control until an operator says otherwise, or it is on the ground.
    pub(crate) fn step_pilot_control(&mut self, own: &OwnState) {
        let on_ground = matches!(own.landed, LandedState::OnGround | LandedState::Unknown);
        if !own.armed && on_ground {
            self.enter(Phase::Idle, "");
        } else {
            self.flight.phase = Phase::PilotControl;
        }
    }

    /// On the ground. Who flies off without being told flies under someone else's control.
    pub(crate) fn step_idle(&mut self, own: &OwnState, out: &mut Effects) {
        self.flight.phase = Phase::Idle;
        if !own.armed && self.flight.detail == ARMED {
            self.flight.detail.clear(); // The autopilot disarms by itself after a while.
        }
        if is_airborne(own) && own.landed != LandedState::Unknown {
            self.lose_control("took off without being told".to_owned(), out);
        }
    }

    /// The autopilot restarted: whatever it was told is forgotten.
    pub(crate) fn rebooted(&mut self, out: &mut Effects) {
        let on_ground = matches!(self.flight.phase, Phase::Idle | Phase::Arming(_) | Phase::Disarming(_));
        // As last seen before the restart.
        let flying = !on_ground && self.own.is_none_or(|own| is_airborne(&own));
        self.stop_stream(out);
        let refusal = Refusal::Autopilot {
            result: "restarted".to_owned(),
            text: String::new(),
        };
        self.command_refused(refusal.clone(), out);
        if let Some(waiting) = self.flight.waiting.take() {
            out.refused(waiting.id, refusal);
        }
        if flying {
            out.notice(Severity::Critical, "the autopilot restarted in flight");
            self.enter(Phase::Faulted, "the autopilot restarted in flight");
        } else {
            self.enter(Phase::Idle, "the autopilot restarted");
        }
    }
}
