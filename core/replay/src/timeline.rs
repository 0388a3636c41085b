//! What happened in a recording and when: marks for a screen, and the events and gates that a jump to any moment starts with. Made once, by
//! going through the whole recording.
//!
//! Must never do: hold more than [`MOST_EVENTS`] events and [`MOST_MARKS`] marks, however long the recording is.

use schemars::JsonSchema;
use serde::Serialize;
use skein_domain::exchange::Severity;
use skein_domain::{NodeTime, VehicleId};
use skein_recording::decisions::GateState;
use skein_recording::{AuditRecord, Message, Recording, Select, Topic};
use skein_view::{EventKind, EventRecord};
use ts_rs::TS;

/// More events are not kept: those of a day of a busy swarm.
const MOST_EVENTS: usize = 200_000;
/// More marks are not kept: nobody finds his way in them.
const MOST_MARKS: usize = 5_000;
/// Of what somebody sent along so many characters are told.
const LONGEST_WITH: usize = 160;
/// So many events are known at the moment that is jumped to, as a node keeps them.
const KEPT_EVENTS: usize = 2_000;

/// What happened in a recording, for a screen.
#[derive(Debug, Clone, PartialEq, Default, Serialize, TS, JsonSchema)]
pub struct Timeline {
    /// The recording has been gone through. Until then there are no marks.
    pub complete: bool,
    /// By their time.
    pub marks: Vec<TimelineMark>,
    /// So many more there were, which nothing is shown of.
    #[ts(type = "number")]
    pub left_out: u64,
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct TimelineMark {
    /// When, in seconds from the beginning of the recording.
    pub position_s: f64,
    /// How urgent.
    pub severity: Severity,
    /// About which vehicle, if about one.
    pub vehicle: Option<VehicleId>,
    /// Who did it, if it was an operator or a program; empty if nobody says who.
    pub who: Option<String>,
    /// One sentence.
    pub text: String,
}

/// All that was found.
#[derive(Debug, Default)]
pub(crate) struct Index {
    pub timeline: Timeline,
    events: Vec<(NodeTime, EventRecord)>,
    gates: Vec<(NodeTime, GateState)>,
}

impl Index {
    /// Goes through a recording. What cannot be read is left out.
    pub fn of(recording: &Recording) -> Self {
        let wanted = |topic: &Topic| matches!(topic, Topic::Events | Topic::Gate | Topic::Audit);
        let mut index = Self::default();
        let begin = recording.span().0;
        for message in recording.messages(Select::only(wanted)).flatten() {
            index.take(&message, begin);
        }
        index.timeline.complete = true;
        index
    }

    fn take(&mut self, message: &Message, begin: NodeTime) {
        let at = message.recorded;
        match message.topic {
            Some(Topic::Events) => {
                let Ok(event) = message.json::<EventRecord>() else {
                    return;
                };
                if let Some(mark) = of_event(&event, at.seconds_since(begin)) {
                    self.mark(mark);
                }
                if self.events.len() < MOST_EVENTS {
                    self.events.push((at, event));
                }
            }
            Some(Topic::Audit) => {
                let done = message.json::<AuditRecord>().ok();
                if let Some(mark) = done.and_then(|done| of_audit(done, at.seconds_since(begin))) {
                    self.mark(mark);
                }
            }
            Some(Topic::Gate) => {
                if let Ok(gate) = message.json::<GateState>() {
                    self.gates.push((at, gate));
                }
            }
            _ => {}
        }
    }

    fn mark(&mut self, mark: TimelineMark) {
        if self.timeline.marks.len() < MOST_MARKS {
            self.timeline.marks.push(mark);
        } else {
            self.timeline.left_out += 1;
        }
    }

    /// The newest events up to a moment.
    pub fn events_until(&self, at: NodeTime) -> impl Iterator<Item = EventRecord> {
        let end = self.events.partition_point(|(when, _)| *when <= at);
        let newest = self
            .events
            .get(end.saturating_sub(KEPT_EVENTS)..end)
            .unwrap_or_default();
        newest.iter().map(|(_, event)| event.clone())
    }

    /// The gate that was in force at a moment, if it is known.
    pub fn gate_at(&self, at: NodeTime) -> Option<&GateState> {
        let end = self.gates.partition_point(|(when, _)| *when <= at);
        self.gates.get(end.checked_sub(1)?).map(|(_, gate)| gate)
    }
}

/// Commands are marked as what somebody did, not once for each of their steps; changes of a flight state are what comes of them.
fn of_event(event: &EventRecord, position_s: f64) -> Option<TimelineMark> {
    let is_step = matches!(event.kind, EventKind::Command { .. } | EventKind::Acknowledged { .. });
    let is_alert = event.severity >= Severity::Warning;
    (is_alert || !is_step).then(|| TimelineMark {
        position_s,
        severity: event.severity,
        vehicle: event.vehicle,
        who: None,
        text: event.text.clone(),
    })
}

/// What people and programs did to the swarm. That a recording began is none of it, nor is a plan that was only looked at.
fn of_audit(done: AuditRecord, position_s: f64) -> Option<TimelineMark> {
    let audit = done.audit;
    let is_looked_at = audit.what.ends_with("/preview");
    (audit.over != "node" && !is_looked_at).then(|| TimelineMark {
        position_s,
        severity: Severity::Info,
        vehicle: None,
        who: Some(audit.who),
        text: words(&audit.what, &audit.with, &audit.outcome),
    })
}

/// `POST commands {...}: 200`.
fn words(what: &str, with: &str, outcome: &str) -> String {
    let what = what.replacen("/api/v1/", "", 1);
    let with: String = with.chars().take(LONGEST_WITH).collect();
    let gap = if with.is_empty() { "" } else { " " };
    format!("{what}{gap}{with}: {outcome}")
}
