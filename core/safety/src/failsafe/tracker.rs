//! One trigger of one vehicle: since when it lasts, how far up its steps it has come, and whether it is over.

use super::readings::{Course, Reading};
use serde::{Deserialize, Deserializer, Serialize};
use skein_domain::failsafe::FailsafeStep;
use skein_domain::{NodeTime, Reaction};
use std::borrow::Cow;

/// What became of a trigger this period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Change {
    /// Nothing to tell.
    None,
    /// It was raised.
    Raised,
    /// It came to a stronger reaction.
    Escalated,
    /// It is over.
    Cleared,
}

/// The reaction a trigger has come to: since when, and the value at that time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Stand {
    pub reaction: Reaction,
    pub since: NodeTime,
    #[serde(deserialize_with = "null_is_infinite")]
    pub value: f64,
}

/// Not heard at all is infinitely long ago, which JSON tells as null.
fn null_is_infinite<'de, D: Deserializer<'de>>(value: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(value)?.unwrap_or(f64::INFINITY))
}

/// One trigger's state.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Tracker {
    began: Option<NodeTime>,
    good_since: Option<NodeTime>,
    raised: bool,
    stand: Option<Stand>,
    overruled: Option<Reaction>,
    wanted: Option<(Reaction, NodeTime)>,
    #[serde(deserialize_with = "null_is_infinite")]
    value: f64,
    #[serde(deserialize_with = "null_is_infinite")]
    limit: f64,
    unit: Cow<'static, str>,
}

impl Tracker {
    /// Whether it is raised.
    pub(super) fn is_raised(&self) -> bool {
        self.raised
    }

    /// The reaction it has come to; `None` while it only reports.
    pub(super) fn stand(&self) -> Option<Stand> {
        self.stand
    }

    /// The reaction it asks for: none that an operator has overruled.
    pub(super) fn demand(&self) -> Reaction {
        let stand = self.stand.map_or(Reaction::Warn, |s| s.reaction);
        if self.is_overruled() { Reaction::Warn } else { stand }
    }

    /// Whether an operator overruled the step it has come to.
    pub(super) fn is_overruled(&self) -> bool {
        let stand = self.stand.map_or(Reaction::Warn, |s| s.reaction);
        self.overruled.is_some_and(|overruled| stand <= overruled)
    }

    /// The reaction that its value itself asks for now, of triggers without steps.
    pub(super) fn wanted(&self) -> Option<Reaction> {
        self.wanted.map(|(reaction, _)| reaction)
    }

    /// Since when it lasts.
    pub(super) fn since(&self) -> NodeTime {
        self.began.unwrap_or_default()
    }

    /// Value, limit and unit, the newest.
    pub(super) fn figures(&self) -> (f64, f64, &str) {
        (self.value, self.limit, &self.unit)
    }

    /// An operator takes the vehicle up although it lasts: only its next step asks for something again.
    pub(super) fn overrule(&mut self) {
        if let Some(stand) = self.stand {
            self.overruled = Some(stand.reaction);
        }
    }

    /// From now on it only reports: on the ground, or under a pilot's control.
    pub(super) fn stand_down(&mut self) {
        self.stand = None;
        self.overruled = None;
    }

    /// Takes a reading. `reacting_since` is absent while it only reports; its steps count from there at the earliest.
    pub(super) fn advance(
        &mut self,
        now: NodeTime,
        reading: Option<&Reading<'_>>,
        reacting_since: Option<NodeTime>,
        recovered_after_s: f64,
    ) -> Change {
        if let Some(reading) = reading {
            (self.value, self.limit, self.unit) = (reading.value, reading.limit, reading.unit.into());
        }
        match reading {
            Some(reading) if reading.bad || (self.began.is_some() && !reading.good) => {
                self.lasts(now, reading, reacting_since)
            }
            _ => self.is_good(now, recovered_after_s),
        }
    }

    fn is_good(&mut self, now: NodeTime, recovered_after_s: f64) -> Change {
        self.wanted = None;
        if !self.raised {
            self.began = None;
            return Change::None;
        }
        let good_since = *self.good_since.get_or_insert(now);
        if now.seconds_since(good_since) < recovered_after_s {
            return Change::None;
        }
        *self = Self {
            value: self.value,
            limit: self.limit,
            unit: std::mem::take(&mut self.unit),
            ..Self::default()
        };
        Change::Cleared
    }

    fn lasts(&mut self, now: NodeTime, reading: &Reading<'_>, reacting_since: Option<NodeTime>) -> Change {
        self.good_since = None;
        let lasted_s = reading.lasted_s.filter(|s| s.is_finite()).unwrap_or(0.0);
        let began = *self.began.get_or_insert(now.plus_seconds(-lasted_s));
        let lasted_s = reading.lasted_s.unwrap_or_else(|| now.seconds_since(began));
        let reacting_s = reacting_since.map(|since| now.seconds_since(since));
        let (reported, step) = match reading.course {
            Course::Steps(steps) => (
                due(steps, lasted_s).is_some(),
                reacting_s.and_then(|s| due(steps, lasted_s.min(s))),
            ),
            Course::Wanted { reaction, after_s } => self.wanted_long_enough(now, reaction, after_s, reacting_s),
        };
        let rises = self.rise(now, step, reading.lasted_s.is_some());
        if reported && !self.raised {
            self.raised = true;
            return Change::Raised;
        }
        if rises && self.raised {
            Change::Escalated
        } else {
            Change::None
        }
    }

    /// Whether it is to be reported, and the step it has come to.
    fn wanted_long_enough(
        &mut self,
        now: NodeTime,
        reaction: Reaction,
        after_s: f64,
        reacting_s: Option<f64>,
    ) -> (bool, Option<FailsafeStep>) {
        let wanted = self.wanted.filter(|(r, _)| *r == reaction).unwrap_or((reaction, now));
        self.wanted = Some(wanted);
        let wanted_s = now.seconds_since(wanted.1);
        let acts = reacting_s.is_some_and(|s| wanted_s.min(s) >= after_s);
        (wanted_s >= after_s, acts.then_some(FailsafeStep { after_s, reaction }))
    }

    /// Comes to a step if it is stronger than where it stands. Whether that is something new to tell.
    fn rise(&mut self, now: NodeTime, step: Option<FailsafeStep>, is_age: bool) -> bool {
        let Some(step) = step else { return false };
        let stood = self.stand.map(|s| s.reaction);
        if stood.is_some_and(|s| step.reaction <= s) {
            return false;
        }
        self.stand = Some(Stand {
            reaction: step.reaction,
            since: now,
            value: self.value,
        });
        if is_age {
            // What an age exceeded is the step's own time.
            self.limit = step.after_s;
        }
        step.reaction > stood.unwrap_or(Reaction::Warn)
    }
}

/// The strongest step that is due after so long.
fn due(steps: &[FailsafeStep], lasted_s: f64) -> Option<FailsafeStep> {
    steps
        .iter()
        .filter(|s| lasted_s >= s.after_s)
        .max_by_key(|s| s.reaction)
        .copied()
}
