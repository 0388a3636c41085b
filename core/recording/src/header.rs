//! What a recording says of itself at its beginning: which node, which program, and how its node's time is told in time of day.
//!
//! Must never do: hold a secret of the swarm.

use serde::{Deserialize, Serialize};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;

/// The version of what is written on the topics. It grows when a reader of the one before would misunderstand.
pub const FORMAT: u32 = 1;
/// The name of the metadata record that holds a [`Header`].
pub const METADATA: &str = "skein";

/// Node time told in time of day. It is fixed when a recording begins: a clock that is set in flight moves nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimeBase {
    /// A moment on the node's clock.
    pub node: NodeTime,
    /// The same moment, in nanoseconds since 1970 (UTC).
    pub unix_ns: u64,
}

impl TimeBase {
    /// A moment in nanoseconds since 1970.
    #[must_use]
    pub fn unix_ns(&self, at: NodeTime) -> u64 {
        let since_ns = (i128::from(at.0) - i128::from(self.node.0)) * 1_000;
        let told = i128::from(self.unix_ns) + since_ns;
        u64::try_from(told.max(0)).unwrap_or(u64::MAX)
    }

    /// The moment on the node's clock.
    #[must_use]
    pub fn node_time(&self, unix_ns: u64) -> NodeTime {
        let since_us = (i128::from(unix_ns) - i128::from(self.unix_ns)) / 1_000;
        let told = i128::from(self.node.0) + since_us;
        NodeTime(u64::try_from(told.max(0)).unwrap_or(u64::MAX))
    }
}

/// What a recording says of itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// [`FORMAT`] of who wrote it.
    pub format: u32,
    /// Version of the program.
    pub version: String,
    /// The node's number in its swarm, if it is in one.
    pub node: Option<NodeId>,
    /// The node's name.
    pub name: String,
    /// The swarm's id; empty without a swarm.
    pub swarm: String,
    /// How its time is told.
    pub base: TimeBase,
}

impl Header {
    /// As it stands in the file, in the metadata called [`METADATA`].
    #[must_use]
    pub fn to_map(&self) -> BTreeMap<String, String> {
        let pairs = [
            ("format", self.format.to_string()),
            ("version", self.version.clone()),
            ("node", self.node.map_or_else(String::new, |node| node.0.to_string())),
            ("name", self.name.clone()),
            ("swarm", self.swarm.clone()),
            ("node_us", self.base.node.0.to_string()),
            ("unix_ns", self.base.unix_ns.to_string()),
        ];
        pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
    }

    /// `None` if something is missing or is no number.
    pub(crate) fn from_map(map: &BTreeMap<String, String>) -> Option<Self> {
        let text = |key: &str| map.get(key).cloned();
        let number = |key: &str| map.get(key)?.parse::<u64>().ok();
        Some(Self {
            format: map.get("format")?.parse().ok()?,
            version: text("version")?,
            node: number("node").map(NodeId),
            name: text("name")?,
            swarm: text("swarm")?,
            base: TimeBase {
                node: NodeTime(number("node_us")?),
                unix_ns: number("unix_ns")?,
            },
        })
    }
}
