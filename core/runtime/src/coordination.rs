//! What the coordinator decides, as plain data and functions of what is on the board: who takes part, who leads, which slot, which
//! task. The coordinator actor calls them and publishes the result; its successor finds [`Coordination`] on the board and goes on.
//!
//! Must never do: read a clock or the board by itself, or send anything.

mod clocks;
mod membership;
mod plan;
mod route;
mod succession;
mod tasks;
mod trajectories;

pub use membership::{Changed, Judging};
pub use plan::{Placed, PlanInput, PlanLimits, plan, plan_with_places};
pub use route::ActiveRoute;
pub use succession::{by_fitness, succeed};
pub use tasks::intent;
pub use trajectories::{Flight, PlannedFlights, TrajectoryInput, plan_trajectories};

use crate::board::PeerSnapshot;
use serde::{Deserialize, Serialize};
use skein_domain::{
    AnchorPlan, FormationAnchor, FormationControl, FormationHeading, FormationRequest, Keeping, NodeTime, Route,
    SlotMove, VehicleId,
};
use std::collections::{BTreeMap, BTreeSet};

/// Everything the coordinator must find again after a restart.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Coordination {
    /// The formation being flown.
    pub formation: Option<Formation>,
    /// The leader's route, kept apart so that a formation may change while it is flown.
    pub route: Option<ActiveRoute>,
    /// Vehicles that were seen taking off, so that a newcomer in the air is told from one that left.
    pub taking_off: Vec<VehicleId>,
    /// Trajectories of single vehicles, also those that are over: what is told of them lasts until the vehicle is given another.
    pub flights: BTreeMap<VehicleId, Flight>,
    /// A formation that ended because the swarm came apart.
    #[serde(default)]
    pub interrupted: Option<Interrupted>,
    /// Members of the present formation that left it because they were not heard.
    #[serde(default)]
    pub unheard: BTreeSet<VehicleId>,
}

/// A formation that ended because the swarm came apart, to be flown again when those who were missing are back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interrupted {
    /// As it was asked for.
    pub request: FormationRequest,
    /// What was left of the leader's route.
    pub route: Option<Route>,
    /// Who was missing.
    pub missing: Vec<VehicleId>,
}

/// A formation being flown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Formation {
    /// As it was asked for, with the leader filled in.
    pub request: FormationRequest,
    /// Who leads; nobody if the anchor is no vehicle.
    pub leader: Option<VehicleId>,
    /// The anchor, if it is no vehicle.
    pub anchor: Option<AnchorPlan>,
    /// Who takes part, leader first.
    pub members: Vec<VehicleId>,
    /// Each follower's way into its slot.
    pub slots: BTreeMap<VehicleId, SlotMove>,
    /// How its heading is chosen once it is formed.
    pub heading: FormationHeading,
    /// The same until then: with members far outside of their places it turns more slowly.
    pub heading_while_forming: FormationHeading,
    /// For control by neighbours: what each follower keeps once all are in their slots.
    pub keeping: BTreeMap<VehicleId, Keeping>,
    /// When the change was decided.
    pub decided: NodeTime,
    /// When all are to be in their slots.
    pub settled_at: NodeTime,
    /// Smallest distance foreseen on the way, in metres.
    pub min_distance_m: f64,
    /// Members that carry a camera and whose places leave it no free view.
    pub view_blocked: Vec<VehicleId>,
    /// How fast it can go as a whole, in metres per second: its slowest member's limit, with turns taken into account.
    pub max_speed_m_s: f64,
}

