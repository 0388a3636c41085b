//! The autopilot's own landing and return: asked for, watched, and over when the vehicle stands disarmed on the ground.
//!
//! Must never do: end the setpoint stream before the autopilot has taken the landing up. Its OFFBOARD-loss failsafe would be faster.

use crate::blend::Stop;
use crate::flight::{Asking, Flying, Landing, Phase, Plan, Purpose};
use crate::model::GenericUav;
use skein_domain::exchange::{OwnState, Severity};
use skein_domain::{AutopilotCommand, FlightMode, LandedState, Refusal};
use skein_plugin_sdk::Effects;

/// Disarmed in the air for this long is a fault, in seconds. The landed detector comes some tenths of a second after the disarming.
const LANDED_LAG_S: f64 = 3.0;

impl GenericUav {
    /// Hands over to the autopilot's landing, or to its return and landing.
    pub(crate) fn begin_landing(&mut self, returning: bool, detail: &str, out: &mut Effects) {
        let streaming = matches!(&self.flight.phase, Phase::Flying(_))
            || matches!(&self.flight.phase, Phase::Landing(l) if l.stop.is_some());
        let stop = if streaming { self.present_motion() } else { None };
        let stop = stop.map(|(motion, _)| {
            (
                Stop {
                    from: motion.position,
                    velocity: motion.velocity,
                },
                0.0,
            )
        });
        let landing = Landing {
            returning,
            asking: Asking::default(),
            accepted: false,
            since_s: self.flight.heard_s,
            stop,
            disarmed_since_s: None,
            overdue: false,
            leaving: None,
        };
        if streaming && stop.is_none() {
            self.stop_stream(out);
        }
        self.enter(Phase::Landing(landing), detail);
    }

    pub(crate) fn step_landing(&mut self, mut landing: Landing, own: &OwnState, dt_s: f64, out: &mut Effects) {
        if !own.armed {
            self.step_disarmed(landing, own, out);
            return;
        }
        landing.disarmed_since_s = None;
        let wanted: &[FlightMode] = if landing.returning {
            &[FlightMode::Return, FlightMode::Land]
        } else {
            &[FlightMode::Land]
        };
        if !landing.accepted && wanted.contains(&own.mode) {
            landing.accepted = true;
            landing.asking = Asking::default();
            if landing.stop.take().is_some() {
                self.stop_stream(out);
            }
        }
        if !landing.accepted {
            let command = if landing.returning {
                AutopilotCommand::ReturnToLaunch
            } else {
                AutopilotCommand::Land
            };
            let mut request = Effects::default();
            // That it was accepted shows in the mode.
            if let Some(Err(refusal)) = self.ask(&mut landing.asking, command, self.settings.attempts, &mut request) {
                self.landing_refused(&landing, refusal, own, dt_s, out);
                return;
            }
            if let Some((stop, elapsed_s)) = &mut landing.stop {
                *elapsed_s += dt_s;
                let motion = stop.sample(*elapsed_s, self.settings.acceleration_m_s2);
                let yaw_rad = self.flight.reference.and_then(|reference| reference.yaw_rad);
                self.stream(&motion, yaw_rad, None, out);
            }
            out.extend(request.take());
        }
        let waited_s = self.flight.heard_s - landing.since_s;
        if waited_s > self.settings.landing_timeout_s && !landing.overdue {
            landing.overdue = true;
            out.notice(
                Severity::Warning,
                format!("still not on the ground after {waited_s:.0} s of landing"),
            );
            self.command_refused(Refusal::timed_out("landing", waited_s), out);
        }
        self.flight.phase = Phase::Landing(landing);
    }

    /// Disarmed: on the ground, or about to be found there, or something is badly wrong.
    fn step_disarmed(&mut self, mut landing: Landing, own: &OwnState, out: &mut Effects) {
        if landing.stop.take().is_some() {
            self.stop_stream(out);
        }
        if matches!(own.landed, LandedState::OnGround) {
            if self.leaves_offboard(&mut landing, own, out) {
                self.flight.phase = Phase::Landing(landing);
                return;
            }
            self.enter(Phase::Idle, "landed");
            self.command_done(out);
            return;
        }
        let since_s = *landing.disarmed_since_s.get_or_insert(self.flight.heard_s);
        if self.flight.heard_s - since_s < LANDED_LAG_S {
            self.flight.phase = Phase::Landing(landing);
        } else if own.landed == LandedState::Unknown {
            self.enter(Phase::Idle, "disarmed");
            self.command_done(out);
        } else {
            out.notice(Severity::Critical, "disarmed in the air");
            self.enter(Phase::Faulted, "disarmed in the air");
            self.command_refused(
                Refusal::Autopilot {
                    result: "disarmed".to_owned(),
                    text: "in the air".to_owned(),
                },
                out,
            );
        }
    }

    /// A landing is over for whoever wants to take off again, though OFFBOARD is still being left: that is asked anew before arming.
    pub(crate) fn end_landing_on_the_ground(&mut self, out: &mut Effects) {
        let down = self
            .own
            .is_some_and(|own| !own.armed && own.landed == LandedState::OnGround);
        if down && matches!(&self.flight.phase, Phase::Landing(landing) if landing.stop.is_none()) {
            self.enter(Phase::Idle, "landed");
            self.command_done(out);
        }
    }

    /// After a landing out of OFFBOARD PX4 shows OFFBOARD again, and would not arm. Whether that mode is still being left; an autopilot
    /// that does not do it keeps nobody waiting: it is asked anew before arming.
    fn leaves_offboard(&mut self, landing: &mut Landing, own: &OwnState, out: &mut Effects) -> bool {
        if own.mode != FlightMode::Offboard {
            return false;
        }
        let mut asking = landing.leaving.take().unwrap_or_default();
        let hold = AutopilotCommand::SetMode { mode: FlightMode::Hold };
        let answer = self.ask(&mut asking, hold, self.settings.attempts, out);
        landing.leaving = Some(asking);
        !matches!(answer, Some(Err(_)))
    }

    fn landing_refused(&mut self, landing: &Landing, refusal: Refusal, own: &OwnState, dt_s: f64, out: &mut Effects) {
        out.notice(Severity::Critical, format!("the autopilot does not land: {refusal}"));
        if landing.stop.is_none() || own.mode != FlightMode::Offboard {
            self.lose_control(format!("landing refused: {refusal}"), out);
            return;
        }
        self.command_refused(refusal, out);
        let mut flying = Flying {
            purpose: Purpose::Hold { at: None },
            engaging: None,
            plan: Plan::Slot,
            elapsed_s: 0.0,
            blend: None,
            yaw_rad: self.flight.reference.and_then(|reference| reference.yaw_rad),
            after: None,
        };
        self.plan_from_here(&mut flying, out);
        self.flight.detail = "the autopilot does not land".to_owned();
        // In this very period, so that the stream has no gap.
        self.step_flying(flying, own, dt_s, out);
    }
}
