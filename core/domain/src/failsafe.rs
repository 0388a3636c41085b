//! The words of the failsafe policy: what can go wrong with a vehicle in flight, what is done about it, and what is told of it.
//! The state machine itself is `skein-safety`'s; its written table is `deploy/docs/src/failsafe-policy.md`.
//!
//! Must never do: decide anything.

mod settings;

pub use settings::{
    ClockFaultRule, CoordinatorLossRule, EnergyRule, FailsafeSettings, FailsafeStep, FenceBreachRule,
    GnssDisagreementRule, GnssLossRule, LinkLossRule, OperatorDeadManRule, StaleEstimateRule, TrackingErrorRule,
    TriggerMode,
};

use crate::NodeTime;
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// What is done about a trigger, in order of strength: of two the greater wins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
#[cbor(index_only)]
pub enum Reaction {
    /// It is reported.
    #[default]
    #[n(0)]
    Warn,
    /// The vehicle stops and holds its position by its autopilot's own means.
    #[n(1)]
    Hold,
    /// The vehicle returns to its launch place.
    #[n(2)]
    Return,
    /// The vehicle lands where it is.
    #[n(3)]
    Land,
    /// Its setpoint stream is stopped on purpose, so that the autopilot's own failsafe acts.
    #[n(4)]
    Release,
}

impl Reaction {
    /// Every reaction, weakest first.
    pub const ALL: &'static [Self] = &[Self::Warn, Self::Hold, Self::Return, Self::Land, Self::Release];

    /// The next stronger one; [`Self::Release`] is the last.
    #[must_use]
    pub fn stronger(self) -> Self {
        match self {
            Self::Warn => Self::Hold,
            Self::Hold => Self::Return,
            Self::Return => Self::Land,
            Self::Land | Self::Release => Self::Release,
        }
    }

    /// The word for it, as in JSON.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Warn => "warn",
            Self::Hold => "hold",
            Self::Return => "return",
            Self::Land => "land",
            Self::Release => "release",
        }
    }
}

impl std::fmt::Display for Reaction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

/// What may go wrong with one vehicle in flight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
#[cbor(index_only)]
pub enum Trigger {
    /// The vehicle is not heard.
    #[n(0)]
    LinkLoss,
    /// Its receiver lost its fix, or says nothing any more.
    #[n(1)]
    GnssLoss,
    /// Two sources of its position disagree.
    #[n(2)]
    GnssDisagreement,
    /// It is not where its setpoint wants it.
    #[n(3)]
    TrackingError,
    /// Its newest position is old.
    #[n(4)]
    StaleEstimate,
    /// Its clock, or the node's, jumped or drifts, so that the age of what it says is not known.
    #[n(5)]
    ClockFault,
    /// It is outside of a fence, or in a place where it must not be.
    #[n(6)]
    FenceBreach,
    /// No coordinator is heard.
    #[n(7)]
    CoordinatorLoss,
    /// No operator gave a sign of life.
    #[n(8)]
    OperatorDeadMan,
    /// Its charge comes to an end.
    #[n(9)]
    Energy,
}

impl Trigger {
    /// Every trigger, in the order of the written table.
    pub const ALL: &'static [Self] = &[
        Self::LinkLoss,
        Self::GnssLoss,
        Self::GnssDisagreement,
        Self::TrackingError,
        Self::StaleEstimate,
        Self::ClockFault,
        Self::FenceBreach,
        Self::CoordinatorLoss,
        Self::OperatorDeadMan,
        Self::Energy,
    ];

    /// The word for it, as in JSON and in the configuration.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::LinkLoss => "link_loss",
            Self::GnssLoss => "gnss_loss",
            Self::GnssDisagreement => "gnss_disagreement",
            Self::TrackingError => "tracking_error",
            Self::StaleEstimate => "stale_estimate",
            Self::ClockFault => "clock_fault",
            Self::FenceBreach => "fence_breach",
            Self::CoordinatorLoss => "coordinator_loss",
            Self::OperatorDeadMan => "operator_dead_man",
            Self::Energy => "energy",
        }
    }
}

