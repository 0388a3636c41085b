//! The JSON that goes over the wire, beside the domain's and the runtime's own types: bodies, answers and stream messages.
//!
//! Each type here is exported to TypeScript and to the OpenAPI document. Must never do: hold behaviour.

mod flights;
mod links;
mod observed;
mod parameters;
mod replay;
mod supervision;
mod video;

pub use flights::{AutopilotLogList, FlightList, LogFetchAnswer, RecordedFlight};
pub use links::{EndpointReport, LinkReport, VehicleLinkReport};
pub use observed::{AskedObserverList, CameraView, CameraViewList, ObserverList, TrackList, ViewSource};
pub use parameters::{ParameterBody, ParameterName, ReadingBody};
pub use replay::ReplayAnswer;
pub use supervision::{SupervisedPayload, SupervisedVehicle, SupervisionTree};
pub use video::{
    VideoMessage, VideoRecording, VideoRecordingAnswer, VideoRecordingList, VideoRequest, VideoStateWord,
    VideoStreamList, VideoStreamView,
};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_config::Isolation;
use skein_coordination::ReferenceSnapshot;
use skein_domain::control::{Console, VehicleControl};
use skein_domain::fence::FencePlan;
use skein_domain::payload::PayloadKind;
use skein_domain::{
    EnergyState, FailsafeState, Geodetic, NodeId, NodeTime, OffsetFrd, Refusal, Route, SwarmFrame, SystemId,
    TrajectoryStatus, VehicleCommand, VehicleId,
};
use skein_replay::ReplayState;
use skein_runtime::{ControlAction, ControlReceipt, PluginInfo, Targets};
use skein_view::{ActorHealth, Avoidance, EventRecord, FormationSnapshot, UnadoptedVehicle, VehicleSnapshot};
use skein_view::{CommandReceipt, FormationForecast};
use skein_view::{PayloadSnapshot, RecorderStatus, RestartRecord, ResumeQuestion, SwarmSnapshot};
use ts_rs::TS;

/// Version of the stream's messages and of the binary frame.
pub const PROTOCOL_VERSION: u32 = 1;

/// Every answer that is not a success.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, TS, JsonSchema)]
pub struct ErrorBody {
    /// What went wrong.
    pub error: ErrorDetail,
}

/// What went wrong.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, TS, JsonSchema)]
pub struct ErrorDetail {
    /// A word for programs. For refusals the same as the refusal's `reason`.
    pub code: String,
    /// A sentence for people.
    pub message: String,
    /// Facts that go with the code: the refusal itself, the place in the body, what would be allowed. May be null.
    #[ts(type = "unknown")]
    pub detail: serde_json::Value,
    /// With the refusal of a body: one that would be taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[ts(optional, type = "unknown")]
    pub example: Option<serde_json::Value>,
}

/// Which program, which version, which node.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, TS, JsonSchema)]
pub struct VersionInfo {
    /// Always `skein`.
    pub program: String,
    /// Version of the program.
    pub version: String,
    /// Name of the node.
    pub node: String,
    /// Version of the stream's messages and of the binary frame.
    pub protocol: u32,
}

/// How the node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, TS, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HealthStatus {
    /// All is well.
    Ok,
    /// It runs, but an actor is being restarted or has been given up.
    Degraded,
    /// No new picture of the fleet has been made for over a second: nobody should rely on it.
    Stalled,
}

/// How the node is, with the facts.
#[derive(Debug, Clone, Serialize, TS, JsonSchema)]
pub struct Health {
    /// In one word.
    pub status: HealthStatus,
    /// Node time: how long the node has been running, in microseconds.
    pub time: NodeTime,
    /// Age of the newest picture of the fleet, in seconds.
    pub snapshot_age_s: f64,
    /// How many vehicles are flown by this node.
    pub vehicles: u32,
    /// How many of them are heard.
    pub vehicles_connected: u32,
    /// How many are heard but not flown.
    pub vehicles_unadopted: u32,
    /// Actors and model instances that are not running.
    pub not_running: Vec<ActorHealth>,
    /// Whether flights are recorded.
    pub recorder: RecorderStatus,
}

