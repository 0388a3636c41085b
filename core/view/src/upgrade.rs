//! What is told of upgrades: which version a node runs, how far a roll-out has come, why something was refused.
//!
//! Must never do: decide which version runs, or say of one on trial that it stays.

use serde::{Deserialize, Serialize};
use skein_domain::{NodeId, VehicleId};
use thiserror::Error;

/// A version of the program, by name and content.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct VersionLabel {
    /// As it was packed; of the installed package, as it was built.
    pub version: String,
    /// SHA-256 of its archive; absent for the installed package.
    pub digest: Option<String>,
}

/// A version that did not stay, and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct GoneBack {
    /// Which.
    pub from: VersionLabel,
    /// Why.
    pub why: String,
}

/// The versions of one node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct NodeVersions {
    /// Its processor, as `x86_64` or `aarch64`.
    pub architecture: String,
    /// What it runs.
    pub runs: VersionLabel,
    /// What it runs has not confirmed itself yet.
    pub on_trial: bool,
    /// What is to be started next, on trial.
    pub pending: Option<VersionLabel>,
    /// What it ran before.
    pub before: Option<VersionLabel>,
    /// The last version that went back.
    pub gone_back: Option<GoneBack>,
    /// Why the last swap was broken off before it began.
    pub broken_off: Option<UpgradeRefusal>,
    /// A version on trial has so long to confirm itself, in seconds.
    pub confirm_within_s: f64,
}

/// An archive with a version for one kind of processor.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct ArchiveInfo {
    /// SHA-256 of the whole archive.
    pub digest: String,
    /// As it was packed.
    pub version: String,
    /// For which processor.
    pub architecture: String,
    /// Its size.
    pub bytes: u64,
    /// The size of what is in it.
    pub unpacked_bytes: u64,
}

/// What a roll-out is for.
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
#[serde(rename_all = "snake_case")]
pub enum RolloutKind {
    /// Nodes get a new version.
    Upgrade,
    /// Nodes go back to the version before.
    Back,
}

/// How far one node is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum NodeUpgradeState {
    /// It has not been its turn yet.
    Waiting,
    /// The archive is on its way.
    Sending {
        /// So much is there.
        sent_bytes: u64,
        /// Of so much.
        of_bytes: u64,
    },
    /// It is unpacked and checked there.
    Unpacking,
    /// The node is told to start it, and starts.
    Starting,
    /// It runs there and has not confirmed itself yet.
    OnTrial,
    /// It runs there and stays.
    Confirmed,
    /// It did not stay: the node runs what it ran before.
    GoneBack {
        /// Why.
        why: String,
    },
    /// The node refused; it runs what it ran before.
    Refused {
        /// Why.
        refusal: UpgradeRefusal,
    },
    /// The node did not answer; nothing was begun there.
    NotReachable {
        /// What happened.
        why: String,
    },
    /// The node has not been heard since it was told to start another version.
    Lost {
        /// For how long, in seconds.
        silent_s: f64,
    },
    /// The roll-out ended before its turn.
    Skipped,
}

/// One node of a roll-out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct NodeUpgrade {
    /// Its number.
    pub node: NodeId,
    /// What it is called.
    pub name: String,
    /// How far it is.
    pub progress: NodeUpgradeState,
    /// Its versions, as it last told.
    pub versions: Option<NodeVersions>,
}

/// How a roll-out ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "end", rename_all = "snake_case")]
pub enum RolloutEnd {
    /// Each node has had its turn.
    Done,
    /// It stopped before.
    Stopped {
        /// Why.
        why: String,
    },
}

/// A roll-out: one node after the other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct Rollout {
    /// What it is for.
    pub kind: RolloutKind,
    /// Who began it.
    pub operator: String,
    /// Nodes, in ascending order.
    pub nodes: Vec<NodeUpgrade>,
    /// How it ended; absent while it goes on.
    pub ended: Option<RolloutEnd>,
}

