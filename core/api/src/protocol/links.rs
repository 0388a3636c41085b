//! What is said of the links of a node: its endpoints, and how each vehicle is heard.
//!
//! Must never do: hold behaviour.

use schemars::JsonSchema;
use serde::Serialize;
use skein_domain::{LinkHealth, NodeId, NodeTime, VehicleId, VehicleWay};
use ts_rs::TS;

/// The links of this node at one moment. Rates follow from two answers: the counters only grow as long as the node runs.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct LinkReport {
    /// Now, on the node's clock.
    pub time: NodeTime,
    /// Its MAVLink endpoints, by name.
    pub endpoints: Vec<EndpointReport>,
    /// Every vehicle's link, by ascending id.
    pub vehicles: Vec<VehicleLinkReport>,
}

/// What came and went over one endpoint since the node began.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, TS, JsonSchema)]
pub struct EndpointReport {
    /// Its name.
    pub name: String,
    /// The local address, once it is bound; absent for serial lines.
    pub address: Option<String>,
    /// Bytes received.
    #[ts(type = "number")]
    pub bytes_in: u64,
    /// Frames received whole.
    #[ts(type = "number")]
    pub frames_in: u64,
    /// Bytes sent.
    #[ts(type = "number")]
    pub bytes_out: u64,
    /// Frames sent.
    #[ts(type = "number")]
    pub frames_out: u64,
    /// Frames that came damaged: a wrong checksum, cut off, or with values that mean nothing.
    #[ts(type = "number")]
    pub damaged: u64,
    /// Frames with a vehicle's system id from another place than the vehicle's.
    #[ts(type = "number")]
    pub foreign: u64,
    /// Frames of systems that this node does not fly.
    #[ts(type = "number")]
    pub unadopted: u64,
    /// Frames that could not be sent.
    #[ts(type = "number")]
    pub dropped: u64,
}

/// How one vehicle is heard.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct VehicleLinkReport {
    /// The swarm's id for it.
    pub id: VehicleId,
    /// Its name from the adoption rule.
    pub name: String,
    /// The node of the swarm that flies it, and has measured this; absent for this node's own without a swarm.
    pub node: Option<NodeId>,
    /// Seconds since something of it was heard.
    pub age_s: f64,
    /// The link that flies it.
    pub link: LinkHealth,
    /// Both links, the preferred one first, where it has two.
    pub ways: Vec<VehicleWay>,
}
