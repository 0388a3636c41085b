//! One control period of a flight by setpoints: engage, advance, stream, see whether the purpose is fulfilled.
//!
//! Must never do: move the reference on while the gate refuses it, or jump after a pause.

use crate::blend::Motion;
use crate::flight::{Fly, Flying, Lead, Phase, Plan, Purpose};
use crate::keeping::turned_towards;
use crate::model::{GenericUav, LONGEST_STEP_S};
use crate::tasks::age_s;
use crate::telling::change_of_turning_rad_s2;
use crate::way::{Sample, Track};
use skein_domain::exchange::{OwnState, Severity};
use skein_domain::{AutopilotCommand, FlightMode, LandedState, PositionNed, Refusal};
use skein_plugin_sdk::Effects;

/// A vehicle slower than this stands, in metres per second.
const STANDS_M_S: f64 = 0.5;
/// How long a stopped vehicle may take to stand, in seconds.
const STOP_SETTLE_S: f64 = 5.0;
impl GenericUav {
    pub(crate) fn step_flying(&mut self, mut flying: Flying, own: &OwnState, dt_s: f64, out: &mut Effects) {
        if flying.engaging.is_some() {
            self.see_whether_answered(&mut flying);
            if flying.after.is_some() || own.mode != FlightMode::Offboard {
                self.step_engaging(flying, own, out);
                return;
            }
            self.engaged(&mut flying, out);
        }
        if !own.armed && !self.flight.link_lost {
            if own.landed != LandedState::OnGround && self.is_just_heard_again() {
                if self.flight.reference.is_some() {
                    self.stop_stream(out);
                }
                self.flight.phase = Phase::Flying(flying);
                return;
            }
            self.ended_without_landing(own, out);
            return;
        }
        let turned_rad_s = flying.purpose.turning_rad_s();
        self.advance(&mut flying, dt_s, out);
        let sample = self.sample(&flying, self.now);
        if let Purpose::Lead(lead) = &mut flying.purpose {
            lead.turn(sample.course_rad, dt_s, &self.settings);
        }
        let turning_rad_s2 = change_of_turning_rad_s2(turned_rad_s, flying.purpose.turning_rad_s(), dt_s);
        if matches!(flying.purpose, Purpose::Fly(_))
            && let (Some(yaw_rad), Some(course_rad)) = (flying.yaw_rad, sample.course_rad)
        {
            flying.yaw_rad = Some(turned_towards(yaw_rad, course_rad, dt_s));
        }
        flying.blend = flying.blend.map(|blend| blend.hastened(&sample.motion, &self.settings));
        let motion = flying.blend.map_or(sample.motion, |blend| blend.apply(&sample.motion));
        let (yaw_rad, yaw_rate_rad_s) = flying.yaw(sample.yaw);
        self.stream(&motion, yaw_rad, yaw_rate_rad_s, out);
        self.publish(&flying, &sample, &motion, turning_rad_s2, dt_s, out);
        self.flight.phase = Phase::Flying(flying.clone());
        if !self.flight.link_lost {
            self.see_whether_done(flying, &sample, out);
        }
    }

    /// Streams where the vehicle is, so that the autopilot enters OFFBOARD without a jump, and asks for it.
    fn step_engaging(&mut self, mut flying: Flying, own: &OwnState, out: &mut Effects) {
        let measured = self.measured().map(|m| m.position);
        let place = match flying.purpose {
            Purpose::TakeOff { hold } => Some(hold),
            _ => measured,
        };
        let Some(place) = place else {
            self.not_engaged(&flying, Refusal::NoPosition, out);
            return;
        };
        let mut request = Effects::default();
        if let Some(asking) = &mut flying.engaging
            && flying.after.is_none()
            && !self.flight.link_lost
        {
            let offboard = AutopilotCommand::EnterOffboard;
            if let Some(Err(refusal)) = self.ask(asking, offboard, self.settings.attempts, &mut request) {
                self.not_engaged(&flying, refusal, out);
                return;
            }
        }
        let yaw_rad = own.kinematics.map(|k| k.yaw_rad).or(flying.yaw_rad);
        self.stream(
            &Motion {
                position: place,
                ..Motion::default()
            },
            yaw_rad,
            None,
            out,
        );
        if let (Some(here), Some(goal)) = (measured, flying.purpose.goal()) {
            self.tell_distance(here.distance_m(&goal), out);
        }
        // After the first setpoint: no mode change may come before the stream.
        out.extend(request.take());
        self.flight.phase = Phase::Flying(flying);
    }

