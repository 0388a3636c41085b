//! What a report says, as plain values: times in seconds since the recording begins, lengths in metres, shares from 0 to 1.
//!
//! Must never do: hold text that is HTML, or a figure that nothing was measured for.

use crate::curve::Curve;
use serde::Serialize;
use skein_domain::exchange::Severity;
use skein_domain::{Geodetic, NodeId, PositionNed, VehicleId, ZoneKind};
use thiserror::Error;

/// Why there is no report.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ReportError {
    /// Nothing of it could be read.
    #[error("nothing of the recording can be read: {0}")]
    Unreadable(String),
}

/// Everything that is to be said of a flight.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Whose flight it was, when and where.
    pub about: About,
    /// The flight in a few plain sentences.
    pub verdict: Vec<String>,
    /// What went wrong, in order of time.
    pub findings: Vec<Finding>,
    /// Findings that did not fit in.
    pub findings_left_out: u64,
    /// What lies on the map.
    pub map: MapFacts,
    /// What the charts of the whole swarm show.
    pub charts: ChartFacts,
    /// Each vehicle, by ascending id.
    pub vehicles: Vec<VehicleFacts>,
    /// What operators and programs did.
    pub actions: Vec<ActionFacts>,
    /// Where the chain of the audit is broken, if it is.
    pub audit_broken: Option<String>,
    /// Commands with what became of them.
    pub commands: Vec<CommandFacts>,
    /// Every event.
    pub events: Vec<EventFacts>,
    /// Actions, commands and events that did not fit in.
    pub left_out: u64,
}

/// Whose flight it was, when and where.
#[derive(Debug, Clone, Serialize)]
pub struct About {
    /// Name of the file.
    pub file: String,
    /// How large it is, in bytes.
    pub bytes: u64,
    /// The node's name.
    pub node_name: String,
    /// Its number in the swarm.
    pub node: Option<NodeId>,
    /// The swarm's id; empty without one.
    pub swarm: String,
    /// Version of the program that flew.
    pub version: String,
    /// When the recording begins, in milliseconds since 1970.
    pub begins_unix_ms: i64,
    /// How long it is, in seconds.
    pub duration_s: f64,
    /// By how much the times on the page are ahead of UTC, in seconds.
    pub utc_offset_s: i32,
    /// Where the swarm's frame has its origin.
    pub origin: Option<Geodetic>,
    /// Vehicles that were simulated.
    pub simulated: usize,
    /// By how much the computer's clock was set during the recording, in seconds, if it was by more than half a second.
    pub clock_set_s: Option<f64>,
    /// Whether the recording is whole.
    pub whole: Wholeness,
}

/// Whether a recording is whole.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Wholeness {
    /// It ends as recordings end.
    pub finished: bool,
    /// What is wrong with it, each once, with how often.
    pub damage: Vec<(String, u64)>,
    /// Messages that could not be understood.
    pub unreadable: u64,
    /// Messages that the recorder dropped, because the disk did not take them.
    pub dropped: u64,
}

impl Wholeness {
    /// Nothing is missing.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.finished && self.damage.is_empty() && self.unreadable == 0 && self.dropped == 0
    }
}

/// What kind of thing went wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FindingKind {
    /// The failsafe policy of a vehicle reacted.
    Failsafe,
    /// Two vehicles were nearer than the limit.
    TooClose,
    /// A vehicle could not keep its distance.
    Avoidance,
    /// The motors were stopped in an emergency, or that was unlocked.
    EmergencyStop,
    /// A vehicle was not heard.
    LinkLoss,
    /// A pilot or the autopilot's own failsafe took a vehicle.
    Takeover,
    /// A plugin or actor was started again, or given up.
    Restart,
    /// Something was refused.
    Refusal,
    /// Setpoints came too seldom.
    Setpoints,
    /// Any other warning.
    Warning,
}

/// One thing that was done about a finding.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Step {
    /// When.
    pub t_s: f64,
    /// What.
    pub text: String,
}

/// Something that went wrong; the same one that came again is counted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Its number on the page.
    pub number: usize,
    /// When it began.
    pub t_s: f64,
    /// When it came last.
    pub last_s: f64,
    /// How often.
    pub count: u64,
    /// With which vehicle.
    pub vehicle: Option<VehicleId>,
    /// How bad.
    pub severity: Severity,
    /// What kind.
    pub kind: FindingKind,
    /// What.
    pub what: String,
    /// What was done about it, in order of time; of one that came again, the first time.
    pub done: Vec<Step>,
    /// Where the vehicle was.
    pub place: Option<PositionNed>,
}

/// A fence on the map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ZoneFacts {
    /// Its name.
    pub name: String,
    /// To be stayed in or kept out of.
    pub kind: ZoneKind,
    /// Its corners, metres north and east.
    pub corners_m: Vec<[f64; 2]>,
    /// Lowest and greatest height in metres, where it has one.
    pub heights_m: [Option<f64>; 2],
}

/// What lies on the map.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct MapFacts {
    /// The fences, as they were last.
    pub zones: Vec<ZoneFacts>,
    /// How often the fences were changed.
    pub fence_changes: u64,
}

/// A limit that holds from a moment on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LimitFrom {
    /// Since when.
    pub t_s: f64,
    /// The limit.
    pub value: f64,
}

