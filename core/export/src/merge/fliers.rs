//! Which node flies which vehicle, as the nodes themselves say.
//!
//! Must never do: give a vehicle to two nodes at one moment.

use skein_domain::{NodeId, VehicleId};
use skein_recording::{Message, Recording, Select, Topic};
use skein_view::FleetSnapshot;
use std::collections::{BTreeMap, BTreeSet};

/// Who tells of each vehicle. A node that says that it flies one tells of it, as long as it says so; of a vehicle that none of them flies,
/// the node tells that told of it first.
pub(super) struct Fliers {
    numbers: Vec<Option<NodeId>>,
    /// By node the vehicles it says it flies.
    flies: Vec<BTreeSet<VehicleId>>,
    holders: BTreeMap<VehicleId, usize>,
}

impl Fliers {
    /// Of these recordings, and the node that each is of. Each is looked into up to its first picture of the fleet.
    pub fn new(recordings: &[Recording], nodes: &[usize]) -> Self {
        let count = nodes.iter().max().map_or(0, |most| most + 1);
        let mut fliers = Self {
            numbers: vec![None; count],
            flies: vec![BTreeSet::new(); count],
            holders: BTreeMap::new(),
        };
        let mut seen = BTreeSet::new();
        for (recording, node) in recordings.iter().zip(nodes) {
            if let Some(number) = fliers.numbers.get_mut(*node) {
                *number = recording.header().node;
            }
            if seen.insert(*node) {
                let mut fleets = recording.messages(Select::only(|topic| *topic == Topic::Fleet));
                if let Some(message) = fleets.find_map(Result::ok) {
                    fliers.see(*node, &message);
                }
            }
        }
        fliers
    }

    /// A picture of the fleet that a node has.
    pub fn see(&mut self, node: usize, message: &Message) {
        let Ok(fleet) = message.json::<FleetSnapshot>() else {
            return;
        };
        let own = self.numbers.get(node).copied().flatten();
        let is_own = |flier: Option<NodeId>| flier.is_none() || flier == own;
        let flown = fleet.vehicles.iter().filter(|vehicle| is_own(vehicle.node));
        let flown = flown.map(|vehicle| vehicle.id).collect();
        if let Some(flies) = self.flies.get_mut(node) {
            *flies = flown;
        }
    }

    /// Whether what this node says of a vehicle is what is told of it.
    pub fn tells_of(&mut self, node: usize, vehicle: VehicleId) -> bool {
        let flies = |node: usize| self.flies.get(node).is_some_and(|flown| flown.contains(&vehicle));
        let holder = self.holders.get(&vehicle).copied();
        let takes = match holder {
            None => flies(node) || !(0..self.flies.len()).any(flies),
            Some(holder) => holder == node || flies(node) && !flies(holder),
        };
        if takes {
            self.holders.insert(vehicle, node);
        }
        takes
    }
}
