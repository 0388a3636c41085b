//! Names of vehicles as parts of ROS 2's names, by the rule of `core/ros2`: a test holds them against each other.
//!
//! Must never do: give two vehicles one name, or change one.

use skein_domain::VehicleId;
use std::collections::BTreeMap;

const LONGEST: usize = 64;
/// The node for the swarm as a whole has this one.
const SWARM: &str = "swarm";

/// The names that vehicles have been given.
#[derive(Debug, Default)]
pub(super) struct Names {
    given: BTreeMap<VehicleId, String>,
}

impl Names {
    /// What a vehicle is called. It counts for one that has no name yet.
    pub fn named(&mut self, id: VehicleId, text: &str) {
        if self.given.contains_key(&id) {
            return;
        }
        let wanted = sanitised(text);
        let taken = |name: &str| name == SWARM || self.given.values().any(|given| given == name);
        let mut name = if wanted.is_empty() { format!("uav_{id}") } else { wanted };
        while taken(&name) {
            name = format!("{name}_id{id}");
        }
        self.given.insert(id, name);
    }

    pub fn of(&mut self, id: VehicleId) -> String {
        self.named(id, "");
        self.given.get(&id).cloned().unwrap_or_default()
    }
}

fn sanitised(text: &str) -> String {
    let mut name = String::new();
    for c in text.chars() {
        let c = if c.is_ascii_alphanumeric() { c } else { '_' };
        if name.is_empty() && c.is_ascii_digit() {
            name.push('n');
        }
        if c != '_' || (!name.is_empty() && !name.ends_with('_')) {
            name.push(c);
        }
        if name.len() >= LONGEST {
            break;
        }
    }
    name.trim_end_matches('_').to_owned()
}

pub(super) fn odom(vehicle: &str) -> String {
    format!("{vehicle}/odom")
}

pub(super) fn base_link(vehicle: &str) -> String {
    format!("{vehicle}/base_link")
}
