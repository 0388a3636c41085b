//! What is kept of a flight: whom this node flies and what by, what they fly, who has control authority over which vehicle. Moments of the node's clock are
//! counted anew after a restart.
//!
//! Must never do: keep setpoints or states. Where vehicles are after a restart, they say themselves.

use super::CLOCK_ERROR_S;
use serde::{Deserialize, Serialize};
use skein_config::NodeConfig;
use skein_coordination::Interrupted;
use skein_domain::{Geodetic, NodeTime, VehicleCommand, VehicleId};
use skein_safety::control::Entry;
use std::collections::{BTreeMap, BTreeSet};

/// What is in the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// Which node wrote it.
    pub node: String,
    /// When, by the computer's clock: microseconds since 1970.
    pub written_us: u64,
    /// When, by the node's clock.
    pub time: NodeTime,
    /// What was flown.
    pub flown: Flown,
}

/// What is flown.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Flown {
    /// Origin of the swarm's frame, in which all places are.
    pub origin: Option<Geodetic>,
    /// The formation with its members, and what is left of its route.
    pub formation: Option<Interrupted>,
    /// Who was taken out of it by an operator.
    pub withdrawn: BTreeSet<VehicleId>,
    /// Who has control authority over which vehicle, as of the node's clock.
    pub control: BTreeMap<VehicleId, Entry>,
    /// Those that this node flies by setpoints, with the operator's command that each carries out.
    pub vehicles: BTreeMap<VehicleId, Option<VehicleCommand>>,
}

/// How a node is called in its file.
#[must_use]
pub fn node_name(config: &NodeConfig) -> String {
    match (&config.swarm.id, config.swarm.node) {
        (Some(swarm), Some(node)) => format!("{} {swarm}/{node}", config.node.name),
        _ => config.node.name.clone(),
    }
}

impl Kept {
    /// What was flown, if that may be gone on with now; nothing if nobody was.
    ///
    /// # Errors
    /// Why not.
    pub fn usable(self, config: &NodeConfig, unix_us: u64) -> Result<Option<Flown>, String> {
        let me = node_name(config);
        if self.node != me {
            return Err(format!("it is of node \"{}\", and this is \"{me}\"", self.node));
        }
        if self.flown.vehicles.is_empty() {
            return Ok(None);
        }
        let age_s = (i128::from(unix_us) - i128::from(self.written_us)) as f64 * 1e-6;
        if age_s < -CLOCK_ERROR_S {
            return Err(format!(
                "it was written {:.0} s in the future: the clock was set back",
                -age_s
            ));
        }
        let within_s = config.resume.within_s;
        if age_s > within_s {
            return Err(format!(
                "it is {age_s:.0} s old, and {within_s:.0} s are permitted (resume.within_s)"
            ));
        }
        Ok(Some(
            self.flown.on_clock_that_starts(self.time.plus_seconds(age_s.max(0.0))),
        ))
    }
}

impl Flown {
    /// The same, with moments on a clock that says zero where the old one said `start`.
    fn on_clock_that_starts(mut self, start: NodeTime) -> Self {
        let behind_us = i64::try_from(start.0).map_or(i64::MIN, |us| -us);
        let moved = self.control.into_iter();
        self.control = moved
            .map(|(id, entry)| (id, entry.timed(|time| time.on_clock_ahead_by(behind_us))))
            .collect();
        self
    }
}
