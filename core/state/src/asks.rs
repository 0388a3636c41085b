//! What one node asks of another, and what it answers: commands for the vehicles that it flies, what only the coordinator can do, requests that
//! came in at another node's gateway.
//!
//! Must never do: carry anything out.

use serde::{Deserialize, Serialize};
use skein_coordination::TrackObservation;
use skein_domain::fence::FencePlan;
use skein_domain::link::RoutePoint;
use skein_domain::preflight::PreflightReport;
use skein_domain::{
    FormationRequest, NodeId, NodeTime, Refusal, Route, Stick, TrajectoryObjection, TrajectoryPlan, TrajectoryRequest,
    VehicleCommand, VehicleId,
};
use skein_view::{ArchiveInfo, CommandReceipt, FormationForecast, FormationReceipt, NodeVersions, UpgradeRefusal};
use std::collections::VecDeque;
use std::pin::Pin;
use std::sync::Arc;

/// Answers a request of another node's gateway with this node's own routes.
pub type ApiServer = Arc<dyn Fn(ApiRequest) -> Pin<Box<dyn Future<Output = ApiAnswer> + Send>> + Send + Sync>;

/// A request to the API, as it came in at another node.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ApiRequest {
    /// Method.
    pub method: String,
    /// Path with query.
    pub path: String,
    /// Type of the body, if it has one.
    pub content_type: Option<String>,
    /// The console that it comes from, if it says so.
    #[serde(default)]
    pub console: Option<String>,
    /// Where it stands in a trace, as W3C Trace Context has it.
    #[serde(default)]
    pub traceparent: Option<String>,
    /// The body.
    #[serde(with = "serde_bytes")]
    pub body: Vec<u8>,
}

/// Its answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ApiAnswer {
    /// Status.
    pub status: u16,
    /// Headers that say what the body is.
    pub headers: Vec<(String, String)>,
    /// The body.
    #[serde(with = "serde_bytes")]
    pub body: Vec<u8>,
}

/// A command for a vehicle of the asked node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Order {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// The command.
    pub command: VehicleCommand,
    /// How it is flown, if it takes more than one flight.
    pub legs: VecDeque<VehicleCommand>,
    /// Not to be begun sooner than after so many seconds.
    pub delay_s: f64,
    /// An operator gave it; otherwise the coordinator did.
    pub by_operator: bool,
    /// Where it stands in a trace, as W3C Trace Context has it.
    #[serde(default)]
    pub traceparent: Option<String>,
}

/// What is asked about one track that the swarm made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum TrackOrder {
    /// Another name, or that it is to be kept; what is absent stays as it is.
    Change {
        /// Its number.
        track: u64,
        /// Its name; an empty one takes the name away.
        name: Option<String>,
        /// Whether it is to be kept longer.
        pinned: Option<bool>,
    },
    /// It is to end.
    Drop {
        /// Its number.
        track: u64,
    },
    /// Vehicles were asked to keep it in view: others are to take over where one no longer can.
    Observe(TrackObservation),
}

/// What is asked about the version that a node runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum UpgradeAsk {
    /// Which versions it has.
    Versions,
    /// Would it take this archive, and how much of it does it have?
    Offer(ArchiveInfo),
    /// A part of the archive that was offered.
    Part {
        /// Of which archive.
        digest: String,
        /// Where it begins.
        at_byte: u64,
        /// It.
        #[serde(with = "serde_bytes")]
        bytes: Vec<u8>,
    },
    /// Check and unpack the archive, which is there whole.
    Unpack {
        /// Which.
        digest: String,
    },
    /// Start the unpacked version, on trial.
    Try {
        /// Of which archive.
        digest: String,
    },
    /// Start the version before, on trial.
    Back,
}

/// The answer to an [`UpgradeAsk`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum UpgradeAnswer {
    /// To which versions it has.
    Versions(Box<NodeVersions>),
    /// To an offer and to a part: so many bytes of the archive are there.
    Has {
        /// How many.
        bytes: u64,
    },
    /// It is unpacked; or another version is started in a moment.
    Done,
}

/// What is asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Ask {
    /// Commands for vehicles of the asked node.
    Orders(Vec<Order>),
    /// Motors off, now.
    EmergencyStop(Vec<VehicleId>),
    /// Put these routes on the autopilots of vehicles of the asked node.
    Upload(Vec<(VehicleId, Vec<RoutePoint>)>),
    /// Of the coordinator: fly this formation.
    Formation(Box<FormationRequest>),
    /// Of the coordinator: how would this formation be flown?
    Forecast(Box<FormationRequest>),
    /// Of the coordinator: end the formation.
    Dissolve,
    /// Of the coordinator: a route for the leader.
    Route(Route),
    /// Of the coordinator: trajectories, to be flown or only planned. Moments are by the asker's clock.
    Trajectories {
        /// What is asked for.
        request: Box<TrajectoryRequest>,
        /// It is to be flown.
        fly: bool,
    },
    /// Of the coordinator: end all trajectories.
    EndTrajectories,
    /// Of the coordinator: other fences for everybody.
    Fences(Box<FencePlan>),
    /// The preflight reports of the asked node's vehicles.
    Preflight,
    /// Take the leadership.
    TakeLeadership,
    /// A request to the API about something that the asked node has.
    Api(ApiRequest),
    /// The video of a camera of the asked node, for the next seconds.
    Video {
        /// Who wants it.
        to: NodeId,
        /// Under this number.
        number: u32,
        /// The vehicle.
        vehicle: VehicleId,
        /// The camera's name on it.
        payload: String,
        /// At most 320x240 and 10/s.
        small: bool,
    },
    /// Of the coordinator: something about a track.
    Track(TrackOrder),
    /// How a vehicle of the asked node that is steered by hand is to move, and when that was told by the asker's clock.
    Stick {
        /// The vehicle.
        vehicle: VehicleId,
        /// How.
        stick: Stick,
        /// When.
        told: NodeTime,
    },
    /// About the version that the asked node runs.
    Upgrade(UpgradeAsk),
}

/// The answer to an [`Ask`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Answer {
    /// To orders and the emergency stop.
    Receipts(Vec<CommandReceipt>),
    /// To a formation.
    Formation(Result<FormationReceipt, Refusal>),
    /// To how a formation would be flown.
    Forecast(Box<Result<FormationForecast, Refusal>>),
    /// To what has no other outcome than that it is done.
    Done(Result<(), Refusal>),
    /// To preflight reports.
    Preflight(Vec<PreflightReport>),
    /// To a route.
    Route(Result<Route, Refusal>),
    /// To trajectories; moments by the asker's clock.
    Trajectories(Result<TrajectoryPlan, Vec<TrajectoryObjection>>),
    /// To the end of all trajectories.
    Ended(Result<Vec<VehicleId>, Refusal>),
    /// To a request to the API.
    Api(ApiAnswer),
    /// About versions.
    Upgrade(Result<UpgradeAnswer, UpgradeRefusal>),
}
