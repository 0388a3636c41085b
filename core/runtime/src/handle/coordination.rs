//! What only the coordinator can do, on whichever node of the swarm it is.
//!
//! Must never do: ask a node that does not coordinate to decide.

use super::serving::take_leadership;
use super::{NodeHandle, PLAN_WITHIN};
use crate::coordinator::CoordinatorMessage;
use ractor::RpcReplyPort;
use ractor::rpc::CallResult;
use skein_domain::{FormationRequest, NodeId, Refusal, Route, VehicleId};
use skein_state::asks::{Answer, ApiAnswer, ApiRequest, Ask};
use skein_view::SwarmSnapshot;
use skein_view::{FormationForecast, FormationReceipt};
use std::time::Duration;

/// Longest wait for another node to take the leadership.
const LEADERSHIP_WITHIN: Duration = Duration::from_secs(3);
/// Longest wait for a control period that begins after something was asked.
const PICTURE_WITHIN: Duration = Duration::from_millis(500);
/// How often it is looked for.
const PICTURE_POLL: Duration = Duration::from_millis(2);
/// Longest wait for another node's answer to a request of the API.
const API_WITHIN: Duration = Duration::from_secs(20);

fn no_coordinator() -> Refusal {
    Refusal::not_running("a coordinator of this swarm (none is there)")
}

fn strange(node: NodeId) -> Refusal {
    Refusal::not_running(format!("node {node} (it answers something else)"))
}

impl NodeHandle {
    /// Asks another node of the swarm.
    pub(crate) async fn ask(&self, node: NodeId, ask: Ask, within: Duration) -> Result<Answer, Refusal> {
        self.shared.ask(node, ask, within).await
    }

    /// The node to be asked what only the coordinator can do; none if it is this one.
    ///
    /// # Errors
    /// When nobody coordinates, or this node commands nothing.
    pub(crate) fn coordinator_elsewhere(&self) -> Result<Option<NodeId>, Refusal> {
        let Some(swarm) = &self.shared.swarm else {
            return Ok(None);
        };
        let role = swarm.role();
        if role.observer {
            return Err(Refusal::not_permitted("this node is an observer"));
        }
        if role.acting.is_some() {
            return Ok(None);
        }
        role.coordinator().map(Some).ok_or_else(no_coordinator)
    }

    /// Flies a formation.
    ///
    /// # Errors
    /// When too few vehicles are available, no safe way into the slots is found, or nobody coordinates.
    pub async fn set_formation(&self, request: FormationRequest) -> Result<FormationReceipt, Refusal> {
        let Some(node) = self.coordinator_elsewhere()? else {
            return self.set_formation_here(request).await;
        };
        match self.ask(node, Ask::Formation(Box::new(request)), PLAN_WITHIN).await? {
            Answer::Formation(outcome) => outcome,
            _ => Err(strange(node)),
        }
    }

    pub(crate) async fn set_formation_here(&self, request: FormationRequest) -> Result<FormationReceipt, Refusal> {
        self.coordinate(|reply| CoordinatorMessage::SetFormation(Box::new(request), reply))
            .await
    }

    /// How a formation would be flown if it were asked for now.
    ///
    /// # Errors
    /// As [`Self::set_formation`].
    pub async fn foresee_formation(&self, request: FormationRequest) -> Result<FormationForecast, Refusal> {
        let Some(node) = self.coordinator_elsewhere()? else {
            return self.foresee_formation_here(request).await;
        };
        match self.ask(node, Ask::Forecast(Box::new(request)), PLAN_WITHIN).await? {
            Answer::Forecast(outcome) => *outcome,
            _ => Err(strange(node)),
        }
    }

    pub(crate) async fn foresee_formation_here(&self, request: FormationRequest) -> Result<FormationForecast, Refusal> {
        self.coordinate(|reply| CoordinatorMessage::ForeseeFormation(Box::new(request), reply))
            .await
    }

    /// Ends the formation; its members hold.
    ///
    /// # Errors
    /// When the coordinator is not running.
    pub async fn dissolve_formation(&self) -> Result<(), Refusal> {
        let Some(node) = self.coordinator_elsewhere()? else {
            return self.dissolve_formation_here().await;
        };
        self.done(node, Ask::Dissolve).await
    }

    pub(crate) async fn dissolve_formation_here(&self) -> Result<(), Refusal> {
        self.coordinate(CoordinatorMessage::Dissolve).await
    }

    pub(crate) async fn done(&self, node: NodeId, ask: Ask) -> Result<(), Refusal> {
        match self.ask(node, ask, PLAN_WITHIN).await? {
            Answer::Done(outcome) => outcome,
            _ => Err(strange(node)),
        }
    }

