//! Decisions with all that they were made from, so that they can be made again: the safety gate's, the failsafe policy's, the planner's.
//!
//! Must never do: round an input, or leave one out.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use skein_coordination::{Formation, PlanInput, PlanLimits};
use skein_domain::fence::FencePlan;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    AnchorReference, FailsafeSettings, FormationRequest, NodeTime, PositionNed, Refusal, Route, SwarmFrame, VehicleId,
};
use skein_failover::{LeaderMonitor, Leadership, Turn};
use skein_safety::avoidance::Surroundings;
use skein_safety::failsafe::Health;
use skein_safety::{FailsafePolicy, FencePlanError, Fences, Gate, Limits};
use skein_view::{PeerEntry, PeerSnapshot};
use std::sync::Arc;

/// One vehicle at one control period, as the safety gate looks at it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PeerRecord {
    /// Which.
    pub vehicle: VehicleId,
    /// As it was measured, in the swarm's frame.
    pub kinematics: Option<VehicleKinematics>,
    /// In the air.
    pub airborne: bool,
    /// Where it took off from.
    pub home: Option<PositionNed>,
}

/// All vehicles at one control period, as the safety gate looks at them.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PeersRecord {
    /// When that control period began.
    pub made: NodeTime,
    /// By ascending id.
    pub vehicles: Vec<PeerRecord>,
    /// Everything in the air as the separation filter has it.
    pub surroundings: Surroundings,
}

impl PeersRecord {
    /// Of a control period.
    #[must_use]
    pub fn of(peers: &PeerSnapshot) -> Self {
        let record = |entry: &PeerEntry| PeerRecord {
            vehicle: entry.id,
            kinematics: entry.kinematics,
            airborne: entry.airborne,
            home: entry.home,
        };
        Self {
            made: peers.made,
            vehicles: peers.entries.iter().map(record).collect(),
            surroundings: peers.surroundings.clone(),
        }
    }

    /// A vehicle, with nothing else known of it than what the gate looks at.
    #[must_use]
    pub fn entry(&self, vehicle: VehicleId) -> Option<PeerEntry> {
        let record = self.vehicles.iter().find(|record| record.vehicle == vehicle)?;
        Some(PeerEntry {
            id: record.vehicle,
            kinematics: record.kinematics,
            airborne: record.airborne,
            home: record.home,
            ..PeerEntry::default()
        })
    }
}

/// The safety gate as it is from now on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GateState {
    /// Since when, on the node's clock.
    pub time: NodeTime,
    /// Its number in this recording.
    pub number: u64,
    /// Its limits.
    pub limits: Limits,
    /// Lowest height of a setpoint above the ground in flight, in metres.
    pub min_height_m: f64,
    /// Its fences, as they were described.
    pub fences: FencePlan,
    /// The frame that the fences are placed in.
    pub frame: Option<SwarmFrame>,
}

impl GateState {
    /// The gate.
    ///
    /// # Errors
    /// When a fence cannot be placed: the recording was changed.
    pub fn gate(&self) -> Result<Gate, FencePlanError> {
        let fences = Fences::from_plan(&self.fences, self.frame.as_ref())?;
        Ok(Gate::new(self.limits, fences).with_min_height(self.min_height_m))
    }
}

/// One step of a vehicle's failsafe policy that told of something.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FailsafeDecision {
    /// When, on the node's clock.
    pub time: NodeTime,
    /// Which vehicle.
    pub vehicle: VehicleId,
    /// The policy before the step.
    pub before: FailsafePolicy,
    /// What it was told.
    pub health: Health,
    /// The rules.
    pub settings: FailsafeSettings,
    /// What it told: a list of [`skein_domain::FailsafeEvent`].
    pub events: Value,
}

/// What a node was to do about the leadership, which was another thing than before.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LeadershipDecision {
    /// When, on the node's clock.
    pub time: NodeTime,
    /// What it had heard of the others.
    pub monitor: LeaderMonitor,
    /// Whom it obeyed, and how suited it was.
    pub leadership: Leadership,
    /// What it was to do.
    pub turn: Turn,
}

/// One plan of a formation.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FormationDecision {
    /// When it was made, on the node's clock.
    pub time: NodeTime,
    /// By which gate: a `number` on `/skein/gate`.
    pub gate: u64,
    /// What was asked for.
    pub request: FormationRequest,
    /// The formation flown until then.
    pub before: Option<Formation>,
    /// Speed of the leader's route in metres per second.
    pub route_speed_m_s: Option<f64>,
    /// The anchor flew along it.
    pub under_way: bool,
    /// Where the anchor was to go.
    pub ahead: Option<Route>,
    /// Where the reference was.
    pub reference: Option<AnchorReference>,
    /// Limits.
    pub limits: PlanLimits,
    /// When the change was to begin.
    pub start: NodeTime,
    /// All vehicles.
    pub peers: PeerSnapshot,
    /// The formation, or `{"refused": ...}`.
    pub outcome: Value,
}

/// A formation or a refusal as a decision holds it.
#[must_use]
pub fn outcome(of: &Result<Formation, Refusal>) -> Value {
    match of {
        Ok(formation) => serde_json::to_value(formation).unwrap_or_default(),
        Err(refusal) => serde_json::json!({ "refused": refusal }),
    }
}

impl FormationDecision {
    /// Of a plan that was made.
    #[must_use]
    pub fn of(
        time: NodeTime,
        gate: u64,
        input: &PlanInput,
        peers: &PeerSnapshot,
        made: &Result<Formation, Refusal>,
    ) -> Self {
        Self {
            time,
            gate,
            request: input.request.clone(),
            before: input.before.clone(),
            route_speed_m_s: input.route_speed_m_s,
            under_way: input.under_way,
            ahead: input.ahead.clone(),
            reference: input.reference,
            limits: input.limits.clone(),
            start: input.start,
            peers: peers.clone(),
            outcome: outcome(made),
        }
    }

    /// What the plan was made from.
    #[must_use]
    pub fn input(&self, gate: Arc<Gate>) -> PlanInput {
        PlanInput {
            request: self.request.clone(),
            before: self.before.clone(),
            route_speed_m_s: self.route_speed_m_s,
            under_way: self.under_way,
            ahead: self.ahead.clone(),
            reference: self.reference,
            limits: self.limits.clone(),
            gate,
            start: self.start,
        }
    }
}
