//! Which events tell that something went wrong, how they are told apart, and which ones tell how it went on.
//!
//! Must never do: say that something was done which no event tells of.

use crate::facts::{FindingKind, Step};
use skein_domain::exchange::{CommandProgress, Severity};
use skein_domain::{FailsafeEvent, FailsafeEventKind, Refusal, ReportOnly, Trigger, VehicleId};
use skein_view::{ActorStatus, Avoidance, EventKind, EventRecord};

/// Something that went wrong once.
#[derive(Debug)]
pub struct Incident {
    pub t_s: f64,
    pub vehicle: Option<VehicleId>,
    pub severity: Severity,
    pub kind: FindingKind,
    pub what: String,
    pub done: Vec<Step>,
}

/// What makes two of them the same: figures aside, the same words about the same vehicle.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Key(FindingKind, Option<VehicleId>, String);

/// Something that lasts until an event ends it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Open {
    Link(Option<VehicleId>),
    Actor(String),
    Failsafe(Option<VehicleId>, Trigger),
}

impl Incident {
    pub fn key(&self) -> Key {
        Key(self.kind, self.vehicle, without_figures(&self.what))
    }
}

/// A text with `#` for each figure that has a unit or a point: they differ where the same thing comes again.
fn without_figures(text: &str) -> String {
    let words: Vec<&str> = text.split(' ').collect();
    let unit = |word: &str| {
        let word = word.trim_end_matches([',', '.', ';', ')', ':']);
        ["m", "s", "ms", "m/s", "%", "V", "Hz", "mm", "km", "times"].contains(&word)
    };
    let plain = words.iter().enumerate().map(|(at, word)| {
        let bare = word.trim_start_matches(['(', '-']);
        let figure = bare.starts_with(|c: char| c.is_ascii_digit());
        let measured = bare.contains('.') || bare.ends_with('%') || words.get(at + 1).is_some_and(|next| unit(next));
        if figure && measured { "#" } else { word }
    });
    plain.collect::<Vec<_>>().join(" ")
}

/// The kind and the words of what went wrong, if something did.
pub fn of(event: &EventRecord) -> Option<(FindingKind, String)> {
    let text = event.text.clone();
    let bad = event.severity >= Severity::Warning;
    let told = match &event.kind {
        EventKind::LinkLost => (FindingKind::LinkLoss, text),
        EventKind::TakenOver { .. } => (FindingKind::Takeover, text),
        EventKind::EmergencyStop => (FindingKind::EmergencyStop, text),
        EventKind::Command { command, progress, .. } => {
            let refusal = refused(progress)?;
            (FindingKind::Refusal, format!("Command {command} refused: {refusal}"))
        }
        EventKind::Refused { .. } => (FindingKind::Refusal, text),
        EventKind::Avoidance if bad => (FindingKind::Avoidance, text),
        EventKind::Supervision { status, .. } if *status != ActorStatus::Running => (FindingKind::Restart, text),
        EventKind::Stream if bad => (FindingKind::Setpoints, text),
        _ if bad => (FindingKind::Warning, text),
        _ => return None,
    };
    Some(told)
}

/// What was done at once.
pub fn done(event: &EventRecord, t_s: f64) -> Vec<Step> {
    let text = match &event.kind {
        EventKind::TakenOver { failsafe, from, to } => {
            let whose = if *failsafe {
                "its autopilot's failsafe"
            } else {
                "a pilot or another ground station"
            };
            format!("flown by {whose}: {from} to {to}")
        }
        EventKind::Command { .. } => "not carried out".into(),
        EventKind::Supervision {
            status: ActorStatus::GivenUp,
            ..
        } => "given up".into(),
        _ => return Vec::new(),
    };
    vec![Step { t_s, text }]
}

/// What begins with it and lasts.
pub fn opens(event: &EventRecord) -> Option<Open> {
    match &event.kind {
        EventKind::LinkLost => Some(Open::Link(event.vehicle)),
        EventKind::Supervision { actor, .. } => Some(Open::Actor(actor.clone())),
        _ => None,
    }
}

/// What ends with it, and how.
pub fn closes(event: &EventRecord) -> Option<(Open, &'static str)> {
    match &event.kind {
        EventKind::LinkRegained => Some((Open::Link(event.vehicle), "heard again")),
        EventKind::Supervision {
            actor,
            status: ActorStatus::Running,
        } => Some((Open::Actor(actor.clone()), "runs again")),
        _ => None,
    }
}

/// What went wrong, in the words that an operator was told.
pub fn failsafe_words(event: &EventRecord, step: &FailsafeEvent) -> String {
    let trigger = step.trigger.word().replace('_', " ");
    let told = if step.reason.is_empty() {
        &event.text
    } else {
        &step.reason
    };
    if told.is_empty() {
        format!("Failsafe: {trigger}")
    } else {
        format!("Failsafe, {trigger}: {told}")
    }
}

/// What became of it with this step.
pub fn failsafe_step(step: &FailsafeEvent) -> Option<String> {
    let reaction = step.reaction.word();
    let text = match step.kind {
        FailsafeEventKind::Raised | FailsafeEventKind::Escalated => {
            let why = step.report_only.map(|why| match why {
                ReportOnly::OnGround => "it stood on the ground",
                ReportOnly::PilotInControl => "a pilot flew it",
                ReportOnly::WarnOnly => "the configuration says so",
                ReportOnly::Overruled => "an operator had taken it up",
                ReportOnly::Landing => "it was landing",
            })?;
            format!("reported only: {why}")
        }
        FailsafeEventKind::Ordered => format!("{reaction} ordered"),
        FailsafeEventKind::Effective => format!("{reaction} in effect"),
        FailsafeEventKind::Ineffective => format!("{reaction} without effect"),
        FailsafeEventKind::Cleared => "cause over".into(),
        FailsafeEventKind::Ended => "reaction ended".into(),
        FailsafeEventKind::TakenUp => "taken up again".into(),
    };
    Some(text)
}

/// Whether it is the last of its trigger.
pub fn ends(step: &FailsafeEvent) -> bool {
    matches!(step.kind, FailsafeEventKind::Ended | FailsafeEventKind::TakenUp)
        || step.kind == FailsafeEventKind::Cleared && step.reaction == skein_domain::Reaction::Warn
}

/// Where no distance could be kept.
pub fn infeasible(change: &Avoidance) -> String {
    let whom = change.because.as_deref().unwrap_or("a fence");
    format!("No way out left: setpoints could only keep as far as possible from {whom}")
}

/// A command that was refused; one that a newer command replaced went its way.
fn refused(progress: &CommandProgress) -> Option<&Refusal> {
    match progress {
        CommandProgress::Refused {
            refusal: Refusal::Superseded,
        } => None,
        CommandProgress::Refused { refusal } => Some(refusal),
        _ => None,
    }
}