    /// Has the leader fly a route, as fast and as wide as the formation can; gives it as it is flown.
    ///
    /// # Errors
    /// When no formation is flown behind a leader, or the route is refused by the safety gate.
    pub async fn set_route(&self, route: Route) -> Result<Route, Refusal> {
        let Some(node) = self.coordinator_elsewhere()? else {
            return self.set_route_here(route).await;
        };
        match self.ask(node, Ask::Route(route), PLAN_WITHIN).await? {
            Answer::Route(outcome) => outcome,
            _ => Err(strange(node)),
        }
    }

    pub(crate) async fn set_route_here(&self, route: Route) -> Result<Route, Refusal> {
        self.coordinate(|reply| CoordinatorMessage::SetRoute(route, reply))
            .await
    }

    /// Plans are made from the picture of a control period, and whoever asks for one may have seen what came after it (the last vehicle
    /// has just come up): waits for a picture that has it all. A node too busy for that plans with what it has.
    async fn picture_of_now(&self) {
        let asked = self.shared.now();
        let fresh = async {
            while self.shared.peers().made < asked {
                tokio::time::sleep(PICTURE_POLL).await;
            }
        };
        let _ = tokio::time::timeout(PICTURE_WITHIN, fresh).await;
    }

    pub(super) async fn coordinate<T: Send + 'static>(
        &self,
        message: impl FnOnce(RpcReplyPort<Result<T, Refusal>>) -> CoordinatorMessage,
    ) -> Result<T, Refusal> {
        if !self.shared.coordinates() {
            return Err(no_coordinator());
        }
        self.ask_coordinator(message).await?
    }

    /// Asks the coordinator of this node.
    pub(super) async fn ask_coordinator<T: Send + 'static>(
        &self,
        message: impl FnOnce(RpcReplyPort<T>) -> CoordinatorMessage,
    ) -> Result<T, Refusal> {
        let not_running = || Refusal::not_running("the coordinator");
        let coordinator = self.parts.coordinator.load_full().ok_or_else(not_running)?;
        self.picture_of_now().await;
        match coordinator.call(message, Some(PLAN_WITHIN)).await {
            Ok(CallResult::Success(answer)) => Ok(answer),
            Ok(CallResult::Timeout) => Err(Refusal::timed_out("the coordinator", PLAN_WITHIN.as_secs_f64())),
            _ => Err(not_running()),
        }
    }

    /// The swarm this node is part of, if it is part of one.
    #[must_use]
    pub fn swarm(&self) -> Option<SwarmSnapshot> {
        match &self.shared.swarm {
            Some(swarm) => Some(swarm.picture().as_ref().clone()),
            // In no swarm; but a recording may be of one.
            None => self.snapshot().swarm.clone(),
        }
    }

    /// Has a node of the swarm take the leadership, although another one may hold it.
    ///
    /// # Errors
    /// When that node cannot coordinate, or does not answer.
    pub async fn make_coordinator(&self, node: NodeId) -> Result<(), Refusal> {
        let Some(swarm) = &self.shared.swarm else {
            return Err(Refusal::not_permitted(
                "this node flies its vehicles alone; it is in no swarm",
            ));
        };
        let role = swarm.role();
        if role.observer {
            return Err(Refusal::not_permitted("this node is an observer"));
        }
        if role.node == node {
            return take_leadership(self).await;
        }
        match self.ask(node, Ask::TakeLeadership, LEADERSHIP_WITHIN).await? {
            Answer::Done(outcome) => outcome,
            _ => Err(strange(node)),
        }
    }

    /// The node that flies a vehicle, if it is another one than this.
    #[must_use]
    pub fn host_elsewhere(&self, vehicle: VehicleId) -> Option<NodeId> {
        self.shared.host(vehicle)
    }

    /// Has another node answer a request of the API.
    ///
    /// # Errors
    /// When it does not answer.
    pub async fn api_elsewhere(&self, node: NodeId, request: ApiRequest) -> Result<ApiAnswer, Refusal> {
        match self.ask(node, Ask::Api(request), API_WITHIN).await? {
            Answer::Api(answer) => Ok(answer),
            _ => Err(strange(node)),
        }
    }

    /// Answers requests of other nodes' gateways from now on, in this way.
    pub fn serve_api(&self, server: skein_state::asks::ApiServer) {
        if let Some(swarm) = &self.shared.swarm {
            // Set once, when the node starts.
            swarm.serve(server);
        }
    }
}
