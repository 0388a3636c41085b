//! The failsafe policy of one vehicle: what goes wrong with it is reported, and answered step by step, each step within a bounded
//! time. `deploy/docs/src/failsafe-policy.md` is the written table.
//!
//! The rules: of several triggers the strongest reaction wins, and all are reported. A weaker reaction never replaces a stronger
//! one in force. What was ordered must be seen to take effect, or the next stronger is ordered, up to stopping the setpoint stream.
//! When a trigger is over, what was ordered stays until an operator or the coordinator takes the vehicle up again. A vehicle on the
//! ground or under a pilot's control is reported on, no more.
//!
//! Must never do: command anything. It says what is to be done; the vehicle's actor does it.

mod clock;
mod effect;
mod health;
mod orders;
mod readings;
mod tracker;
mod words;

pub use effect::{Means, feasible, is_effective, next_after};
pub use health::{FenceBreach, GnssHealth, Health, reaction_of};
pub use orders::TakenUpBy;

use clock::ClockWatch;
use readings::Memory;
use serde::{Deserialize, Serialize};
use skein_domain::failsafe::TriggerMode;
use skein_domain::{
    Alarm, FailsafeEvent, FailsafeEventKind, FailsafeSettings, FailsafeState, NodeTime, Order, Reaction, ReportOnly,
    Trigger,
};
use tracker::{Change, Tracker};

/// Not heard for longer than this, in seconds, a vehicle was silent: what it could not say meanwhile is not missing.
const SILENCE_S: f64 = 3.0;

/// Between two looks there is less than that, in seconds, unless this computer stood still.
const STOOD_STILL_S: f64 = 0.25;
/// What was said meanwhile has been read so long after it, and a step of a clock been measured, in seconds. Until then nothing is taken for old.
const READ_AFTER_S: f64 = 0.5;
/// So soon after the last time nobody is given that time again, in seconds: a computer that is always late judges all the same.
const AGAIN_AFTER_S: f64 = 3.0;

/// The failsafe policy of one vehicle.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FailsafePolicy {
    trackers: Vec<(Trigger, Tracker)>,
    clock: ClockWatch,
    gnss_good_at: Option<NodeTime>,
    /// When the vehicle was last heard, and since when it has been without a silence.
    heard: Option<(NodeTime, NodeTime)>,
    /// In the air and under the swarm's control since then.
    reacting_since: Option<NodeTime>,
    pilot_in_control: bool,
    lands: bool,
    order: Option<Order>,
    /// Since when the order in force has not been seen to take effect.
    ineffective_since: Option<NodeTime>,
    /// The latest time it was told: the node's clock may be at fault too.
    now: NodeTime,
    /// When it last looked again after this computer had stood still.
    #[serde(default)]
    looked_again: Option<NodeTime>,
}

impl Default for FailsafePolicy {
    fn default() -> Self {
        Self::new()
    }
}

impl FailsafePolicy {
    /// A failsafe policy on which nothing has happened yet.
    #[must_use]
    pub fn new() -> Self {
        Self {
            trackers: Trigger::ALL.iter().map(|t| (*t, Tracker::default())).collect(),
            clock: ClockWatch::default(),
            gnss_good_at: None,
            heard: None,
            reacting_since: None,
            pilot_in_control: false,
            lands: false,
            order: None,
            ineffective_since: None,
            now: NodeTime::default(),
            looked_again: None,
        }
    }

    /// Takes one look at the vehicle, at least ten times a second. What is to be done is in events of kind
    /// [`FailsafeEventKind::Ordered`]; at most one per call.
    pub fn step(&mut self, now: NodeTime, health: &Health, settings: &FailsafeSettings) -> Vec<FailsafeEvent> {
        let clock_deviation_s = self.clock.deviation_s(now, health, &settings.clock_fault);
        self.note_stall(now);
        self.now = self.now.max(now);
        let mut events = Vec::new();
        self.note_control(health, &mut events);
        self.gnss_good_at = readings::good_fix_at(health, settings).max(self.gnss_good_at);
        let memory = Memory {
            gnss_good_at: self.gnss_good_at,
            heard_since: self.note_heard(health.last_heard),
            clock_deviation_s,
            reacting_since: self.reacting_since,
        };
        for i in 0..self.trackers.len() {
            self.look_at(i, health, settings, &memory, &mut events);
        }
        self.give_orders(health, settings, &mut events);
        events
    }

    fn note_stall(&mut self, now: NodeTime) {
        let stood_still = self.now != NodeTime::default() && now.seconds_since(self.now) > STOOD_STILL_S;
        let again = (self.looked_again).is_some_and(|before| now.seconds_since(before) < AGAIN_AFTER_S);
        if stood_still && !again {
            self.looked_again = Some(now);
        }
    }

    /// Whether what was said while this computer stood still may not have been read yet.
    fn is_reading(&self) -> bool {
        (self.looked_again).is_some_and(|at| self.now.seconds_since(at) < READ_AFTER_S)
    }

