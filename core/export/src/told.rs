//! What a recording tells, as values, in its order: the one place where exports read.
//!
//! Must never do: end at something that cannot be read while there is more.

use crate::{Progress, origin};
use skein_domain::NodeTime;
use skein_recording::{Damage, Message, Recording, Select, SetpointRecord, Topic, VehicleTelemetry};
use skein_view::{EventRecord, FleetSnapshot};
use std::collections::BTreeSet;

/// So many messages lie between two reports of progress.
const REPORT_EVERY: u64 = 2_000;

/// What is told.
#[derive(Debug, Clone)]
pub(crate) enum Kind {
    /// Everything a screen shows: here for the names of vehicles and where they were launched.
    Fleet(Box<FleetSnapshot>),
    /// What is known of a vehicle.
    Telemetry(Box<VehicleTelemetry>),
    /// A setpoint.
    Setpoint(Box<SetpointRecord>),
    /// An event.
    Event(Box<EventRecord>),
}

/// Something that is told.
#[derive(Debug, Clone)]
pub(crate) struct Told {
    /// When it was recorded, in nanoseconds since 1970.
    pub recorded_ns: u64,
    /// When it happened, in nanoseconds since 1970.
    pub at_ns: u64,
    /// The same in seconds from the beginning of the recording; before it below zero.
    pub time_s: f64,
    /// The node that tells, as its topic names it; `None` for that of the file.
    pub node: Option<String>,
    /// What.
    pub kind: Kind,
}

impl Told {
    /// A moment on the clock of who tells, in nanoseconds since 1970, told by how far it is from another.
    pub fn moment_ns(&self, told: NodeTime, moment: NodeTime) -> u64 {
        let shift_ns = (i128::from(moment.0) - i128::from(told.0)) * 1_000;
        u64::try_from((i128::from(self.at_ns) + shift_ns).max(0)).unwrap_or(u64::MAX)
    }
}

/// What could not be read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Unread {
    /// Messages that are not what their topic says.
    pub messages: u64,
    /// Parts of the file.
    pub damage: Vec<Damage>,
}

/// Tells everything of the wanted topics to `take`, until it fails.
pub(crate) fn each<E>(
    recording: &Recording,
    wants: fn(&Topic) -> bool,
    progress: Progress<'_>,
    mut take: impl FnMut(&Told) -> Result<(), E>,
) -> Result<Unread, E> {
    let (first, last) = recording.span();
    let length_s = last.seconds_since(first).max(1e-6);
    let tellers = tellers(recording);
    let select = Select {
        foreign: true,
        ..Select::only(wants)
    };
    let (mut unread, mut count) = (Unread::default(), 0_u64);
    for message in recording.messages(select) {
        let message = match message {
            Ok(message) => message,
            Err(damage) => {
                unread.damage.push(damage);
                continue;
            }
        };
        let Some((node, topic)) = origin::parse(&message.name).filter(|(_, topic)| wants(topic)) else {
            continue;
        };
        if count.is_multiple_of(REPORT_EVERY) {
            progress(message.recorded.seconds_since(first) / length_s);
        }
        count += 1;
        match kind(&message, &topic, node.is_some()) {
            Some(Ok(kind)) => {
                let base = recording.header().base;
                let told = Told {
                    recorded_ns: base.unix_ns(message.recorded),
                    at_ns: base.unix_ns(message.at),
                    time_s: message.at.seconds_since(first),
                    node: node.map(str::to_owned),
                    kind,
                };
                if !is_told_twice(&told, &tellers) {
                    take(&told)?;
                }
            }
            Some(Err(_)) => unread.messages += 1,
            None => {}
        }
    }
    progress(1.0);
    Ok(unread)
}

/// The nodes whose own events are in the file, as its topics name them.
fn tellers(recording: &Recording) -> BTreeSet<String> {
    let names = recording.topics().filter_map(|(info, _)| {
        let (node, topic) = origin::parse(&info.name)?;
        (topic == Topic::Events).then(|| node.map(str::to_owned))?
    });
    let own = recording.header().node.map(|node| node.0.to_string());
    names.chain(own).collect()
}

/// An event of another node, whose own word is in the file too.
fn is_told_twice(told: &Told, tellers: &BTreeSet<String>) -> bool {
    match &told.kind {
        Kind::Event(event) => event.node.is_some_and(|node| tellers.contains(&node.0.to_string())),
        _ => false,
    }
}

/// `None` for what is not told on: a vehicle as a node saw it that did not fly it.
fn kind(message: &Message, topic: &Topic, of_other: bool) -> Option<Result<Kind, serde_json::Error>> {
    match topic {
        Topic::Fleet => Some(message.json().map(Box::new).map(Kind::Fleet)),
        Topic::Events => Some(message.json().map(Box::new).map(Kind::Event)),
        Topic::Telemetry(_) if !of_other => Some(message.json().map(Box::new).map(Kind::Telemetry)),
        Topic::Setpoint(_) if !of_other => Some(message.json().map(Box::new).map(Kind::Setpoint)),
        _ => None,
    }
}
