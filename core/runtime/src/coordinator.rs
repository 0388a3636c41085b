//! The coordinator actor: turns what operators ask into intent (who leads, which formation, which slot), and keeps it true when
//! vehicles are lost, leave or join. It publishes intent and never a setpoint: its end stops nothing that flies.
//!
//! Bound: reviews that come while one is being made are dropped. Must never do: wait for a vehicle.

use crate::board::{Board, PeerSnapshot};
use crate::coordination::{self, ActiveRoute, Coordination, Formation, PlanInput, PlanLimits};
use crate::handle::FormationReceipt;
use crate::snapshot::EventKind;
use ractor::{Actor, ActorProcessingErr, ActorRef, RpcReplyPort};
use skein_domain::exchange::Severity;
use skein_domain::{FlightState, FormationRequest, NodeTime, Refusal, Route, VehicleId};
use std::sync::Arc;
use std::time::Duration;

/// How often the coordinator looks whether the formation is still whole.
const REVIEW_PERIOD: Duration = Duration::from_millis(100);

/// Time between a decision and the start of the motion in seconds: all vehicles must have the intent by then.
const LEAD_TIME_S: f64 = 0.1;

/// A member that has not taken up its task after so long, in seconds, has left the formation.
const TAKE_UP_S: f64 = 1.5;

/// The actor.
pub struct Coordinator;

/// What the coordinator is told. Private to the runtime.
pub enum CoordinatorMessage {
    /// Fly this formation.
    SetFormation(FormationRequest, RpcReplyPort<Result<FormationReceipt, Refusal>>),
    /// End the formation; its members hold.
    Dissolve(RpcReplyPort<Result<(), Refusal>>),
    /// The leader is to fly this route.
    SetRoute(Route, RpcReplyPort<Result<(), Refusal>>),
    /// Look whether the formation is still whole.
    Review,
}

/// State: all that must survive is on the board.
pub struct CoordinatorState {
    board: Arc<Board>,
}

impl Actor for Coordinator {
    type Msg = CoordinatorMessage;
    type State = CoordinatorState;
    type Arguments = Arc<Board>;

    async fn pre_start(
        &self,
        myself: ActorRef<CoordinatorMessage>,
        board: Arc<Board>,
    ) -> Result<CoordinatorState, ActorProcessingErr> {
        myself.send_after(REVIEW_PERIOD, || CoordinatorMessage::Review);
        Ok(CoordinatorState { board })
    }

    async fn handle(
        &self,
        myself: ActorRef<CoordinatorMessage>,
        message: CoordinatorMessage,
        state: &mut CoordinatorState,
    ) -> Result<(), ActorProcessingErr> {
        // A reply whose asker has gone is no error.
        match message {
            CoordinatorMessage::SetFormation(request, reply) => {
                let _ = reply.send(state.set_formation(request).await);
            }
            CoordinatorMessage::Dissolve(reply) => {
                let _ = reply.send(state.dissolve());
            }
            CoordinatorMessage::SetRoute(route, reply) => {
                let _ = reply.send(state.set_route(route));
            }
            CoordinatorMessage::Review => {
                state.review().await;
                myself.send_after(REVIEW_PERIOD, || CoordinatorMessage::Review);
            }
        }
        Ok(())
    }
}

impl CoordinatorState {
    async fn set_formation(&mut self, request: FormationRequest) -> Result<FormationReceipt, Refusal> {
        if !(request.spacing_m.is_finite() && request.altitude_step_m.is_finite()) {
            return Err(Refusal::InvalidValue {
                detail: "spacing and altitude step must be numbers".into(),
            });
        }
        self.board.gate.formation(request.spacing_m)?;
        if self.board.frame().is_none() {
            return Err(Refusal::NoSwarmFrame);
        }
        let formation = self.plan(request).await?;
        // The operator calls them back.
        self.board.withdrawn.lock().retain(|id| !formation.members.contains(id));
        let receipt = FormationReceipt {
            leader: formation.leader,
            members: formation.members.clone(),
            duration_s: formation.settled_at.seconds_since(formation.decided),
            planned_min_distance_m: formation.min_distance_m,
        };
        let text = format!(
            "formation {:?} of {} behind vehicle {}: {:.1} s, {:.1} m apart at least",
            formation.request.shape,
            formation.members.len(),
            formation.leader,
            receipt.duration_s,
            receipt.planned_min_distance_m
        );
        self.fly(formation, Severity::Info, text);
        Ok(receipt)
    }