/// What the charts of the whole swarm show.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ChartFacts {
    /// The smallest distance between any two vehicles in the air, in metres.
    pub distance_m: Curve,
    /// The smallest permitted one.
    pub distance_limit_m: Vec<LimitFrom>,
    /// Distance from its place at which the failsafe policy reacts, in metres.
    pub tracking_limit_m: Option<f64>,
    /// What is to be left in a battery after landing, as a share.
    pub reserve: Option<f64>,
    /// When the swarm flew a formation, from and to.
    pub formations_s: Vec<[f64; 2]>,
}

/// A largest or smallest value, and when.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extreme {
    /// When.
    pub t_s: f64,
    /// The value.
    pub value: f64,
}

/// The worst of a link.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Worst {
    /// Share of frames that were lost.
    pub loss: Option<Extreme>,
    /// Round trip in seconds.
    pub round_trip_s: Option<Extreme>,
}

/// The nearest another vehicle came.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Near {
    /// When.
    pub t_s: f64,
    /// How near, in metres.
    pub distance_m: f64,
    /// Which one.
    pub other: VehicleId,
}

/// A battery from take-off to the end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Battery {
    /// What was in it when the vehicle first was in the air.
    pub first: f64,
    /// What was in it last.
    pub last: f64,
}

/// A time in which setpoints were missing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gap {
    /// When it began.
    pub t_s: f64,
    /// How long it was, in seconds.
    pub length_s: f64,
}

/// Gaps between the recorded setpoints of a vehicle in OFFBOARD.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Gaps {
    /// How many.
    pub count: u64,
    /// The longest.
    pub longest: Option<Gap>,
    /// The first ones.
    pub some: Vec<Gap>,
}

/// How a vehicle was when the recording ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EndState {
    /// It never was in the air.
    NeverFlew,
    /// It stood on the ground, or was disarmed.
    OnGround,
    /// It was in the air.
    InAir,
    /// It was in the air and not heard any more.
    Lost,
}

/// The curves of one vehicle.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct VehicleCurves {
    /// Height above the swarm's origin in metres.
    pub height_m: Curve,
    /// Speed over the ground in metres per second.
    pub speed_m_s: Curve,
    /// Distance from the place that its task wants, in metres.
    pub tracking_error_m: Curve,
    /// What is left in the battery, as a share.
    pub battery: Curve,
    /// Share of frames lost.
    pub loss: Curve,
    /// Round trip in seconds.
    pub round_trip_s: Curve,
    /// Setpoints sent per second.
    pub setpoint_rate_hz: Curve,
}

/// One vehicle's flight.
#[derive(Debug, Clone, Serialize)]
pub struct VehicleFacts {
    /// Its id.
    pub id: VehicleId,
    /// Its name; empty if it was not recorded.
    pub name: String,
    /// The plugin that flew it.
    pub plugin: String,
    /// It was simulated.
    pub simulated: bool,
    /// Time in the air in seconds.
    pub flight_s: f64,
    /// Way over the ground in the air in metres.
    pub flown_m: f64,
    /// Highest point above the swarm's origin in metres.
    pub highest_m: Option<Extreme>,
    /// Largest speed over the ground in metres per second.
    pub fastest_m_s: Option<Extreme>,
    /// The nearest another vehicle came.
    pub nearest: Option<Near>,
    /// The largest distance from its place in a formation, once all had the time to come into theirs, in metres.
    pub largest_error_m: Option<Extreme>,
    /// Its battery.
    pub battery: Option<Battery>,
    /// Its link.
    pub link: Worst,
    /// Gaps between its setpoints.
    pub gaps: Gaps,
    /// Setpoints that the gate refused, of those recorded.
    pub setpoints_refused: u64,
    /// Setpoints that were changed to keep a distance or a fence, of those recorded.
    pub setpoints_changed: u64,
    /// Setpoints that were recorded.
    pub setpoints: u64,
    /// Events about it: all, warnings, critical ones.
    pub events: [u64; 3],
    /// How it was at the end.
    pub end: EndState,
    /// Its launch place, metres north and east.
    pub home_m: Option<[f64; 2]>,
    /// Its way over the ground, metres north and east.
    pub way_m: Vec<[f64; 2]>,
    /// Its curves.
    pub curves: VehicleCurves,
}

impl VehicleFacts {
    /// How it is called: its name where it has one.
    #[must_use]
    pub fn label(&self) -> String {
        let plain = format!("Vehicle {}", self.id);
        match self.name.as_str() {
            "" => plain,
            name => format!("{name} ({})", self.id),
        }
    }
}

/// One action of an operator or a program.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Serialize)]
pub struct ActionFacts {
    /// When, in milliseconds since the recording begins.
    pub t_ms: i64,
    /// Who.
    pub who: String,
    /// Over what.
    pub over: String,
    /// What was asked.
    pub what: String,
    /// With what.
    pub with: String,
    /// What came of it.
    pub outcome: String,
}

/// One command to one vehicle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CommandFacts {
    /// When it was first told of.
    pub t_s: f64,
    /// Its number.
    pub id: u64,
    /// The vehicle.
    pub vehicle: Option<VehicleId>,
    /// Its name.
    pub command: String,
    /// How it went on.
    pub progress: Vec<Step>,
    /// It was refused or broken off.
    pub refused: bool,
}

/// One event.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EventFacts {
    /// When.
    pub t_s: f64,
    /// About which vehicle.
    pub vehicle: Option<VehicleId>,
    /// On which other node.
    pub node: Option<NodeId>,
    /// How urgent.
    pub severity: Severity,
    /// What.
    pub text: String,
}
