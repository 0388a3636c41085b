//! The swarm as screens see it: its nodes, whom each obeys, how the links between them are.
//!
//! Must never do: say who coordinates by itself; the lease does.

use serde::{Deserialize, Serialize};
use skein_domain::{NodeId, VehicleId};

/// What a node does in its swarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NodeRole {
    /// It flies vehicles.
    VehicleHost,
    /// It can coordinate.
    Coordinator,
    /// It serves dashboard and API.
    Gateway,
    /// It watches, and commands nothing.
    Observer,
}

impl NodeRole {
    /// All of them, in the order of their bits on a card.
    pub const ALL: [Self; 4] = [Self::VehicleHost, Self::Coordinator, Self::Gateway, Self::Observer];

    /// Several of them as bits.
    #[must_use]
    pub fn to_bits(roles: &[Self]) -> u8 {
        let set = |(i, role): (usize, &Self)| u8::from(roles.contains(role)) << i;
        Self::ALL.iter().enumerate().map(set).sum()
    }

    /// The roles that these bits say.
    #[must_use]
    pub fn from_bits(bits: u8) -> Vec<Self> {
        let is_set = |(i, _): &(usize, Self)| bits >> i & 1 == 1;
        Self::ALL
            .into_iter()
            .enumerate()
            .filter(is_set)
            .map(|(_, role)| role)
            .collect()
    }
}

/// A term of the leadership.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
pub struct TermSnapshot {
    /// Grows with every change of the coordinator.
    pub number: u64,
    /// The node that coordinates in it.
    pub coordinator: NodeId,
}

/// Whom a node obeys.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LeaderStateKind {
    /// Nobody yet.
    #[default]
    Nobody,
    /// A coordinator that is there.
    Led,
    /// A coordinator that is silent; a successor is awaited.
    Awaiting,
    /// A coordinator that has been silent for long.
    Unled,
}

/// The swarm as one of its nodes knows it.
#[derive(
    Debug,
    Clone,
    PartialEq,
    Default,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
pub struct SwarmSnapshot {
    /// The swarm's id.
    pub swarm: String,
    /// This node's number.
    pub node: NodeId,
    /// Its name.
    pub name: String,
    /// What it does.
    pub roles: Vec<NodeRole>,
    /// Whom it obeys.
    pub leader_state: LeaderStateKind,
    /// The term it obeys.
    pub term: Option<TermSnapshot>,
    /// How long the obeyed coordinator has been silent, in seconds, if it is.
    pub silent_s: Option<f64>,
    /// It coordinates.
    pub acting: bool,
    /// It hears no other node, though it did.
    pub cut_off: bool,
    /// The other nodes, by number.
    pub nodes: Vec<NodeSnapshot>,
    /// What it sends, in bytes per second.
    pub sent_bytes_per_s: f64,
    /// What it may send at this moment, in bytes per second.
    pub limit_bytes_per_s: f64,
    /// Datagrams that were not of this swarm, or changed on the way.
    pub strangers: u64,
    /// Datagrams that had been there before.
    pub replayed: u64,
    /// The transport says that it is down: why.
    pub transport_fault: Option<String>,
    /// If the others are reached in two ways at once: each of them.
    pub ways: Vec<WaySnapshot>,
}

/// One of two ways to the others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct WaySnapshot {
    /// The transport.
    pub name: String,
    /// It takes what is sent.
    pub up: bool,
    /// Why it does not.
    pub fault: Option<String>,
    /// What goes over it, in bytes per second.
    pub sent_bytes_per_s: f64,
    /// What comes over it, in bytes per second.
    pub received_bytes_per_s: f64,
    /// How long ago something last came over it, in seconds, if anything ever did.
    pub heard_s: Option<f64>,
}

/// Another node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct NodeSnapshot {
    /// Its number.
    pub node: NodeId,
    /// Its name.
    pub name: String,
    /// What it does.
    pub roles: Vec<NodeRole>,
    /// Version of its program.
    pub version: String,
    /// How long ago it was heard, in seconds.
    pub heard_s: f64,
    /// The term it obeys.
    pub obeys: Option<TermSnapshot>,
    /// The vehicles it flies.
    pub vehicles: Vec<VehicleId>,
    /// Its swarm frame is another one: it takes no orders from here.
    pub other_frame: bool,
    /// Round trip to it in seconds.
    pub round_trip_s: Option<f64>,
    /// Its clock less this node's, in seconds.
    pub clock_offset_s: Option<f64>,
    /// How far off that may be, in seconds.
    pub clock_error_s: Option<f64>,
    /// What it tells of its clock does not fit to when it comes.
    pub clock_fault: bool,
    /// What is received of it, in bytes per second.
    pub received_bytes_per_s: f64,
    /// Share of what it sent to all that did not come here, 0..=1, over the last ten seconds; absent if it does not tell what it sends.
    pub loss: Option<f64>,
}