    /// A mode that was asked for just before may still come: until that is known, OFFBOARD now says nothing of a moment later.
    fn see_whether_answered(&self, flying: &mut Flying) {
        let over = |made_s: f64| self.flight.heard_s - made_s > self.settings.request_timeout_s;
        flying
            .after
            .take_if(|(request, made_s)| self.result_of(*request).is_some() || over(*made_s));
    }

    /// The autopilot obeys from now on: the way begins where the vehicle is now.
    fn engaged(&mut self, flying: &mut Flying, out: &mut Effects) {
        flying.engaging = None;
        self.flight.reference = None;
        if let Purpose::TakeOff { hold } = flying.purpose {
            flying.purpose = Purpose::Hold { at: Some(hold) };
            self.flight.detail.clear();
            self.command_done(out);
        }
        flying.purpose.steered_from_here(self.now);
        self.plan_from_here(flying, out);
    }

    /// The autopilot does not enter OFFBOARD: it goes on by itself, and a return is left to it.
    fn not_engaged(&mut self, flying: &Flying, refusal: Refusal, out: &mut Effects) {
        out.notice(
            Severity::Warning,
            format!("the autopilot does not enter OFFBOARD: {refusal}"),
        );
        self.stop_stream(out);
        if matches!(flying.purpose, Purpose::Home { .. }) {
            // No setpoint stream from here on: the phase is no flight by setpoints any more.
            self.flight.phase = Phase::PilotControl;
            self.begin_landing(true, "by the autopilot: OFFBOARD was refused", out);
            return;
        }
        self.command_refused(refusal.clone(), out);
        self.enter(Phase::PilotControl, format!("OFFBOARD refused: {refusal}"));
    }

    /// Disarmed while flying by setpoints: set down by hand or worse.
    fn ended_without_landing(&mut self, own: &OwnState, out: &mut Effects) {
        self.stop_stream(out);
        let text = "while flying by setpoints".to_owned();
        self.command_refused(
            Refusal::Autopilot {
                result: "disarmed".to_owned(),
                text,
            },
            out,
        );
        if own.landed == LandedState::OnGround {
            self.enter(Phase::Idle, "disarmed");
        } else {
            out.notice(Severity::Critical, "disarmed in the air");
            self.enter(Phase::Faulted, "disarmed in the air");
        }
    }

    /// Moves on along the plan, unless the gate refused the last setpoint; mends the reference after a pause.
    fn advance(&mut self, flying: &mut Flying, dt_s: f64, out: &mut Effects) {
        let held_back = self.flight.gate_refusal.is_some();
        if held_back {
            self.flight.refused_for_s += dt_s;
        } else if std::mem::take(&mut self.flight.refused_for_s) > LONGEST_STEP_S {
            self.flight.reference = None; // The vehicle was held elsewhere.
        }
        if self.has_run_ahead(flying) {
            self.flight.reference = None; // From where it is, and as it moves.
        }
        let anchored = matches!(flying.plan, Plan::Slot);
        if matches!(flying.purpose, Purpose::Follow(_)) && anchored != self.usable_anchor(flying).is_some() {
            self.anchor_came_or_went(flying, out);
        } else if self.fresh_reference().is_none() && flying.purpose.moves_its_reference() {
            self.plan_from_here(flying, out);
        } else if self.fresh_reference().is_none()
            && let Some(have) = self.measured()
        {
            self.blend_in(flying, &have, self.now);
        }
        if held_back && self.flight.refused_for_s > LONGEST_STEP_S && flying.purpose.moves_its_reference() {
            // Where the gate stops it depends on the goal, which moves: tried again from where it is, at rest.
            self.flight.reference = None;
            self.plan_from_here(flying, out);
        }
        self.step_steering(flying, dt_s, held_back);
        if !held_back {
            self.step_guided(&mut flying.plan, &flying.purpose, dt_s);
            self.step_keeping(flying, dt_s, out);
            flying.elapsed_s += dt_s;
            flying.blend.take_if(|blend| !blend.advance(dt_s));
        }
    }

