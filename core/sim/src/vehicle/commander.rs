//! Modes, arming and failsafes: what the vehicle is willing to do, and what it says when it is not.

use super::mode;
use crate::truth::{ModeCause, ModeChange};
use mavlink::dialects::common::{MavResult, MavSeverity};
use skein_domain::FlightMode;
use std::sync::Arc;

/// Something the vehicle tells its operators.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Notice {
    pub severity: MavSeverity,
    pub text: String,
}

/// Who asks for a mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Asker {
    /// A command over one of its faces.
    Link,
    /// The pilot.
    Pilot,
    /// The vehicle itself, when a take-off is done.
    TakeOffEnd,
}

/// What the commander needs to know in every step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Situation {
    /// Seconds of the simulation.
    pub now_s: f64,
    /// Age of the last setpoint in seconds.
    pub setpoint_age_s: f64,
    /// COM_OF_LOSS_T.
    pub setpoint_timeout_s: f64,
    /// COM_OBL_RC_ACT.
    pub loss_action: i32,
    /// Whether the estimator has a horizontal position.
    pub position_valid: bool,
}

/// After COM_OF_LOSS_T it takes PX4 this long to act, in seconds.
const FAILSAFE_DELAY_S: f64 = 0.1;
/// Setpoints count as back when the last one is younger than this many time-outs, in seconds.
const CHECK_PERIOD_S: f64 = 0.1;

/// The commander.
#[derive(Debug, Clone)]
pub(crate) struct Commander {
    ready_at_s: f64,
    ready: bool,
    armed_since_s: Option<f64>,
    intention: FlightMode,
    mode: FlightMode,
    failsafe: bool,
    mode_after_disarm: FlightMode,
    /// The pilot's radio control is there.
    pub rc: bool,
    /// There is a mission to fly.
    pub has_mission: bool,
    setpoints_alive: bool,
    position_valid: bool,
    next_check_s: f64,
    changes: Arc<Vec<ModeChange>>,
    notices: Vec<Notice>,
}

impl Commander {
    /// Starts in HOLD, as PX4 without radio control does.
    pub(crate) fn new(ready_at_s: f64) -> Self {
        Self {
            ready_at_s,
            ready: false,
            armed_since_s: None,
            intention: FlightMode::Hold,
            mode: FlightMode::Hold,
            failsafe: false,
            mode_after_disarm: FlightMode::Hold,
            rc: false,
            has_mission: false,
            setpoints_alive: false,
            position_valid: true,
            next_check_s: 0.0,
            changes: Arc::default(),
            notices: Vec::new(),
        }
    }

    /// Starts anew; what was logged stays.
    pub(crate) fn restart(&mut self, now_s: f64, ready_at_s: f64) {
        let changes = std::mem::take(&mut self.changes);
        let before = self.mode;
        *self = Self {
            changes,
            mode: before,
            rc: self.rc,
            ..Self::new(ready_at_s)
        };
        self.show(FlightMode::Hold, ModeCause::Rebooted, now_s);
    }

    pub(crate) fn mode(&self) -> FlightMode {
        self.mode
    }

    /// The mode that was asked for.
    pub(crate) fn intention(&self) -> FlightMode {
        self.intention
    }

    pub(crate) fn is_armed(&self) -> bool {
        self.armed_since_s.is_some()
    }

    /// Seconds since it was armed.
    pub(crate) fn armed_for_s(&self, now_s: f64) -> Option<f64> {
        self.armed_since_s.map(|since| now_s - since)
    }

    pub(crate) fn in_failsafe(&self) -> bool {
        self.failsafe
    }

    /// The estimator is ready.
    pub(crate) fn is_estimator_ready(&self) -> bool {
        self.ready
    }

    /// Whether arming would be allowed now: the PREARM_CHECK bit.
    pub(crate) fn would_arm(&self) -> bool {
        self.ready && self.can_run(self.intention) && !mode::prevents_arming(self.intention)
    }

    pub(crate) fn changes(&self) -> &Arc<Vec<ModeChange>> {
        &self.changes
    }

    /// Takes what is to be told to the operators.
    pub(crate) fn take_notices(&mut self) -> Vec<Notice> {
        std::mem::take(&mut self.notices)
    }

    pub(crate) fn say(&mut self, severity: MavSeverity, text: impl Into<String>) {
        self.notices.push(Notice {
            severity,
            text: text.into(),
        });
    }

    fn refuse(&mut self, text: impl Into<String>) -> MavResult {
        self.say(MavSeverity::MAV_SEVERITY_CRITICAL, text);
        MavResult::MAV_RESULT_TEMPORARILY_REJECTED
    }