    /// Plans on another thread: with many vehicles it takes longer than a control period.
    async fn plan(&self, request: FormationRequest) -> Result<Formation, Refusal> {
        let peers = self.board.peers.load_full();
        let coordination = self.board.coordination.lock().clone();
        let config = &self.board.config;
        let input = PlanInput {
            request,
            route_speed_m_s: coordination
                .route
                .as_ref()
                .filter(|r| !r.finished)
                .map(|r| r.route.speed_m_s),
            before: coordination.formation,
            limits: PlanLimits::new(&config.coordinator, config.safety.max_speed_m_s),
            start: self.board.now().plus_seconds(LEAD_TIME_S),
        };
        let planned = tokio::task::spawn_blocking(move || coordination::plan(&input, &peers)).await;
        let mut formation = planned.map_err(|_| Refusal::NotRunning {
            what: "the formation planner".into(),
        })??;
        shift_start(&mut formation, self.board.now().plus_seconds(LEAD_TIME_S));
        Ok(formation)
    }

    fn fly(&self, formation: Formation, severity: Severity, text: String) {
        let leader_changed = {
            let mut coordination = self.board.coordination.lock();
            let changed = coordination
                .formation
                .as_ref()
                .is_some_and(|f| f.leader != formation.leader);
            if changed && let Some(active) = coordination.route.take() {
                coordination.route = active.remaining().map(|route| ActiveRoute {
                    route,
                    next: 0,
                    finished: false,
                });
            }
            coordination.formation = Some(formation);
            changed
        };
        if leader_changed {
            self.clear_anchors();
        }
        self.publish();
        self.board
            .events
            .record(self.board.now(), None, severity, EventKind::Formation, text);
    }

    /// The anchor of a former leader must not be followed.
    fn clear_anchors(&self) {
        let leader = self.board.coordination.lock().formation.as_ref().map(|f| f.leader);
        for cell in self.board.cells() {
            if Some(cell.id) != leader {
                cell.state.lock().anchor = None;
            }
        }
    }

    fn publish(&self) {
        let coordination = self.board.coordination.lock();
        let before = self.board.intent.load();
        let withdrawn = self.board.withdrawn.lock().clone();
        let intent = coordination::intent(&before, &coordination, &withdrawn);
        self.board.intent.store(Arc::new(intent));
    }

    fn dissolve(&self) -> Result<(), Refusal> {
        {
            let mut coordination = self.board.coordination.lock();
            coordination.formation = None;
            coordination.route = None;
        }
        self.publish();
        self.clear_anchors();
        let now = self.board.now();
        self.board
            .events
            .record(now, None, Severity::Info, EventKind::Formation, "formation dissolved");
        Ok(())
    }

    fn set_route(&self, route: Route) -> Result<(), Refusal> {
        let leader = self.board.coordination.lock().formation.as_ref().map(|f| f.leader);
        let leader = leader.ok_or(Refusal::NotEnoughVehicles { have: 0, need: 1 })?;
        let kinematics = self.board.peers.load().entry(leader).and_then(|e| e.kinematics);
        let start = kinematics.ok_or(Refusal::NoPosition)?.position;
        self.board.gate.route_from(&start, &route)?;
        self.board.coordination.lock().route = Some(ActiveRoute {
            route,
            next: 0,
            finished: false,
        });
        for cell in self.board.cells() {
            cell.state.lock().route_finished = None;
        }
        self.publish();
        let now = self.board.now();
        self.board.events.record(
            now,
            None,
            Severity::Info,
            EventKind::Formation,
            "the leader flies a new route",
        );
        Ok(())
    }

    /// Keeps the formation true to what is there.
    async fn review(&mut self) {
        let peers = self.board.peers.load_full();
        let now = self.board.now();
        self.follow_route(&peers);
        let newcomers = self.newcomers(&peers);
        let Some(formation) = self.board.coordination.lock().formation.clone() else {
            return;
        };
        let gone: Vec<VehicleId> = formation
            .members
            .iter()
            .copied()
            .filter(|id| self.has_left(&formation, *id, &peers, now))
            .collect();
        let mut joins = if formation.request.members.is_none() {
            newcomers
        } else {
            Vec::new()
        };
        joins.extend(self.strays(&formation, &peers));
        if gone.is_empty() && joins.is_empty() {
            return;
        }
        let mut members: Vec<VehicleId> = formation
            .members
            .iter()
            .copied()
            .filter(|id| !gone.contains(id))
            .collect();
        members.extend(joins.iter().filter(|id| !formation.members.contains(id)));
        let present = coordination::available(&peers);
        let withdrawn = self.board.withdrawn.lock().clone();
        members.retain(|id| present.contains(id) && !withdrawn.contains(id));
        self.regroup(&formation, members, &gone, &joins).await;
    }

