//! `[swarm]`: the swarm that a node is part of, how it reaches the others, and what makes these values wrong.
//!
//! Must never do: hold the secret itself; only the file it is in.

use crate::problem::Problem;
use serde::{Deserialize, Serialize};
use skein_domain::Geodetic;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// `[swarm]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SwarmSettings {
    /// Origin of the common frame; unset: the first vehicle's place.
    pub origin: Option<Geodetic>,
    /// The swarm this node is part of; unset: it flies its vehicles alone.
    pub id: Option<String>,
    /// This node's number in it.
    pub node: Option<u64>,
    /// File with the secret all its nodes share; relative ones from the folder of the configuration file.
    pub secret_file: Option<PathBuf>,
    /// How suited it is to coordinate, greater is better; unset: it never does.
    pub coordinator_priority: Option<u8>,
    /// It watches, and commands nothing.
    pub observer: bool,
    /// Where the coordinator that it obeys is kept over a restart; unset: beside the configuration file.
    pub state_file: Option<PathBuf>,
    /// Who may take over when the swarm has come apart.
    pub apart: Apart,
    /// How many nodes the swarm has, for a majority; unset: as many as have been heard.
    pub members: Option<usize>,
    /// A coordinator without a sign of life for so long is replaced, in seconds.
    pub lost_after_s: f64,
    /// How the others are reached: one, or two of which one stands in for the other.
    pub transports: Vec<SwarmTransport>,
    /// What this node sends at most, in bytes per second.
    pub max_bytes_per_s: f64,
    /// `[swarm.zenoh]`
    pub zenoh: ZenohSettings,
}

impl Default for SwarmSettings {
    fn default() -> Self {
        Self {
            origin: None,
            id: None,
            node: None,
            secret_file: None,
            coordinator_priority: None,
            observer: false,
            state_file: None,
            apart: Apart::EveryPart,
            members: None,
            lost_after_s: 0.5,
            transports: vec![SwarmTransport::Zenoh],
            max_bytes_per_s: 1_000_000.0,
            zenoh: ZenohSettings::default(),
        }
    }
}

/// Who may take over when the swarm has come apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Apart {
    /// Every part has a coordinator of its own.
    #[default]
    EveryPart,
    /// Only a part with more than half of the swarm.
    Majority,
}

/// How other nodes are reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SwarmTransport {
    /// Zenoh: peer to peer on a LAN, routed and over TLS or QUIC beyond it.
    Zenoh,
    /// DDS, as ROS 2 uses it.
    Dds,
}

impl std::fmt::Display for SwarmTransport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Zenoh => "zenoh",
            Self::Dds => "dds",
        })
    }
}

/// `[swarm.zenoh]`
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ZenohSettings {
    /// Where to listen, as Zenoh writes endpoints: `udp/0.0.0.0:7447`, `tls/[::]:7447`.
    pub listen: Vec<String>,
    /// Whom to connect to: other nodes, or a router. One that is not there yet is tried again.
    pub connect: Vec<String>,
    /// Whether to look for others on the LAN by multicast, and be found.
    pub multicast: bool,
    /// Anything else of Zenoh's configuration, as key and JSON5 value: `transport/link/tls/root_ca_certificate` = `"\"ca.pem\""`.
    pub extra: BTreeMap<String, String>,
}

impl Default for ZenohSettings {
    /// Only this host.
    fn default() -> Self {
        Self {
            listen: vec!["tcp/127.0.0.1:0".to_owned()],
            connect: Vec::new(),
            multicast: false,
            extra: BTreeMap::new(),
        }
    }
}

impl SwarmSettings {
    /// Everything that is wrong with it.
    pub(crate) fn problems(&self, problems: &mut Vec<Problem>) {
        let mut wrong = |key: &str, message: &str| {
            problems.push(Problem {
                key: format!("swarm.{key}"),
                message: message.into(),
            });
        };
        if self.origin.is_some_and(|origin| !origin.is_valid()) {
            wrong("origin", "not a place on Earth");
        }
        let Some(id) = &self.id else { return };
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if id.is_empty() || id.len() > 64 || !id.chars().all(letter) {
            wrong("id", "choose 1 to 64 letters, digits, - and _");
        }
        if self.node.unwrap_or(0) == 0 {
            wrong("node", "give each node of the swarm a number of its own, from 1");
        }
        if self.secret_file.is_none() {
            let message = "name the file with the swarm's secret; `skein swarm new-secret FILE` makes one";
            wrong("secret_file", message);
        }
        if self.observer && self.coordinator_priority.is_some() {
            wrong(
                "observer",
                "an observer cannot coordinate: leave out coordinator_priority",
            );
        }
        if !(0.2..=10.0).contains(&self.lost_after_s) {
            wrong("lost_after_s", "is not between 0.2 and 10");
        }
        if !(1_000.0..=1e9).contains(&self.max_bytes_per_s) {
            wrong("max_bytes_per_s", "is not between 1000 and 1e9");
        }
        if self.members.is_some_and(|members| !(1..=1024).contains(&members)) {
            wrong("members", "is not between 1 and 1024");
        }
        let twice = self.transports.first() == self.transports.get(1);
        if self.transports.is_empty() || self.transports.len() > 2 || twice {
            wrong("transports", "name one of \"zenoh\" and \"dds\", or both");
        }
    }
}

#[cfg(test)]
mod tests;
