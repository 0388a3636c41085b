//! Who may command which vehicle, where several people sit at several screens. Control authority over a vehicle is one console's, or nobody's:
//! then anybody may command it. That console hands it over or releases it; one that is not heard any more can be relieved by whoever asks.
//!
//! Every node keeps a table, and tells the others. Each vehicle's entry counts its changes: of two entries the later change stands, and of
//! two changes made at once that of the higher node, at all nodes alike.
//!
//! Must never do: stand between anybody and a stop. What stops, holds or brings vehicles down is for everybody at any time.

use skein_domain::control::{Console, ControlRequest, VehicleControl};
use skein_domain::{NodeId, NodeTime, Refusal, VehicleCommand, VehicleId};
use std::collections::BTreeMap;

/// A console that was not heard for so long, in seconds, can be relieved.
pub const RELIEVED_AFTER_S: f64 = 10.0;
/// A request that was not granted is forgotten after so long, in seconds.
pub const REQUEST_FOR_S: f64 = 60.0;
/// More requests for a vehicle are not kept.
const MOST_REQUESTS: usize = 8;
/// More consoles are not known at a time: the one not heard for the longest makes room.
const MOST_CONSOLES: usize = 256;

/// What is known of one vehicle's control. Sent from node to node.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Entry {
    /// Grows with every change.
    pub change: u64,
    /// Where it was changed.
    pub node: u64,
    /// Who has it, and since when.
    pub holder: Option<(Console, NodeTime)>,
    /// Who asks for it, the first first.
    pub requests: Vec<ControlRequest>,
}

impl Entry {
    /// The same, with its times put on another clock.
    #[must_use]
    pub fn timed(mut self, on: impl Fn(NodeTime) -> NodeTime) -> Self {
        if let Some((_, since)) = &mut self.holder {
            *since = on(*since);
        }
        for request in &mut self.requests {
            request.since = on(request.since);
        }
        self
    }

    fn outranks(&self, other: &Self) -> bool {
        (self.change, self.node) > (other.change, other.node)
    }
}

/// Who has control authority over which vehicles, as one node knows it.
#[derive(Debug, Clone, Default)]
pub struct ControlTable {
    node: u64,
    entries: BTreeMap<VehicleId, Entry>,
    heard: BTreeMap<String, Heard>,
}

/// When a console was last heard, and where.
#[derive(Debug, Clone, Copy)]
struct Heard {
    at: NodeTime,
    here: bool,
}

/// Whether a command may come from anybody, whoever has control authority over the vehicle: it stops, or ends a flight safely.
#[must_use]
pub fn is_for_everybody(command: &VehicleCommand) -> bool {
    matches!(
        command,
        VehicleCommand::Hold | VehicleCommand::Land | VehicleCommand::Return | VehicleCommand::StopObserving
    )
}

impl ControlTable {
    /// Nobody has control authority.
    #[must_use]
    pub fn new(node: NodeId) -> Self {
        Self {
            node: node.0,
            ..Self::default()
        }
    }

    /// A console gives a sign of life at this node.
    pub fn hear(&mut self, console: &str, at: NodeTime) {
        self.note(console, Heard { at, here: true });
    }

    /// A console gave a sign of life at another node.
    pub fn hear_elsewhere(&mut self, console: &str, at: NodeTime) {
        self.note(console, Heard { at, here: false });
    }

    /// The consoles that are there by what this node hears, for the others.
    #[must_use]
    pub fn heard_here(&self, now: NodeTime) -> Vec<(String, NodeTime)> {
        let present = |heard: &Heard| now.seconds_since(heard.at) < RELIEVED_AFTER_S;
        let here = self.heard.iter().filter(|(_, heard)| heard.here && present(heard));
        here.map(|(id, heard)| (id.clone(), heard.at)).collect()
    }

    fn note(&mut self, console: &str, heard: Heard) {
        if let Some(known) = self.heard.get_mut(console) {
            if known.at <= heard.at {
                *known = heard;
            }
            return;
        }
        if self.heard.len() >= MOST_CONSOLES
            && let Some(oldest) = self
                .heard
                .iter()
                .min_by_key(|(_, heard)| heard.at)
                .map(|(id, _)| id.clone())
        {
            self.heard.remove(&oldest);
        }
        self.heard.insert(console.to_owned(), heard);
    }

    /// Takes control authority over a vehicle over which nobody has it, or whose holder is not heard any more. Who has it already may have another name since.
    ///
    /// # Errors
    /// Somebody has it.
    pub fn take(&mut self, vehicle: VehicleId, console: &Console, now: NodeTime) -> Result<(), Refusal> {
        self.hear(&console.id, now);
        match self.entries.get(&vehicle).and_then(|entry| entry.holder.as_ref()) {
            Some((holder, _)) if holder == console => return Ok(()),
            Some((holder, since)) if holder.id == console.id => {
                let since = *since;
                self.change(vehicle, |entry| entry.holder = Some((console.clone(), since)));
                return Ok(());
            }
            _ => {}
        }
        self.may(vehicle, Some(&console.id), now)?;
        self.change(vehicle, |entry| {
            entry.holder = Some((console.clone(), now));
            entry.requests.retain(|request| request.console.id != console.id);
        });
        Ok(())
    }