impl std::fmt::Display for Trigger {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

/// What an event of the failsafe policy says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
#[cbor(index_only)]
pub enum FailsafeEventKind {
    /// A trigger's first step: it lasts longer than its debounce time.
    #[n(0)]
    Raised,
    /// A trigger's next step, with a stronger reaction.
    #[n(1)]
    Escalated,
    /// The reaction is to be carried out now. The only kind that asks for something.
    #[n(2)]
    Ordered,
    /// The reaction in force is seen to take effect.
    #[n(3)]
    Effective,
    /// The reaction in force was not seen to take effect within its bound; a stronger one follows.
    #[n(4)]
    Ineffective,
    /// The trigger is over. What was ordered stays in force until somebody takes the vehicle up again.
    #[n(5)]
    Cleared,
    /// The reaction is not in force any more: landed, or the pilot took over.
    #[n(6)]
    Ended,
    /// An operator or the coordinator took the vehicle up again.
    #[n(7)]
    TakenUp,
}

/// Why a trigger is reported and nothing is done about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
#[cbor(index_only)]
pub enum ReportOnly {
    /// The vehicle stands on the ground.
    #[n(0)]
    OnGround,
    /// A human pilot flies it.
    #[n(1)]
    PilotInControl,
    /// The configuration says so.
    #[n(2)]
    WarnOnly,
    /// An operator took the vehicle up while the trigger lasted; its next step reacts again.
    #[n(3)]
    Overruled,
    /// The vehicle lands where it is, which is more than the trigger asks for.
    #[n(4)]
    Landing,
}

/// One thing that the failsafe policy of a vehicle noticed or did.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct FailsafeEvent {
    /// What it says.
    #[n(0)]
    pub kind: FailsafeEventKind,
    /// Because of what.
    #[n(1)]
    pub trigger: Trigger,
    /// The measured value, in `unit`.
    #[n(2)]
    pub value: f64,
    /// The limit that it is beyond, in `unit`.
    #[n(3)]
    pub limit: f64,
    /// Unit of value and limit: `s`, `m`, or empty.
    #[n(4)]
    pub unit: String,
    /// Since when it has been so.
    #[n(5)]
    pub since: NodeTime,
    /// When this was decided.
    #[n(6)]
    pub at: NodeTime,
    /// The reaction of this step; of an `ordered` one what is to be done.
    #[n(7)]
    pub reaction: Reaction,
    /// Why nothing is done about it; absent if something is.
    #[n(8)]
    pub report_only: Option<ReportOnly>,
    /// The sentence an operator reads.
    #[n(9)]
    pub reason: String,
}

/// One trigger that lasts.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct Alarm {
    /// Which.
    #[n(0)]
    pub trigger: Trigger,
    /// The newest value, in `unit`.
    #[n(1)]
    pub value: f64,
    /// The limit it went beyond, in `unit`.
    #[n(2)]
    pub limit: f64,
    /// Unit of both.
    #[n(3)]
    pub unit: String,
    /// Since when.
    #[n(4)]
    pub since: NodeTime,
    /// The reaction of the step it has come to.
    #[n(5)]
    pub reaction: Reaction,
    /// Why nothing is done about it; absent if something is.
    #[n(6)]
    pub report_only: Option<ReportOnly>,
}

/// The reaction that a vehicle is under.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct Order {
    /// What is to be done.
    #[n(0)]
    pub reaction: Reaction,
    /// Because of what.
    #[n(1)]
    pub trigger: Trigger,
    /// Since when it has been ordered.
    #[n(2)]
    pub ordered_at: NodeTime,
    /// Since when it has been seen to take effect, if it does.
    #[n(3)]
    pub effective_at: Option<NodeTime>,
    /// All triggers are over: it stays until an operator or the coordinator takes the vehicle up again.
    #[n(4)]
    pub recovered: bool,
}

/// How far the failsafe policy of a vehicle has come, for screens.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct FailsafeState {
    /// What lasts, in the order of the written table.
    #[n(0)]
    pub alarms: Vec<Alarm>,
    /// What it is under; nothing if it flies freely.
    #[n(1)]
    pub order: Option<Order>,
}