    fn anchor_came_or_went(&mut self, flying: &mut Flying, out: &mut Effects) {
        let went = matches!(flying.plan, Plan::Slot);
        self.plan_from_here(flying, out);
        let age = self
            .flight
            .anchor
            .map_or(f64::INFINITY, |anchor| age_s(&anchor, self.now));
        if went {
            let text = format!("nothing from the leader for {age:.1} s: holding");
            out.notice(Severity::Warning, text);
            self.flight.detail = "nothing from the leader: holding".to_owned();
        } else {
            self.flight.detail.clear();
        }
    }

    /// Whether what the flight is for is the case, or cannot become so.
    fn see_whether_done(&mut self, flying: Flying, sample: &Sample, out: &mut Effects) {
        if let Some(refusal) = self.flight.gate_refusal.clone()
            && self.flight.refused_for_s > self.settings.refusal_patience_s
        {
            self.refused_for_long(flying, refusal, out);
            return;
        }
        let at_end = sample.finished && flying.blend.is_none();
        match &flying.purpose {
            Purpose::TakeOff { .. } | Purpose::Follow(_) | Purpose::Guided(_) | Purpose::Keep(_) => {}
            Purpose::Steer(_) => self.see_whether_let_go(flying, out),
            Purpose::Lead(lead) if lead.steered.is_some() => self.see_whether_let_go(flying, out),
            Purpose::Fly(fly) => {
                if at_end && !fly.finished {
                    out.route_finished();
                    let purpose = Purpose::Fly(Fly {
                        finished: true,
                        ..fly.clone()
                    });
                    self.enter(
                        Phase::Flying(Flying { purpose, ..flying }),
                        "at the end of its trajectory",
                    );
                }
            }
            Purpose::Hold { .. } => self.see_whether_stopped(&flying, at_end, out),
            Purpose::GoTo { .. } => self.see_whether_arrived(flying, at_end, out),
            Purpose::LandAt { .. } | Purpose::Home { .. } => self.see_whether_settled(&flying, at_end, out),
            Purpose::Lead(lead) => {
                if at_end && matches!(flying.plan, Plan::Route { .. }) && !lead.finished {
                    out.route_finished();
                    let purpose = Purpose::Lead(Lead {
                        finished: true,
                        ..lead.clone()
                    });
                    self.flight.phase = Phase::Flying(Flying { purpose, ..flying });
                }
            }
        }
    }

    fn see_whether_stopped(&mut self, flying: &Flying, at_end: bool, out: &mut Effects) {
        let stands = self.measured().is_some_and(|here| here.velocity.norm() < STANDS_M_S);
        if at_end && (stands || self.overdue_s(flying) > STOP_SETTLE_S) {
            self.command_done(out);
        }
    }

    fn see_whether_arrived(&mut self, flying: Flying, at_end: bool, out: &mut Effects) {
        let (Purpose::GoTo { to, .. }, Some(here)) = (&flying.purpose, self.measured()) else {
            return;
        };
        let to = *to;
        let near = here.position.distance_m(&to) <= self.settings.goal_radius_m;
        let late = self.overdue_s(&flying) > self.settings.goal_timeout_s;
        if at_end && near && here.velocity.norm() < STANDS_M_S {
            self.command_done(out);
        } else if late {
            let refusal = Refusal::timed_out("arrival", flying.elapsed_s);
            self.command_refused(refusal, out);
        } else {
            return;
        }
        self.lay_out(
            Flying {
                purpose: Purpose::Hold { at: Some(to) },
                ..flying
            },
            "",
            out,
        );
    }

