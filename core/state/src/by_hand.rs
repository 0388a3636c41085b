//! Vehicles flown by hand: for each of this node's own, whether it is and the newest stick for it; for those of other nodes, what is on its way to
//! them.
//!
//! Bound: one stick per vehicle, the newest. Must never do: keep a stick for later, or let one be followed that is old.

use parking_lot::Mutex;
use skein_domain::stick::STICK_GOOD_S;
use skein_domain::{CommandId, NodeTime, Refusal, Stick, VehicleId};
use std::collections::BTreeMap;

/// A stick that no control period has taken up within so long is dropped, in seconds: the actor or its model was away.
const TAKEN_UP_WITHIN_S: f64 = 0.2;
/// What another node last refused is told to whoever steers for so long, in seconds.
const REFUSAL_TOLD_S: f64 = 1.0;

/// Whether one of this node's vehicles is flown by hand, and the newest stick for it.
#[derive(Debug, Default)]
pub struct Hand {
    command: Option<CommandId>,
    stick: Option<(Stick, NodeTime)>,
}

impl Hand {
    /// The vehicle is flown by hand from now on.
    pub fn begin(&mut self, command: CommandId) {
        *self = Self {
            command: Some(command),
            stick: None,
        };
    }

    /// Whether it is flown by hand because of this command.
    pub fn is_by(&self, command: CommandId) -> bool {
        self.command == Some(command)
    }

    /// That command is over.
    pub fn end(&mut self, command: CommandId) {
        if self.command == Some(command) {
            *self = Self::default();
        }
    }

    /// The vehicle does something else, whatever was said of the command.
    pub fn end_any(&mut self) {
        *self = Self::default();
    }

    /// A stick came in; whether somebody steers the vehicle. The newest replaces what waits.
    pub fn put(&mut self, stick: Stick, now: NodeTime) -> bool {
        if self.command.is_some() {
            self.stick = Some((stick, now));
        }
        self.command.is_some()
    }

    /// The stick for this control period, if a new one came.
    pub fn take(&mut self, now: NodeTime) -> Option<Stick> {
        let (stick, at) = self.stick.take()?;
        (now.seconds_since(at) <= TAKEN_UP_WITHIN_S).then_some(stick)
    }
}

/// Sticks on their way to vehicles of other nodes.
#[derive(Debug, Default)]
pub struct Relays(Mutex<BTreeMap<VehicleId, Relay>>);

#[derive(Debug, Default)]
struct Relay {
    /// One has been told and is not answered yet.
    under_way: bool,
    /// The newest that was not told yet, and when it came.
    waiting: Option<(Stick, NodeTime)>,
    /// What the other node last said no with, and when.
    refused: Option<(Refusal, NodeTime)>,
}

impl Relays {
    /// A stick came in: whether somebody has to begin to tell what waits, and what the node that flies the vehicle last said no with.
    pub fn put(&self, vehicle: VehicleId, stick: Stick, now: NodeTime) -> (bool, Result<(), Refusal>) {
        let mut relays = self.0.lock();
        let relay = relays.entry(vehicle).or_default();
        relay.waiting = Some((stick, now));
        let begins = !std::mem::replace(&mut relay.under_way, true);
        relay.refused.take_if(|(_, at)| now.seconds_since(*at) > REFUSAL_TOLD_S);
        let last = relay
            .refused
            .as_ref()
            .map_or(Ok(()), |(refusal, _)| Err(refusal.clone()));
        (begins, last)
    }

    /// What is to be told next, and when it came. With nothing that waits whoever told it is done.
    pub fn next(&self, vehicle: VehicleId) -> Option<(Stick, NodeTime)> {
        let mut relays = self.0.lock();
        let relay = relays.get_mut(&vehicle)?;
        let next = relay.waiting.take();
        relay.under_way = next.is_some();
        next
    }

    /// What the other node said to the last one.
    pub fn answered(&self, vehicle: VehicleId, outcome: Result<(), Refusal>, now: NodeTime) {
        if let Some(relay) = self.0.lock().get_mut(&vehicle) {
            relay.refused = outcome.err().map(|refusal| (refusal, now));
        }
    }
}

/// Whether a stick that was told by another node, at that time of its clock, has come in time. This node's clock is ahead of that one by so many
/// microseconds, if that was measured.
///
/// # Errors
/// For one that was too long on its way, and where that cannot be known.
pub fn in_time(told: NodeTime, ahead_us: Option<i64>, now: NodeTime) -> Result<(), Refusal> {
    let unknown = |detail: &str| Refusal::Clock { detail: detail.into() };
    let ahead_us = ahead_us.ok_or_else(|| unknown("how far the clocks of the two nodes are apart is not known yet"))?;
    let age_s = now.seconds_since(told.on_clock_ahead_by(ahead_us));
    if age_s > STICK_GOOD_S {
        return Err(Refusal::timed_out("a stick on its way", age_s));
    }
    // A clock that has gone wrong would make an old one look new.
    if age_s < -STICK_GOOD_S {
        return Err(unknown(
            "a stick comes from the future: the clocks of the two nodes have gone apart",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