    /// Looks at the setpoint stream and decides on failsafes.
    pub(crate) fn step(&mut self, s: &Situation) {
        if !self.ready && s.now_s >= self.ready_at_s {
            self.ready = true;
        }
        let lost_after_s = s.setpoint_timeout_s + FAILSAFE_DELAY_S;
        if s.setpoint_age_s > lost_after_s {
            self.setpoints_alive = false;
        } else if s.now_s >= self.next_check_s {
            self.next_check_s = s.now_s + CHECK_PERIOD_S;
            self.setpoints_alive = s.setpoint_age_s <= s.setpoint_timeout_s;
        }
        self.position_valid = s.position_valid;
        if !self.is_armed() {
            return;
        }
        match self.fallback(s) {
            Some(to) => {
                if !self.failsafe {
                    self.say(MavSeverity::MAV_SEVERITY_CRITICAL, "Failsafe activated");
                }
                self.failsafe = true;
                self.show(to, ModeCause::Failsafe, s.now_s);
            }
            None if self.failsafe => {
                self.failsafe = false;
                self.show(self.intention, ModeCause::Recovered, s.now_s);
            }
            None => {}
        }
    }

    /// The mode that takes the place of the one that was asked for, if that cannot go on.
    fn fallback(&self, s: &Situation) -> Option<FlightMode> {
        let setpoints_lost = self.intention == FlightMode::Offboard && !self.setpoints_alive;
        if !s.position_valid && mode::needs_position(self.intention) {
            // Nothing is left that could hold a place: down, or the pilot.
            Some(if self.rc {
                FlightMode::Altitude
            } else {
                FlightMode::Descend
            })
        } else {
            setpoints_lost.then(|| self.loss_mode(s.loss_action))
        }
    }

    /// Where the loss of setpoints leads.
    fn loss_mode(&self, action: i32) -> FlightMode {
        match action {
            0 if self.rc => FlightMode::Position,
            1 if self.rc => FlightMode::Altitude,
            2 if self.rc => FlightMode::Manual,
            4 => FlightMode::Land,
            5 => FlightMode::Hold,
            6 => FlightMode::Termination,
            // Without a pilot to hand over to, and for "return": return.
            _ => FlightMode::Return,
        }
    }

    /// Whether a mode could run now.
    fn can_run(&self, wanted: FlightMode) -> bool {
        // Without a place a landing is accepted all the same, and becomes a descent.
        if !self.position_valid && mode::needs_position(wanted) && wanted != FlightMode::Land {
            return false;
        }
        match wanted {
            FlightMode::Offboard => self.setpoints_alive,
            FlightMode::Mission => self.ready && self.has_mission,
            m if mode::needs_pilot(m) => self.rc,
            _ => self.ready,
        }
    }

    /// A mode is asked for.
    pub(crate) fn request(&mut self, wanted: FlightMode, asker: Asker, now_s: f64) -> MavResult {
        if self.is_armed() && !self.can_run(wanted) {
            let name = mode::px4_name(wanted);
            return self.refuse(format!("Switching to {name} is currently not available"));
        }
        self.intention = wanted;
        self.failsafe = false;
        if !mode::prevents_arming(wanted) {
            self.mode_after_disarm = wanted;
        }
        let cause = match asker {
            Asker::Link => ModeCause::Commanded,
            Asker::Pilot => ModeCause::Pilot,
            Asker::TakeOffEnd => ModeCause::TakeOffEnded,
        };
        self.show(wanted, cause, now_s);
        MavResult::MAV_RESULT_ACCEPTED
    }

    fn show(&mut self, to: FlightMode, cause: ModeCause, now_s: f64) {
        if to == self.mode {
            return;
        }
        let change = ModeChange {
            time_s: now_s,
            from: self.mode,
            to,
            cause,
        };
        Arc::make_mut(&mut self.changes).push(change);
        self.mode = to;
    }

    /// Arm.
    pub(crate) fn arm(&mut self, now_s: f64) -> MavResult {
        if self.is_armed() {
            return MavResult::MAV_RESULT_ACCEPTED;
        }
        if !self.would_arm() {
            return self.refuse("Arming denied: Resolve system health failures first");
        }
        self.armed_since_s = Some(now_s);
        self.say(MavSeverity::MAV_SEVERITY_INFO, "Armed by external command");
        MavResult::MAV_RESULT_ACCEPTED
    }

    /// Disarm on command; `force` also in the air.
    pub(crate) fn disarm(&mut self, landed: bool, force: bool, now_s: f64) -> MavResult {
        if self.is_armed() && !landed && !force {
            return self.refuse("Disarming denied: not landed");
        }
        if self.is_armed() {
            self.disarmed("Disarmed by external command", now_s);
        }
        MavResult::MAV_RESULT_ACCEPTED
    }

    /// The motors stop: the mode goes back to the last one that can be armed in.
    pub(crate) fn disarmed(&mut self, text: &str, now_s: f64) {
        self.armed_since_s = None;
        self.failsafe = false;
        self.intention = self.mode_after_disarm;
        self.say(MavSeverity::MAV_SEVERITY_INFO, text);
        self.show(self.mode_after_disarm, ModeCause::Disarmed, now_s);
    }
}