/// All vehicles at one moment.
#[derive(Debug, Clone, Serialize, TS, JsonSchema)]
pub struct VehicleList {
    /// When.
    pub time: NodeTime,
    /// Those that are flown, by ascending id.
    pub vehicles: Vec<VehicleSnapshot>,
    /// Those that are heard but not flown.
    pub unadopted: Vec<UnadoptedVehicle>,
}

/// A command and whom it is for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CommandBody {
    /// Whom it is for.
    pub targets: Targets,
    /// The command.
    pub command: VehicleCommand,
}

/// What became of a command, vehicle by vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct CommandReceipts {
    /// One for each vehicle it was for.
    pub receipts: Vec<CommandReceipt>,
}

/// What a console wants with which vehicles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ControlBody {
    /// Which.
    pub targets: Targets,
    /// Who.
    pub console: Console,
    /// What.
    pub action: ControlAction,
}

/// What came of it, vehicle by vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct ControlReceipts {
    /// One for each vehicle it was for.
    pub receipts: Vec<ControlReceipt>,
}

/// Who has control authority over which vehicles.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct ControlState {
    /// When.
    pub time: NodeTime,
    /// Those that somebody has, by ascending id.
    pub vehicles: Vec<VehicleControl>,
}

/// The formation, if one is flown.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct FormationAnswer {
    /// Null if none is flown.
    pub formation: Option<FormationSnapshot>,
}

/// A route for the leader.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RouteBody {
    /// The route.
    pub route: Route,
}

/// Which node is to coordinate.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoordinatorBody {
    /// Its number.
    #[schemars(range(min = 1, max = u64::MAX))]
    pub node: NodeId,
}

/// Where the places of a formation would be.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct FormationPreview {
    /// The places relative to the anchor, the leader's first if a vehicle leads.
    pub slots: Vec<OffsetFrd>,
    /// Smallest distance between two of them in metres; null for one alone.
    pub smallest_distance_m: Option<f64>,
    /// From each place, where a camera can look without another vehicle in its picture.
    pub views: Vec<SlotView>,
    /// How many of the vehicles carry a camera that is to look out of the formation.
    pub looking: u32,
    /// Who would take which place, how long it takes and how close they come on the way, if it were begun now; null if it would be refused.
    pub forecast: Option<FormationForecast>,
    /// Why it would be refused now: members that are not in the air, a place outside of the fence.
    pub refusal: Option<Refusal>,
}

/// Where a camera can look from a place of a formation, without another place within 30 degrees of that direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, TS, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SlotView {
    /// Along the formation's heading.
    Ahead,
    /// Not ahead, but away from the middle of the formation.
    Outward,
    /// Neither.
    Blocked,
}

/// How trajectories are getting on.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct TrajectoryList {
    /// Now, on the node's clock: what a start is to be told by.
    pub time: NodeTime,
    /// By ascending vehicle.
    pub trajectories: Vec<TrajectoryStatus>,
}

/// Trajectories that have ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, TS, JsonSchema)]
pub struct TrajectoriesEnded {
    /// Whose.
    pub vehicles: Vec<VehicleId>,
}

/// Things that formations may be anchored to.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct ReferenceList {
    /// The references by name.
    pub references: Vec<ReferenceSnapshot>,
}

/// The second step of the emergency stop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmergencyStopBody {
    /// The key of the first step.
    pub key: String,
    /// Whose motors are stopped.
    pub targets: Targets,
}

/// Red items of the preflight report that an operator takes upon himself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OverrideBody {
    /// Whose items; those of the swarm if left out.
    #[serde(default)]
    pub vehicle: Option<VehicleId>,
    /// Ids of the items.
    #[schemars(length(min = 1, max = 64))]
    pub items: Vec<String>,
    /// Why.
    pub reason: String,
    /// For how long, in seconds.
    #[schemars(range(max = skein_domain::preflight::LONGEST_OVERRIDE_S), extend("exclusiveMinimum" = 0))]
    pub valid_s: f64,
}

/// Fences to be put in force.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FencePlanBody {
    /// All zones; none to fly without a fence.
    pub plan: FencePlan,
}

/// A file with fences.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FenceFileBody {
    /// Its name, for messages and for zones without a name.
    #[serde(default)]
    pub name: Option<String>,
    /// Its text: GeoJSON, or a plan of QGroundControl.
    pub text: String,
}