    async fn regroup(&self, formation: &Formation, members: Vec<VehicleId>, gone: &[VehicleId], joins: &[VehicleId]) {
        if members.is_empty() {
            // Told by `dissolve` itself.
            let _ = self.dissolve();
            return;
        }
        let explicit = formation.request.members.is_some();
        let request = FormationRequest {
            members: Some(members),
            ..formation.request.clone()
        };
        let text = format!("formation regroups: left {}, joined {}", list(gone), list(joins));
        match self.plan(request).await {
            Ok(mut planned) => {
                if !explicit {
                    planned.request.members = None;
                }
                self.fly(planned, Severity::Advisory, text);
            }
            Err(refusal) => {
                let text = format!("{text}; but it cannot: {refusal}");
                self.board
                    .events
                    .record(self.board.now(), None, Severity::Warning, EventKind::Formation, text);
            }
        }
    }

    /// Whether a member cannot be counted on any more.
    fn has_left(&self, formation: &Formation, id: VehicleId, peers: &PeerSnapshot, now: NodeTime) -> bool {
        let Some(entry) = peers.entry(id) else { return true };
        if self.board.withdrawn.lock().contains(&id) {
            return true;
        }
        let leader_limit_s = self.board.config.coordinator.leader_lost_after_s;
        let silent_s = now.seconds_since(entry.link.last_heard);
        if !entry.link.connected || (id == formation.leader && silent_s > leader_limit_s) {
            return true;
        }
        let wanted = if id == formation.leader {
            FlightState::Leading
        } else {
            FlightState::Following
        };
        if entry.flight_state == wanted {
            return false;
        }
        // Holding may mean that the task has not been taken up yet; anything not available in the air is gone at once.
        !entry.flight_state.is_available_in_air() || now.seconds_since(formation.decided) > TAKE_UP_S
    }

    /// Vehicles that fly in the formation without belonging to it: taken out for a command that they then refused.
    fn strays(&self, formation: &Formation, peers: &PeerSnapshot) -> Vec<VehicleId> {
        let withdrawn = self.board.withdrawn.lock();
        let flies_along = |state| matches!(state, FlightState::Following | FlightState::Leading);
        let entries = peers.entries.iter().filter(|e| flies_along(e.flight_state));
        let stray = |id: &VehicleId| !formation.members.contains(id) && !withdrawn.contains(id);
        entries.map(|e| e.id).filter(stray).collect()
    }

    /// Vehicles that have just come up from the ground.
    fn newcomers(&self, peers: &PeerSnapshot) -> Vec<VehicleId> {
        let mut coordination = self.board.coordination.lock();
        let mut newcomers = Vec::new();
        for entry in &peers.entries {
            let was = coordination.taking_off.contains(&entry.id);
            match entry.flight_state {
                FlightState::TakingOff if !was => coordination.taking_off.push(entry.id),
                FlightState::TakingOff => {}
                FlightState::Holding if was => {
                    coordination.taking_off.retain(|id| *id != entry.id);
                    newcomers.push(entry.id);
                }
                _ if was => coordination.taking_off.retain(|id| *id != entry.id),
                _ => {}
            }
        }
        newcomers
    }

    /// Notes how far the leader has come, for a successor.
    fn follow_route(&self, peers: &PeerSnapshot) {
        let mut coordination: parking_lot::MutexGuard<'_, Coordination> = self.board.coordination.lock();
        let Some(leader) = coordination.formation.as_ref().map(|f| f.leader) else {
            return;
        };
        let position = peers.entry(leader).and_then(|e| e.kinematics).map(|k| k.position);
        let finished = self
            .board
            .cell(leader)
            .is_some_and(|cell| cell.state.lock().route_finished.is_some());
        if let (Some(active), Some(position)) = (coordination.route.as_mut(), position) {
            active.advance(&position);
            active.finished |= finished;
        }
    }
}

/// Planning took time: the motion starts from now on, not from when planning began.
fn shift_start(formation: &mut Formation, start: NodeTime) {
    let late_s = start.seconds_since(formation.decided);
    for slot in formation.slots.values_mut() {
        slot.start = slot.start.plus_seconds(late_s);
    }
    formation.settled_at = formation.settled_at.plus_seconds(late_s);
    formation.decided = start;
}

fn list(ids: &[VehicleId]) -> String {
    if ids.is_empty() {
        return "nobody".into();
    }
    ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
