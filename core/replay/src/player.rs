//! The fleet as it was, moment after moment: the last whole picture of it, with what came of each vehicle since.
//!
//! Must never do: read a clock, or keep what was before a jump.

use skein_domain::NodeTime;
use skein_recording::decisions::GateState;
use skein_recording::{Message, Messages, Recording, Select, Topic, VehicleTelemetry};
use skein_view::{EventRecord, FleetSnapshot};
use std::collections::BTreeMap;
use std::iter::Peekable;

/// A jump reads from so long before its moment, in seconds: whole pictures are recorded every two. If there is none, more is read.
const BEFORE_S: [f64; 3] = [5.0, 60.0, f64::INFINITY];
/// Of standing vehicles something is recorded once a second. What is not older than this was known all the time: only after that it ages.
const RECORDED_EVERY_S: f64 = 2.5;

/// What happened in a step.
#[derive(Debug, Default)]
pub struct Step {
    /// Events, as they came.
    pub events: Vec<EventRecord>,
    /// The gate that came into force.
    pub gate: Option<GateState>,
}

/// Goes through a recording.
pub struct Player<'a> {
    messages: Peekable<Messages<'a>>,
    fleet: Option<FleetSnapshot>,
    /// When what is known of it was measured.
    known: NodeTime,
}

fn is_shown(topic: &Topic) -> bool {
    matches!(topic, Topic::Fleet | Topic::Telemetry(_) | Topic::Events | Topic::Gate)
}

impl<'a> Player<'a> {
    /// Goes to a moment. Events before it are not told.
    #[must_use]
    pub fn at(recording: &'a Recording, position: NodeTime) -> Self {
        let mut player = None;
        for before_s in BEFORE_S {
            let from = NodeTime(position.0.saturating_sub(micros(before_s)));
            let mut from_there = Self {
                messages: recording.messages(Select::only(is_shown).from(from)).peekable(),
                fleet: None,
                known: from,
            };
            from_there.advance(position);
            let found = from_there.fleet.is_some();
            player = Some(from_there);
            if found || from <= recording.span().0 {
                break;
            }
        }
        let mut player = player.unwrap_or_else(|| Self {
            messages: recording.messages(Select::only(is_shown)).peekable(),
            fleet: None,
            known: position,
        });
        player.show_something();
        player
    }

    /// A recording begins with its events, a moment before its first picture: that one is shown already.
    fn show_something(&mut self) {
        if self.fleet.is_some() {
            return;
        }
        if let Some(Ok(next)) = self.messages.peek()
            && next.topic == Some(Topic::Fleet)
        {
            self.fleet = next.json().ok();
            self.known = next.at;
        }
    }

    /// Goes on to a moment.
    pub fn advance(&mut self, to: NodeTime) -> Step {
        let mut step = Step::default();
        let (mut fleet, mut telemetry): (Option<Message>, BTreeMap<Topic, Message>) = Default::default();
        // What is damaged is passed over: the rest of the flight is there.
        let due = |next: &Result<Message, _>| next.as_ref().map_or(true, |message| message.recorded <= to);
        while let Some(next) = self.messages.next_if(due) {
            let Ok(message) = next else { continue };
            match &message.topic {
                // Of several in one step the newest is shown, so that only that one is read.
                Some(Topic::Fleet) => fleet = Some(message),
                Some(topic @ Topic::Telemetry(_)) => {
                    telemetry.insert(topic.clone(), message);
                }
                Some(Topic::Events) => step.events.extend(message.json().ok()),
                Some(Topic::Gate) => step.gate = message.json().ok().or(step.gate),
                _ => {}
            }
        }
        if let Some(message) = fleet
            && let Ok(fleet) = message.json::<FleetSnapshot>()
        {
            self.known = self.known.max(message.at);
            self.fleet = Some(fleet);
        }
        self.put_over(telemetry);
        step
    }

    fn put_over(&mut self, telemetry: BTreeMap<Topic, Message>) {
        let Some(fleet) = &mut self.fleet else { return };
        for message in telemetry.into_values().filter(|message| message.at >= fleet.time) {
            let Ok(telemetry) = message.json::<VehicleTelemetry>() else {
                continue;
            };
            // One that is not in the last whole picture comes with the next, within two seconds.
            if let Some(vehicle) = fleet.vehicles.iter_mut().find(|one| one.id == telemetry.vehicle) {
                telemetry.put_over(vehicle);
                self.known = self.known.max(message.at);
            }
        }
    }

    /// The fleet as it was shown at a moment, which is that of the last step.
    #[must_use]
    pub fn fleet(&self, at: NodeTime, sequence: u64) -> FleetSnapshot {
        let aged_from = self.known.plus_seconds(RECORDED_EVERY_S);
        let time = if at > aged_from { aged_from } else { at };
        FleetSnapshot {
            time,
            sequence,
            ..self.fleet.clone().unwrap_or_default()
        }
    }
}

fn micros(seconds: f64) -> u64 {
    // A float that is too large becomes the largest number.
    (seconds * 1e6) as u64
}