/// What a file with fences says.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct ImportedFencePlan {
    /// The zones.
    pub plan: FencePlan,
    /// What was left out, and why.
    pub notes: Vec<String>,
}

/// It was taken up; how it goes on comes as events.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, TS, JsonSchema)]
pub struct Accepted {
    /// Always true.
    pub accepted: bool,
}

/// Events after a given one.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct EventList {
    /// Oldest first.
    pub events: Vec<EventRecord>,
    /// How many between the given one and the first of the list are no longer kept.
    pub missed: u64,
}

/// Which alerts an operator has seen.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AcknowledgeBody {
    /// Their numbers.
    #[schemars(inner(range(max = 9_007_199_254_740_991_u64)))]
    #[ts(type = "number[]")]
    pub events: Vec<u64>,
}

/// What came of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, TS, JsonSchema)]
pub struct Acknowledged {
    /// How many of them are alerts that are still kept and that nobody had seen before.
    pub alerts: usize,
}

/// Plugins that were found.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct PluginList {
    /// Those that can be used.
    pub plugins: Vec<PluginInfo>,
    /// Files that look like plugins and were not taken, and why.
    pub problems: Vec<String>,
}

/// What a vehicle carries.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct PayloadList {
    /// By name.
    pub payloads: Vec<PayloadSnapshot>,
}

/// Restarts of plugin instances.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct RestartList {
    /// Oldest first.
    pub restarts: Vec<RestartRecord>,
}

/// What is said of the fleet at a slow rate: everything that is not in the binary frame.
#[derive(Debug, Clone, Default, Serialize, TS, JsonSchema)]
pub struct FleetInfo {
    /// The swarm's common frame, once known.
    pub frame: Option<SwarmFrame>,
    /// Vehicles by ascending id.
    pub vehicles: Vec<VehicleInfo>,
    /// Vehicles that are heard but not flown, and why.
    pub unadopted: Vec<UnadoptedVehicle>,
    /// The formation being flown, if any.
    pub formation: Option<FormationSnapshot>,
    /// Actors of the node under supervision.
    pub actors: Vec<ActorHealth>,
    /// Whether faults may be injected here.
    pub faults_enabled: bool,
    /// Whether an operator has to give signs of life, and does.
    pub dead_man: DeadMan,
    /// What an operator is asked after the node ended in flight and has started again.
    pub resume: Option<ResumeQuestion>,
    /// Whether flights are recorded.
    pub recorder: RecorderStatus,
}

/// The answer to what an operator is asked after a restart in flight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResumeBody {
    /// The vehicles that were taken back fly on; if not, they go on holding, and what was flown is forgotten.
    pub fly_on: bool,
}

/// The operator's dead-man's switch.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, TS, JsonSchema)]
pub struct DeadMan {
    /// How it stands.
    pub state: DeadManState,
    /// After how many seconds without a sign of life vehicles in the air begin to react; absent if they never do.
    pub warns_after_s: Option<f64>,
}

/// How a dead-man's switch stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, TS, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DeadManState {
    /// Nobody has to give signs of life.
    #[default]
    Off,
    /// Nobody has ever given one: it counts from take-off.
    Unheard,
    /// Somebody is there.
    Heard,
    /// The last sign of life is so old that vehicles in the air react.
    Silent,
}

/// What is wrong with a vehicle, or done to keep it safe. Rounded: what hardly changes is not told again.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct VehicleSafety {
    /// The swarm's id for it.
    pub id: VehicleId,
    /// What is wrong with it in flight and what is done about it; absent if nothing is.
    pub failsafe: Option<FailsafeState>,
    /// Its charge against its way home; absent as long as one of them is not known.
    pub energy: Option<EnergyState>,
    /// What is changed of its setpoints at this moment; absent if nothing.
    pub avoiding: Option<Avoidance>,
    /// Its motors were stopped in an emergency.
    pub stopped: bool,
}

