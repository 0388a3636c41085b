//! Makes recorded decisions again, with the code that decides in flight, and says where another one comes out.
//!
//! Must never do: count a decision as the same that it could not make again.

use crate::decisions::{FailsafeDecision, FormationDecision, GateState, LeadershipDecision, PeersRecord, outcome};
use crate::messages::Message;
use crate::telemetry::SetpointRecord;
use crate::topic::Topic;
use serde_json::Value;
use skein_coordination::{plan, steering};
use skein_domain::{NodeTime, Refusal, Setpoint, VehicleId};
use skein_safety::Gate;
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::Arc;

/// So many control periods are kept for setpoints that name them: they follow within one period, but vehicles of several workers mix.
const PERIODS: usize = 64;

/// Numbers may differ by so much of themselves: other processors round sines otherwise.
const SAME: f64 = 1e-9;

/// A decision that comes out otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// When it was made, on the node's clock.
    pub time: NodeTime,
    /// About which vehicle, if about one.
    pub vehicle: Option<VehicleId>,
    /// Which kind of decision.
    pub decision: &'static str,
    /// Where in it, as a path of names.
    pub place: String,
    /// What was decided.
    pub recorded: String,
    /// What is decided now.
    pub now: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} s: {}", self.time.as_seconds(), self.decision)?;
        if let Some(vehicle) = self.vehicle {
            write!(f, " of vehicle {vehicle}")?;
        }
        let Self {
            place, recorded, now, ..
        } = self;
        write!(f, ": {place} was {recorded}, is now {now}")
    }
}

/// How decisions compare.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Redecided {
    /// Setpoints that were judged again.
    pub setpoints: u64,
    /// Steps of failsafe policies.
    pub failsafe: u64,
    /// Plans of formations.
    pub formations: u64,
    /// Turns about the leadership.
    pub turns: u64,
    /// Setpoints whose control period the recorder thinned out.
    pub thinned: u64,
    /// What was not recorded with all that it was made from, or cannot be read.
    pub without_inputs: u64,
    /// What comes out otherwise.
    pub differences: Vec<Difference>,
}

/// Takes the messages of a recording in their order.
#[derive(Debug, Default)]
pub struct Redecider {
    gates: BTreeMap<u64, Arc<Gate>>,
    periods: VecDeque<PeersRecord>,
    made: Redecided,
}

impl Redecider {
    /// The topics that it needs.
    #[must_use]
    pub fn wants(topic: &Topic) -> bool {
        matches!(
            topic,
            Topic::Gate | Topic::Peers | Topic::Failsafe | Topic::Formation | Topic::Leadership | Topic::Setpoint(_)
        )
    }

    /// The next message.
    pub fn take(&mut self, message: &Message) {
        let known = match message.topic {
            Some(Topic::Gate) => self.gate(message),
            Some(Topic::Peers) => self.peers(message),
            Some(Topic::Setpoint(_)) => self.setpoint(message),
            Some(Topic::Failsafe) => self.failsafe(message),
            Some(Topic::Formation) => self.formation(message),
            Some(Topic::Leadership) => self.leadership(message),
            _ => Some(()),
        };
        if known.is_none() {
            self.made.without_inputs += 1;
        }
    }

    /// All of them were taken.
    #[must_use]
    pub fn finish(self) -> Redecided {
        self.made
    }

    fn gate(&mut self, message: &Message) -> Option<()> {
        let state: GateState = message.json().ok()?;
        self.gates.insert(state.number, Arc::new(state.gate().ok()?));
        Some(())
    }

    fn peers(&mut self, message: &Message) -> Option<()> {
        if self.periods.len() == PERIODS {
            self.periods.pop_front();
        }
        self.periods.push_back(message.json().ok()?);
        Some(())
    }

    fn setpoint(&mut self, message: &Message) -> Option<()> {
        let record: SetpointRecord = message.json().ok()?;
        let Some(made) = record.peers else {
            self.made.thinned += 1;
            return Some(());
        };
        let period = self.periods.iter().find(|peers| peers.made == made);
        let (gate, peers) = (self.gates.get(&record.gate)?, period?);
        let entry = peers.entry(record.vehicle)?;
        let answer = steering::steer(gate, &entry, &record.asked, &peers.surroundings, record.time);
        let (flown, refusal): (Option<Setpoint>, Option<Refusal>) = match answer.outcome {
            Ok(steered) => (Some(steered.setpoint), None),
            Err(refusal) => (None, Some(refusal)),
        };
        let recorded = (&record.slowed, &record.flown, &record.refusal);
        let now = (&answer.slowed, &flown, &refusal);
        self.made.setpoints += 1;
        self.compare(
            "setpoint",
            record.time,
            Some(record.vehicle),
            value(recorded),
            value(now),
        );
        Some(())
    }

    fn failsafe(&mut self, message: &Message) -> Option<()> {
        let mut record: FailsafeDecision = message.json().ok()?;
        let events = record.before.step(record.time, &record.health, &record.settings);
        self.made.failsafe += 1;
        self.compare(
            "failsafe policy",
            record.time,
            Some(record.vehicle),
            record.events,
            value(&events),
        );
        Some(())
    }

    fn formation(&mut self, message: &Message) -> Option<()> {
        let record: FormationDecision = message.json().ok()?;
        let gate = self.gates.get(&record.gate)?.clone();
        let made = plan(&record.input(gate), &record.peers);
        self.made.formations += 1;
        self.compare("formation", record.time, None, record.outcome, outcome(&made));
        Some(())
    }

    fn leadership(&mut self, message: &Message) -> Option<()> {
        let record: LeadershipDecision = message.json().ok()?;
        let turn = record.monitor.turn(record.time, &record.leadership);
        self.made.turns += 1;
        self.compare("leadership", record.time, None, value(record.turn), value(turn));
        Some(())
    }

    fn compare(
        &mut self,
        decision: &'static str,
        time: NodeTime,
        vehicle: Option<VehicleId>,
        recorded: Value,
        now: Value,
    ) {
        if let Some((place, recorded, now)) = differ("", &recorded, &now) {
            self.made.differences.push(Difference {
                time,
                vehicle,
                decision,
                place,
                recorded,
                now,
            });
        }
    }
}

fn value(of: impl serde::Serialize) -> Value {
    serde_json::to_value(of).unwrap_or_default()
}

/// The first place in which two values differ.
fn differ(at: &str, recorded: &Value, now: &Value) -> Option<(String, String, String)> {
    let told = || {
        Some((
            at.trim_start_matches('.').to_owned(),
            recorded.to_string(),
            now.to_string(),
        ))
    };
    match (recorded, now) {
        (Value::Object(a), Value::Object(b)) => {
            let names = a.keys().chain(b.keys().filter(|name| !a.contains_key(*name)));
            let null = &Value::Null;
            names.into_iter().find_map(|name| {
                differ(
                    &format!("{at}.{name}"),
                    a.get(name).unwrap_or(null),
                    b.get(name).unwrap_or(null),
                )
            })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let pairs = a.iter().zip(b).enumerate();
            pairs
                .into_iter()
                .find_map(|(i, (a, b))| differ(&format!("{at}.{i}"), a, b))
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64()?, b.as_f64()?);
            let close = (a - b).abs() <= SAME * a.abs().max(b.abs()).max(1.0);
            if close { None } else { told() }
        }
        _ if recorded == now => None,
        _ => told(),
    }
}