    /// The autopilot restarted: its clock began anew, and where that is now is no fault of it.
    pub fn autopilot_restarted(&mut self) {
        self.clock = ClockWatch::default();
    }

    /// Since when the vehicle has been heard without a silence.
    fn note_heard(&mut self, heard: NodeTime) -> NodeTime {
        let since = match self.heard {
            Some((last, since)) if heard.seconds_since(last) <= SILENCE_S => since,
            Some(_) => heard,
            None => NodeTime::default(),
        };
        self.heard = Some((heard, since));
        since
    }

    /// How far the policy has come with the vehicle.
    #[must_use]
    pub fn state(&self, settings: &FailsafeSettings) -> FailsafeState {
        FailsafeState {
            alarms: self
                .trackers
                .iter()
                .filter(|(_, tracker)| tracker.is_raised())
                .map(|(trigger, tracker)| self.alarm(*trigger, tracker, settings))
                .collect(),
            order: self.order,
        }
    }

    /// The reaction that is in force; `None` if the vehicle flies freely.
    #[must_use]
    pub fn order(&self) -> Option<&Order> {
        self.order.as_ref()
    }

    fn alarm(&self, trigger: Trigger, tracker: &Tracker, settings: &FailsafeSettings) -> Alarm {
        let (value, limit, unit) = tracker.figures();
        Alarm {
            trigger,
            value,
            limit,
            unit: unit.to_owned(),
            since: tracker.since(),
            reaction: tracker.stand().map_or(Reaction::Warn, |s| s.reaction),
            report_only: self.report_only(trigger, tracker, settings),
        }
    }

    fn report_only(&self, trigger: Trigger, tracker: &Tracker, settings: &FailsafeSettings) -> Option<ReportOnly> {
        if self.pilot_in_control {
            Some(ReportOnly::PilotInControl)
        } else if self.reacting_since.is_none() {
            Some(ReportOnly::OnGround)
        } else if settings.mode(trigger) != TriggerMode::React {
            Some(ReportOnly::WarnOnly)
        } else if self.lands && tracker.stand().is_some_and(|stand| calls_back(stand.reaction)) {
            Some(ReportOnly::Landing)
        } else {
            tracker.is_overruled().then_some(ReportOnly::Overruled)
        }
    }

    /// Who has control authority over the vehicle, and whether it flies.
    fn note_control(&mut self, health: &Health, events: &mut Vec<FailsafeEvent>) {
        self.pilot_in_control = health.pilot_in_control;
        self.lands = health.lands;
        if health.airborne && !health.pilot_in_control {
            self.reacting_since.get_or_insert(self.now);
            return;
        }
        if self.reacting_since.take().is_some() {
            for (_, tracker) in &mut self.trackers {
                tracker.stand_down();
            }
        }
        // Under a pilot's control the stream stays stopped until somebody takes the vehicle up again.
        let ends = |order: &Order| !health.airborne || order.reaction != Reaction::Release;
        if let Some(order) = self.order.filter(ends) {
            let why = match (health.airborne, health.failsafe) {
                (true, true) => "the autopilot's own failsafe took over",
                (true, false) => "the pilot took over",
                (false, _) => "on the ground",
            };
            events.push(self.about_order(FailsafeEventKind::Ended, &order, why));
            self.order = None;
            self.ineffective_since = None;
        }
    }

    /// Reads one trigger and tells what became of it.
    fn look_at(
        &mut self,
        index: usize,
        health: &Health,
        settings: &FailsafeSettings,
        memory: &Memory,
        events: &mut Vec<FailsafeEvent>,
    ) {
        let is_reading = self.is_reading();
        let Some((trigger, tracker)) = self.trackers.get_mut(index) else {
            return;
        };
        let trigger = *trigger;
        if is_reading && readings::is_age(trigger) {
            return;
        }
        let reading = readings::read(trigger, self.now, health, settings, memory, tracker);
        let since = tracker.since();
        let change = tracker.advance(
            self.now,
            reading.as_ref(),
            self.reacting_since,
            settings.recovered_after_s,
        );
        let kind = match change {
            Change::None => return,
            Change::Raised => FailsafeEventKind::Raised,
            Change::Escalated => FailsafeEventKind::Escalated,
            Change::Cleared => FailsafeEventKind::Cleared,
        };
        let Some((_, tracker)) = self.trackers.get(index) else {
            return;
        };
        let mut alarm = self.alarm(trigger, tracker, settings);
        if change == Change::Cleared {
            alarm.since = since;
            alarm.report_only = None;
        }
        events.push(words::event(kind, &alarm, self.now, health));
    }
}

/// Whether a vehicle that lands would be called back by this. A landing is the stronger reaction, whoever commanded it.
fn calls_back(reaction: Reaction) -> bool {
    (Reaction::Hold..Reaction::Land).contains(&reaction)
}

#[cfg(test)]
mod tests;