/// What changes seldom about one vehicle.
#[derive(Debug, Clone, Serialize, TS, JsonSchema)]
pub struct VehicleInfo {
    /// The swarm's id for it.
    pub id: VehicleId,
    /// The node of the swarm that flies it, in a swarm of several nodes.
    pub node: Option<NodeId>,
    /// Its name.
    pub name: String,
    /// It is simulated, for all its node knows; who does not say so is real.
    pub simulated: bool,
    /// MAVLink system id on its link.
    pub system_id: SystemId,
    /// Name of the UAV-model plugin that flies it.
    pub plugin: String,
    /// Version of that plugin.
    pub plugin_version: String,
    /// Why it is in its flight state; may be empty.
    pub state_detail: String,
    /// Launch place.
    pub home: Option<Geodetic>,
    /// Its actor.
    pub actor: ActorHealth,
    /// Its UAV-model plugin instance.
    pub model: ActorHealth,
    /// What it carries, by name.
    pub payloads: Vec<PayloadInfo>,
    /// Why it can do less than it was built for; empty if nothing is amiss.
    pub degraded: Vec<String>,
}

/// What changes seldom about one payload. Its state is in its vehicle's snapshot.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct PayloadInfo {
    /// Its name on the vehicle.
    pub name: String,
    /// What it is.
    pub kind: PayloadKind,
    /// Name of its plugin.
    pub plugin: String,
    /// Version of that plugin.
    pub version: String,
    /// Where the plugin runs.
    pub isolation: Isolation,
    /// Its plugin instance.
    pub health: ActorHealth,
    /// How many of its starts followed a failure.
    pub restarts: u64,
    /// Whether it has given a frame.
    pub has_frame: bool,
}

/// What the server says on the stream as text. Readers skip types they do not know.
#[derive(Debug, Clone, Serialize, TS, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ServerMessage {
    /// First of all.
    Hello {
        /// Version of these messages and of the binary frame.
        protocol: u32,
        /// Version of the program.
        version: String,
        /// Name of the node.
        node: String,
    },
    /// The slow part of the fleet's state, whole; sent at the start and when it has changed.
    Fleet(Box<FleetInfo>),
    /// The safety of vehicles: of all at the start, then of those of which it has changed.
    Safety {
        /// By ascending id.
        vehicles: Vec<VehicleSafety>,
    },
    /// Who has control authority over which vehicles, whole; when it has changed.
    Control {
        /// Those that somebody has, by ascending id.
        vehicles: Vec<VehicleControl>,
    },
    /// What is tracked, whole; when it has changed, five times a second at most. Not said while there is nothing and nothing was said.
    Tracks(TrackList),
    /// The swarm of several nodes, where this node is part of one; twice a second.
    Swarm(Box<SwarmSnapshot>),
    /// What is shown is a recorded flight: where it is. First of all after the greeting, and when it goes to another moment or at another pace, or
    /// comes to its end; never said by a node that flies.
    Replay(Box<ReplayState>),
    /// Something happened.
    Event(Box<EventRecord>),
    /// Events were lost, because this client was too slow or had been away for too long.
    Gap {
        /// How many.
        missed: u64,
    },
    /// The rate of binary frames, as an answer to the same message of the client.
    Rate {
        /// Frames per second.
        rate_hz: f64,
    },
    /// The client's last message was not understood; the stream goes on.
    Error {
        /// Why.
        error: ErrorDetail,
    },
}

/// What a client may say on the stream as text.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum ClientMessage {
    /// Ask for another rate of binary frames.
    Rate {
        /// Frames per second, 1 to 50.
        #[schemars(range(min = 1.0, max = 50.0))]
        rate_hz: f64,
    },
    /// How a vehicle that was commanded to `steer` is to move, along the axes of the level vehicle. Good for half a second: to be said again,
    /// about 20 times a second, for as long as somebody holds the stick. Of more than 50 per second the newest are flown. One that is
    /// refused is answered with an error whose `detail` has the `refusal` and the vehicle as `stick`, at most once a second.
    Stick {
        /// The vehicle.
        vehicle: VehicleId,
        /// Forward in metres per second.
        #[schemars(range(min = -50.0, max = 50.0))]
        forward_m_s: f64,
        /// To the right in metres per second.
        #[schemars(range(min = -50.0, max = 50.0))]
        right_m_s: f64,
        /// Up in metres per second.
        #[schemars(range(min = -50.0, max = 50.0))]
        up_m_s: f64,
        /// Turning clockwise as seen from above, in radians per second.
        #[schemars(range(min = -std::f64::consts::TAU, max = std::f64::consts::TAU))]
        yaw_rate_rad_s: f64,
    },
}
