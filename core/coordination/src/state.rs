//! What the coordinator must find again after a restart, and its successor at another node: formation, route, trajectories, who is missed.
//!
//! Must never do: read a clock, or send anything.

use crate::formation::Formation;
use serde::{Deserialize, Serialize};
use skein_domain::{
    FormationAnchor, FormationRequest, JourneyPlan, NodeTime, PositionNed, Route, Trajectory, VehicleId,
};
use skein_view::PeerSnapshot;
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

/// A route being flown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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

/// One vehicle's trajectory, and how far it has got.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Flight {
    /// What it flies.
    pub trajectory: Trajectory,
    /// What was planned of it.
    pub plan: JourneyPlan,
    /// Its waypoints.
    pub waypoints: Vec<PositionNed>,
    /// It has come to the end.
    pub finished: bool,
    /// It does something else by now, and why.
    pub ended: Option<String>,
}

impl Flight {
    /// Whether it is to be flown still, or held at its end.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.ended.is_none()
    }

    /// Whether its time has come.
    #[must_use]
    pub fn begun(&self, now: NodeTime) -> bool {
        self.trajectory.start <= now
    }
}