    fn see_whether_settled(&mut self, flying: &Flying, at_end: bool, out: &mut Effects) {
        let (Some(place), Some(here)) = (flying.purpose.goal(), self.measured()) else {
            return;
        };
        let off_m = here.position.horizontal_distance_m(&place);
        let near = off_m <= self.settings.landing_settle_radius_m;
        let slow = here.velocity.norm() <= self.settings.landing_settle_speed_m_s;
        let late = self.overdue_s(flying) > self.settings.landing_settle_timeout_s;
        if at_end && near && slow {
            self.begin_landing(false, "", out);
        } else if late {
            out.notice(
                Severity::Advisory,
                format!("lands {off_m:.1} m off its spot: it does not settle"),
            );
            self.begin_landing(false, "", out);
        }
    }

    /// For how long the end of the plan has been over, in seconds.
    fn overdue_s(&self, flying: &Flying) -> f64 {
        flying.elapsed_s - self.plan_duration_s(flying)
    }

    /// How long the present plan takes in seconds.
    fn plan_duration_s(&self, flying: &Flying) -> f64 {
        match (&flying.plan, &self.track) {
            (Plan::Stop(stop), _) => stop.duration_s(self.settings.acceleration_m_s2),
            (_, Some(Track::Straight(way))) => way.duration_s(),
            (_, Some(Track::Route(way))) => way.duration_s(),
            _ => 0.0,
        }
    }

    /// The gate does not let the vehicle on. A commanded flight ends here; a formation may yet get free.
    fn refused_for_long(&mut self, flying: Flying, refusal: Refusal, out: &mut Effects) {
        match &flying.purpose {
            Purpose::GoTo { .. } | Purpose::LandAt { .. } | Purpose::Home { .. } => {
                out.notice(Severity::Warning, format!("flight broken off: {refusal}"));
                self.command_refused(refusal.clone(), out);
                self.flight.reference = None;
                self.flight.refused_for_s = 0.0;
                let purpose = Purpose::Hold { at: None };
                self.lay_out(
                    Flying { purpose, ..flying },
                    format!("held back: {refusal}").as_str(),
                    out,
                );
            }
            _ => {
                // Said once, and again after as long.
                out.notice(Severity::Warning, format!("held back: {refusal}"));
                self.flight.refused_for_s = LONGEST_STEP_S;
            }
        }
    }
}

impl Flying {
    /// Yaw and its rate, of a plan that may have its own.
    pub(crate) fn yaw(&self, planned: Option<(f64, f64)>) -> (Option<f64>, Option<f64>) {
        match (&self.purpose, planned) {
            (Purpose::Lead(lead), _) => (Some(lead.heading_rad), Some(lead.heading_rate_rad_s)),
            (_, Some((yaw_rad, rate_rad_s))) => (Some(yaw_rad), Some(rate_rad_s)),
            (Purpose::Steer(steered), None) => (self.yaw_rad, Some(steered.yaw_rate_rad_s)),
            _ => (self.yaw_rad, None),
        }
    }
}

impl Purpose {
    /// Where it ends, if it ends at a place.
    pub(crate) fn goal(&self) -> Option<PositionNed> {
        match self {
            Self::TakeOff { hold } => Some(*hold),
            Self::Hold { at } => *at,
            Self::GoTo { to, .. } => Some(*to),
            Self::LandAt { spot } => Some(*spot),
            Self::Home { home } => Some(*home),
            Self::Guided(guided) => guided.goal.map(|goal| goal.position),
            Self::Lead(_) | Self::Follow(_) | Self::Keep(_) | Self::Fly(_) | Self::Steer(_) => None,
        }
    }

    /// Whether its plan is the reference itself, which begins anew where the vehicle is.
    fn moves_its_reference(&self) -> bool {
        matches!(self, Self::Guided(_) | Self::Keep(_)) || self.steered().is_some()
    }
}
