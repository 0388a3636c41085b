//! What is said of everything under supervision.
//!
//! Must never do: hold behaviour.

use schemars::JsonSchema;
use serde::Serialize;
use skein_domain::payload::PayloadKind;
use skein_domain::{NodeId, NodeTime, VehicleId};
use skein_view::{ActorHealth, PluginHealth};
use ts_rs::TS;

/// The supervision tree: the node's actors, and below every vehicle its actor, its model and what it carries.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct SupervisionTree {
    /// Now, on the node's clock: what every `since` is to be told by.
    pub time: NodeTime,
    /// Actors of the node itself.
    pub actors: Vec<ActorHealth>,
    /// By ascending id.
    pub vehicles: Vec<SupervisedVehicle>,
}

/// What is supervised for one vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct SupervisedVehicle {
    /// The swarm's id for it.
    pub id: VehicleId,
    /// The node of the swarm that flies it; absent for this node's own without a swarm.
    pub node: Option<NodeId>,
    /// Its name from the adoption rule.
    pub name: String,
    /// Its actor.
    pub actor: ActorHealth,
    /// Its UAV-model plugin instance.
    pub model: PluginHealth,
    /// What it carries, by name.
    pub payloads: Vec<SupervisedPayload>,
    /// Why it can do less than it was built for; empty if nothing is amiss.
    pub degraded: Vec<String>,
}

/// What is supervised for one payload.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct SupervisedPayload {
    /// Its name on the vehicle.
    pub name: String,
    /// What it is.
    pub kind: PayloadKind,
    /// Its actor.
    pub actor: ActorHealth,
    /// Its plugin instance.
    pub plugin: PluginHealth,
    /// Why its transport does not work; empty if it does or has none.
    pub transport_fault: String,
}
