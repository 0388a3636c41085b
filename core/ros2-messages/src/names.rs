//! Names: which namespace a vehicle has, what its topics and frames are called.
//!
//! A vehicle of the name `uav-3` has the namespace `/skein/uav_3`, its node is `/skein/uav_3/vehicle` and its frames are `uav_3/odom` and
//! `uav_3/base_link`. The node for the swarm as a whole is `/skein/swarm`.
//!
//! Must never do: give two vehicles one name, or change a vehicle's name while it is there.

use skein_domain::VehicleId;
use std::collections::BTreeMap;

/// Base name of each vehicle's node.
pub const VEHICLE_NODE: &str = "vehicle";
/// Base name of the node for the swarm as a whole.
pub const SWARM_NODE: &str = "swarm";
/// No name is longer: with namespace and topic it has to stay below the 255 letters that DDS allows.
const LONGEST: usize = 64;

/// Any text as one part of a name of ROS 2: letters, digits and single underscores, not beginning with a digit. Empty if nothing is left.
#[must_use]
pub fn sanitised(text: &str) -> String {
    let mut name = String::new();
    for c in text.chars() {
        let c = if c.is_ascii_alphanumeric() { c } else { '_' };
        if name.is_empty() && c.is_ascii_digit() {
            name.push('n');
        }
        // Neither two underscores in a row nor one at the start: ROS 2 hides such names.
        if c != '_' || (!name.is_empty() && !name.ends_with('_')) {
            name.push(c);
        }
        if name.len() >= LONGEST {
            break;
        }
    }
    name.trim_end_matches('_').to_owned()
}

/// The names that vehicles have been given.
#[derive(Debug, Default)]
pub struct Names {
    given: BTreeMap<VehicleId, String>,
}

impl Names {
    /// The name of a vehicle; the same one each time. One that another vehicle, or the swarm's node, has already is told apart by the id.
    pub fn of(&mut self, id: VehicleId, text: &str) -> String {
        if let Some(name) = self.given.get(&id) {
            return name.clone();
        }
        let wanted = sanitised(text);
        let taken = |name: &str| name == SWARM_NODE || self.given.values().any(|given| given == name);
        let mut name = if wanted.is_empty() { format!("uav_{id}") } else { wanted };
        while taken(&name) {
            name = format!("{name}_id{id}");
        }
        self.given.insert(id, name.clone());
        name
    }
}

/// Frame of a vehicle that does not turn with it.
#[must_use]
pub fn odom(vehicle: &str) -> String {
    format!("{vehicle}/odom")
}

/// Frame of a vehicle.
#[must_use]
pub fn base_link(vehicle: &str) -> String {
    format!("{vehicle}/base_link")
}

#[cfg(test)]
mod tests;