/// Everything about upgrades at one node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct UpgradeReport {
    /// The versions of the node that is asked.
    pub this_node: NodeVersions,
    /// Archives that it keeps for a roll-out, one for each kind of processor.
    pub archives: Vec<ArchiveInfo>,
    /// The last roll-out that was begun at it since it started.
    pub rollout: Option<Rollout>,
}

/// Why a version is not taken, not started, or not sent.
#[derive(
    Debug,
    Clone,
    PartialEq,
    Eq,
    Error,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum UpgradeRefusal {
    /// The configuration does not permit it.
    #[error("the node takes no upgrades from its swarm: set upgrade.accept = true in its configuration")]
    NotAccepted,
    /// It has no place to keep versions in.
    #[error(
        "the node has no state folder (STATE_DIRECTORY, which systemd and the containers set): it keeps no versions"
    )]
    NoStateFolder,
    /// A vehicle is armed.
    #[error("vehicle {vehicle} is armed")]
    Armed {
        /// Which.
        vehicle: VehicleId,
    },
    /// A vehicle is not heard: nobody knows whether it is armed.
    #[error("vehicle {vehicle} is not heard, so that nobody knows whether it is armed")]
    NotHeard {
        /// Which.
        vehicle: VehicleId,
    },
    /// The node coordinates, and a vehicle of the swarm is armed.
    #[error("the node coordinates the swarm, and vehicle {vehicle} of it is armed")]
    Coordinates {
        /// Which.
        vehicle: VehicleId,
    },
    /// The archive is for another processor.
    #[error("the archive is for {archive}, the node is {node}")]
    Architecture {
        /// What the archive is for.
        archive: String,
        /// What the node is.
        node: String,
    },
    /// There is no archive for this node's processor.
    #[error("there is no archive for {node}")]
    NoArchive {
        /// What the node is.
        node: String,
    },
    /// The archive is not what it should be.
    #[error("the archive is not taken: {detail}")]
    Damaged {
        /// What is wrong.
        detail: String,
    },
    /// The disk is too full.
    #[error("{needed_bytes} bytes are needed on the disk, {free_bytes} are free")]
    NoRoom {
        /// What would be needed.
        needed_bytes: u64,
        /// What is free.
        free_bytes: u64,
    },
    /// No archive or version of this digest is there.
    #[error("there is no archive {digest}")]
    Unknown {
        /// Which was asked for.
        digest: String,
    },
    /// There is nothing to go back to.
    #[error("there is no version before this one")]
    NothingBefore,
    /// Something is under way that must end first.
    #[error("{what}")]
    Busy {
        /// What.
        what: String,
    },
    /// A roll-out would reach nobody.
    #[error("no other node of a swarm is known here, and this one was not asked for")]
    NoNodes,
    /// No such node is known.
    #[error("node {node} is not known here")]
    UnknownNode {
        /// Which.
        node: NodeId,
    },
    /// The disk failed.
    #[error("the disk: {detail}")]
    Storage {
        /// How.
        detail: String,
    },
}

impl UpgradeRefusal {
    /// The machine-readable word for the reason, as in JSON.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::NotAccepted => "not_accepted",
            Self::NoStateFolder => "no_state_folder",
            Self::Armed { .. } => "armed",
            Self::NotHeard { .. } => "not_heard",
            Self::Coordinates { .. } => "coordinates",
            Self::Architecture { .. } => "architecture",
            Self::NoArchive { .. } => "no_archive",
            Self::Damaged { .. } => "damaged",
            Self::NoRoom { .. } => "no_room",
            Self::Unknown { .. } => "unknown",
            Self::NothingBefore => "nothing_before",
            Self::Busy { .. } => "busy",
            Self::NoNodes => "no_nodes",
            Self::UnknownNode { .. } => "unknown_node",
            Self::Storage { .. } => "storage",
        }
    }
}