impl Formation {
    /// How far its outermost place is from its anchor on the ground, in metres.
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        let reach = |slot: &SlotMove| slot.to.forward_m.hypot(slot.to.right_m);
        self.slots.values().map(reach).fold(0.0, f64::max)
    }

    /// Smallest distance foreseen on the way between any two, in metres; none for one alone.
    #[must_use]
    pub fn apart_m(&self) -> Option<f64> {
        Some(self.min_distance_m).filter(|apart_m| apart_m.is_finite())
    }

    /// Whether all are to be in their slots by this moment.
    #[must_use]
    pub fn is_settled(&self, now: NodeTime) -> bool {
        now >= self.settled_at
    }

    /// How its heading is chosen at this moment.
    #[must_use]
    pub fn heading_at(&self, now: NodeTime) -> FormationHeading {
        if self.is_settled(now) {
            self.heading
        } else {
            self.heading_while_forming
        }
    }

    /// What it is anchored to at this moment, if that is no vehicle.
    #[must_use]
    pub fn anchor_at(&self, now: NodeTime) -> Option<AnchorPlan> {
        match self.anchor.clone()? {
            AnchorPlan::Reference { name, .. } => Some(AnchorPlan::Reference {
                name,
                heading: self.heading_at(now),
                places: self.slots.values().map(|slot| slot.to).collect(),
            }),
            other => Some(other),
        }
    }

    /// Whether its followers keep their places by their neighbours at this moment, and not by slots.
    #[must_use]
    pub fn keeps_itself(&self, now: NodeTime) -> bool {
        self.request.control != FormationControl::Slots && !self.keeping.is_empty() && self.is_settled(now)
    }

    /// The same with its motion beginning at `start`: planning took time.
    #[must_use]
    pub fn beginning(mut self, start: NodeTime) -> Self {
        let late_s = start.seconds_since(self.decided);
        for slot in self.slots.values_mut() {
            slot.start = slot.start.plus_seconds(late_s);
        }
        for keeping in self.keeping.values_mut() {
            keeping.start = keeping.start.plus_seconds(late_s);
        }
        let settled_at = self.settled_at;
        // A virtual leader that sets off when they are formed; one that is under way already keeps its time.
        if let Some(AnchorPlan::Path { start, .. }) = &mut self.anchor
            && *start == settled_at
        {
            *start = start.plus_seconds(late_s);
        }
        self.settled_at = settled_at.plus_seconds(late_s);
        self.decided = start;
        self
    }
}

impl Coordination {
    /// How fast the anchor of a formation goes along its way in metres per second, if it has one, and whether it does so now: a virtual
    /// leader that is new waits until they are formed.
    #[must_use]
    pub fn way(&self, request: &FormationRequest) -> (Option<f64>, bool) {
        if let FormationAnchor::Path { route } = &request.anchor {
            let goes_on = self
                .formation
                .as_ref()
                .is_some_and(|f| f.request.anchor == request.anchor);
            return (Some(route.speed_m_s), goes_on);
        }
        let route = self.route.as_ref().filter(|r| !r.finished);
        (route.map(|r| r.route.speed_m_s), route.is_some())
    }

    /// Where the anchor of a formation goes from here: what is left of its leader's route, or a new path.
    #[must_use]
    pub fn ahead(&self, request: &FormationRequest) -> Option<Route> {
        match &request.anchor {
            FormationAnchor::Leader => self.route.as_ref()?.remaining(),
            FormationAnchor::Path { route } => {
                let goes_on = self
                    .formation
                    .as_ref()
                    .is_some_and(|f| f.request.anchor == request.anchor);
                (!goes_on).then(|| route.clone())
            }
            FormationAnchor::Place { .. } | FormationAnchor::Reference { .. } => None,
        }
    }

    /// Takes up a formation; a new leader takes over what is left of the route. Whether the leader is another than before.
    pub fn take_up(&mut self, formation: Formation) -> bool {
        let former = self.formation.as_ref().map(|f| f.leader);
        let changed = former.is_some_and(|leader| leader != formation.leader);
        if changed && let Some(active) = self.route.take() {
            let left = active.remaining().filter(|_| formation.leader.is_some());
            self.route = left.map(|route| ActiveRoute {
                route,
                next: 0,
                finished: false,
            });
        }
        self.formation = Some(formation);
        changed
    }

    /// Notes how far the leader has come, for a successor.
    pub fn follow_route(&mut self, peers: &PeerSnapshot, finished: impl Fn(VehicleId) -> bool) {
        let Some(leader) = self.formation.as_ref().and_then(|f| f.leader) else {
            return;
        };
        let position = peers.entry(leader).and_then(|e| e.kinematics).map(|k| k.position);
        if let (Some(active), Some(position)) = (self.route.as_mut(), position) {
            active.advance(&position);
            active.finished |= finished(leader);
        }
    }
}

/// Vehicles in the air, heard, with a position and in the swarm's hands.
#[must_use]
pub fn available(peers: &PeerSnapshot) -> Vec<VehicleId> {
    peers
        .entries
        .iter()
        .filter(|e| e.link.connected && e.kinematics.is_some() && e.airborne && !e.under_order)
        .filter(|e| e.flight_state.is_available_in_air())
        .map(|e| e.id)
        .collect()
}

#[cfg(test)]
mod tests;