    /// Asks for a vehicle: who has it is told. Taken at once if nobody has it.
    ///
    /// # Errors
    /// Too many ask for it already.
    pub fn request(&mut self, vehicle: VehicleId, console: &Console, now: NodeTime) -> Result<(), Refusal> {
        if self.take(vehicle, console, now).is_ok() {
            return Ok(());
        }
        let fresh = |request: &ControlRequest| now.seconds_since(request.since) < REQUEST_FOR_S;
        let asked = self.entries.get(&vehicle).map(|entry| &entry.requests);
        if asked.is_some_and(|all| all.iter().any(|r| fresh(r) && r.console.id == console.id)) {
            return Ok(());
        }
        if asked.is_some_and(|all| all.iter().filter(|r| fresh(r)).count() >= MOST_REQUESTS) {
            return Err(Refusal::not_permitted(format!(
                "{MOST_REQUESTS} others ask for vehicle {vehicle} already"
            )));
        }
        self.change(vehicle, |entry| {
            entry.requests.retain(fresh);
            entry.requests.retain(|request| request.console.id != console.id);
            entry.requests.push(ControlRequest {
                console: console.clone(),
                since: now,
            });
        });
        Ok(())
    }

    /// Gives a vehicle that this console has to one that asks for it.
    ///
    /// # Errors
    /// It is not under this console's control, or the other does not ask for it.
    pub fn hand_over(&mut self, vehicle: VehicleId, from: &str, to: &str, now: NodeTime) -> Result<(), Refusal> {
        self.hear(from, now);
        if !self.holds(vehicle, from) {
            return Err(not_yours(vehicle));
        }
        let asks = |entry: &Entry| entry.requests.iter().find(|r| r.console.id == to).cloned();
        let Some(request) = self.entries.get(&vehicle).and_then(asks) else {
            return Err(Refusal::not_permitted(format!(
                "that console does not ask for vehicle {vehicle}"
            )));
        };
        self.change(vehicle, |entry| {
            entry.requests.retain(|r| r.console.id != to);
            entry.holder = Some((request.console, now));
        });
        Ok(())
    }

    /// Releases a vehicle: nobody has control authority over it, or who asked first and is heard.
    ///
    /// # Errors
    /// It is not under this console's control.
    pub fn release(&mut self, vehicle: VehicleId, console: &str, now: NodeTime) -> Result<(), Refusal> {
        if !self.holds(vehicle, console) {
            return Err(not_yours(vehicle));
        }
        let present: Vec<String> = self
            .heard
            .keys()
            .filter(|id| self.is_present(id, now))
            .cloned()
            .collect();
        self.change(vehicle, |entry| {
            let next = entry.requests.iter().position(|r| present.contains(&r.console.id));
            entry.holder = next.map(|at| (entry.requests.remove(at).console, now));
        });
        Ok(())
    }

    /// Whether a console (none: a program that says of itself nothing) may command a vehicle.
    ///
    /// # Errors
    /// Another one has control authority over it.
    pub fn may(&self, vehicle: VehicleId, console: Option<&str>, now: NodeTime) -> Result<(), Refusal> {
        let Some(holder) = self.holder(vehicle) else {
            return Ok(());
        };
        if console == Some(holder.id.as_str()) || !self.is_present(&holder.id, now) {
            return Ok(());
        }
        Err(Refusal::NoControlAuthority {
            vehicle,
            holder: holder.name.clone(),
        })
    }

    /// Takes up what another node knows, with its clock put on ours.
    pub fn merge(&mut self, told: impl IntoIterator<Item = (VehicleId, Entry)>) {
        for (vehicle, entry) in told {
            let known = self.entries.entry(vehicle).or_default();
            if entry.outranks(known) {
                *known = entry;
            }
        }
    }

    /// What other nodes have to know.
    #[must_use]
    pub fn entries(&self) -> &BTreeMap<VehicleId, Entry> {
        &self.entries
    }

    /// Who has control authority over what, by ascending vehicle.
    #[must_use]
    pub fn picture(&self, now: NodeTime) -> Vec<VehicleControl> {
        let shown = |(vehicle, entry): (&VehicleId, &Entry)| {
            let (console, since) = entry.holder.clone()?;
            let fresh = |request: &&ControlRequest| now.seconds_since(request.since) < REQUEST_FOR_S;
            Some(VehicleControl {
                vehicle: *vehicle,
                is_heard: self.is_present(&console.id, now),
                console,
                since,
                requests: entry.requests.iter().filter(fresh).cloned().collect(),
            })
        };
        self.entries.iter().filter_map(shown).collect()
    }

    /// Who has control authority over a vehicle, heard or not.
    #[must_use]
    pub fn holder(&self, vehicle: VehicleId) -> Option<&Console> {
        self.entries.get(&vehicle)?.holder.as_ref().map(|(holder, _)| holder)
    }

    fn holds(&self, vehicle: VehicleId, console: &str) -> bool {
        self.holder(vehicle).is_some_and(|holder| holder.id == console)
    }

    fn is_present(&self, console: &str, now: NodeTime) -> bool {
        let heard = self.heard.get(console);
        heard.is_some_and(|heard| now.seconds_since(heard.at) < RELIEVED_AFTER_S)
    }

    fn change(&mut self, vehicle: VehicleId, with: impl FnOnce(&mut Entry)) {
        let entry = self.entries.entry(vehicle).or_default();
        with(entry);
        entry.change += 1;
        entry.node = self.node;
    }
}

fn not_yours(vehicle: VehicleId) -> Refusal {
    Refusal::not_permitted(format!("vehicle {vehicle} is not under this console's control"))
}

#[cfg(test)]
mod tests;
