//! What the coordinator decides, as plain data and functions of what is on the board: who takes part, who leads, which slot, which
//! task. The coordinator actor calls them and publishes the result; its successor finds [`Coordination`] on the board and goes on.
//!
//! Must never do: read a clock or the board by itself, or send anything.

mod plan;
mod succession;
mod tasks;

pub use plan::{PlanInput, PlanLimits, fitted, plan};
pub use succession::{by_fitness, succeed};
pub use tasks::intent;

use crate::board::PeerSnapshot;
use skein_domain::{
    AnchorPlan, FormationControl, FormationHeading, FormationRequest, Keeping, NodeTime, PositionNed, Route, SlotMove,
    VehicleId,
};
use std::collections::BTreeMap;

/// Everything the coordinator must find again after a restart.
#[derive(Debug, Clone, Default)]
pub struct Coordination {
    /// The formation being flown.
    pub formation: Option<Formation>,
    /// The leader's route, kept apart so that a formation may change while it is flown.
    pub route: Option<ActiveRoute>,
    /// Vehicles that were seen taking off, so that a newcomer in the air is told from one that left.
    pub taking_off: Vec<VehicleId>,
}

/// A formation being flown.
#[derive(Debug, Clone)]
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
    /// How its heading is chosen.
    pub heading: FormationHeading,
    /// For control by neighbours: what each follower keeps once all are in their slots.
    pub keeping: BTreeMap<VehicleId, Keeping>,
    /// When the change was decided.
    pub decided: NodeTime,
    /// When all are to be in their slots.
    pub settled_at: NodeTime,
    /// Smallest distance foreseen on the way, in metres.
    pub min_distance_m: f64,
    /// How fast it can go as a whole, in metres per second: its slowest member's limit, with turns taken into account.
    pub max_speed_m_s: f64,
}

impl Formation {
    /// Whether its followers keep their places by their neighbours at this moment, and not by slots.
    #[must_use]
    pub fn keeps_itself(&self, now: NodeTime) -> bool {
        self.request.control != FormationControl::Slots && !self.keeping.is_empty() && now >= self.settled_at
    }
}

/// A route being flown.
#[derive(Debug, Clone)]
pub struct ActiveRoute {
    /// The whole route.
    pub route: Route,
    /// Index of the first waypoint not passed yet.
    pub next: usize,
    /// The leader reported the end.
    pub finished: bool,
}

impl ActiveRoute {
    /// What is left of it, for a new leader.
    #[must_use]
    pub fn remaining(&self) -> Option<Route> {
        let waypoints: Vec<PositionNed> = self.route.waypoints.iter().skip(self.next).copied().collect();
        (!self.finished && !waypoints.is_empty()).then(|| Route {
            waypoints,
            ..self.route.clone()
        })
    }

    /// Notes the waypoints that a leader at `position` has passed. A corner is rounded, so that near it counts as passed.
    pub fn advance(&mut self, position: &PositionNed) {
        let near_m = self.route.corner_radius_m + 2.0;
        while self.next + 1 < self.route.waypoints.len()
            && self
                .route
                .waypoints
                .get(self.next)
                .is_some_and(|w| w.horizontal_distance_m(position) < near_m)
        {
            self.next += 1;
        }
    }
}

/// Vehicles in the air, heard, with a position and in the swarm's hands.
#[must_use]
pub fn available(peers: &PeerSnapshot) -> Vec<VehicleId> {
    peers
        .entries
        .iter()
        .filter(|e| e.link.connected && e.kinematics.is_some() && e.airborne && e.flight_state.is_available_in_air())
        .map(|e| e.id)
        .collect()
}

#[cfg(test)]
mod tests;
