//! The coordinator actor: turns what operators ask into intent (who leads, which formation, which slot), and keeps it true when
//! vehicles are lost, leave or join. It publishes intent and never a setpoint: its end stops nothing that flies.
//!
//! Bound: one plan to regroup is made at a time; reviews that come meanwhile do not ask for another. Must never do: wait for a vehicle,
//! or for a plan.

mod leadership;
mod planning;
mod relief;
mod trajectories;

pub use planning::Planned;
pub use trajectories::{PlannedTrajectories, TrajectoryAnswer, TrajectoryAsk};

use planning::Purpose;
use ractor::{Actor, ActorProcessingErr, ActorRef, RpcReplyPort};
use skein_coordination::{self as coordination, Coordination, Formation};
use skein_domain::exchange::Severity;
use skein_domain::{FormationAnchor, FormationRequest, NodeTime, Refusal, Route, VehicleId};
use skein_failover::Term;
use skein_state::SharedState;
use skein_view::EventKind;
use skein_view::PeerSnapshot;
use skein_view::{FormationForecast, FormationReceipt};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

/// How often the coordinator looks whether the formation is still whole.
const REVIEW_PERIOD: Duration = Duration::from_millis(100);

/// Time between a decision and the start of the motion in seconds: all vehicles must have the intent by then.
const LEAD_TIME_S: f64 = 0.1;

/// The actor.
pub struct Coordinator;

/// What the coordinator is told. Private to the runtime.
pub enum CoordinatorMessage {
    /// Fly this formation.
    SetFormation(Box<FormationRequest>, RpcReplyPort<Result<FormationReceipt, Refusal>>),
    /// How would this formation be flown?
    ForeseeFormation(Box<FormationRequest>, RpcReplyPort<Result<FormationForecast, Refusal>>),
    /// End the formation; its members hold.
    Dissolve(RpcReplyPort<Result<(), Refusal>>),
    /// The leader is to fly this route.
    SetRoute(Route, RpcReplyPort<Result<Route, Refusal>>),
    /// A plan is there.
    Planned(Box<Planned>),
    /// Plan trajectories of single vehicles, and fly them if that is asked for.
    PlanTrajectories(Box<TrajectoryAsk>),
    /// Trajectories are planned.
    TrajectoriesPlanned(Box<PlannedTrajectories>),
    /// End all trajectories.
    EndTrajectories(RpcReplyPort<Result<Vec<VehicleId>, Refusal>>),
    /// Look whether the leader is still there: every control period.
    Watch,
    /// Look whether the formation is still whole.
    Review,
}

/// State: all that must survive is in the shared state.
pub struct CoordinatorState {
    shared: Arc<SharedState>,
    /// Grows with every change of the formation: a plan made for an earlier one does not fit.
    generation: u64,
    /// Grows with every change of the trajectories.
    flights_version: u64,
    /// A plan to regroup is being made.
    regrouping: bool,
    /// The formation is not in the shape that was asked for: to be planned anew.
    reshape: bool,
    /// All are in their slots, as published.
    settled: bool,
    /// Newcomers that wait for the next plan.
    joins: Vec<VehicleId>,
    /// A plan to regroup failed: the next is not made before.
    not_before: NodeTime,
    /// Why it could not, as last told, and when.
    told_cannot: Option<(String, NodeTime)>,
    /// The term in which it decides, in a swarm of several nodes.
    term: Option<Term>,
    /// Its node heard no other one when it was last looked.
    cut_off: bool,
    /// Whom its node succeeded, until it has looked who else is missed.
    lost_leader: Option<leadership::LostLeader>,
}

impl Actor for Coordinator {
    type Msg = CoordinatorMessage;
    type State = CoordinatorState;
    type Arguments = Arc<SharedState>;

    async fn pre_start(
        &self,
        myself: ActorRef<CoordinatorMessage>,
        shared: Arc<SharedState>,
    ) -> Result<CoordinatorState, ActorProcessingErr> {
        let period = Duration::from_secs_f64(1.0 / shared.config.node.control_rate_hz);
        myself.send_interval(period, || CoordinatorMessage::Watch);
        myself.send_after(REVIEW_PERIOD, || CoordinatorMessage::Review);
        let settled = is_settled(&shared.coordination.read(), shared.now());
        Ok(CoordinatorState {
            shared,
            generation: 0,
            flights_version: 0,
            regrouping: false,
            reshape: false,
            settled,
            joins: Vec::new(),
            not_before: NodeTime::default(),
            told_cannot: None,
            term: None,
            cut_off: false,
            lost_leader: None,
        })
    }

    async fn handle(
        &self,
        myself: ActorRef<CoordinatorMessage>,
        message: CoordinatorMessage,
        state: &mut CoordinatorState,
    ) -> Result<(), ActorProcessingErr> {
        // A reply whose asker has gone is no error.
        match message {
            CoordinatorMessage::SetFormation(request, reply) => match state.admit(&request) {
                Ok(()) => state.begin_plan(&myself, *request, Purpose::Asked(reply), 0),
                Err(refusal) => drop(reply.send(Err(refusal))),
            },
            CoordinatorMessage::ForeseeFormation(request, reply) => match state.admit(&request) {
                Ok(()) => state.begin_plan(&myself, *request, Purpose::Foreseen(reply), 0),
                Err(refusal) => drop(reply.send(Err(refusal))),
            },
            CoordinatorMessage::Dissolve(reply) => {
                state.shared.coordination.change().interrupted = None;
                state.dissolve();
                let _ = reply.send(Ok(()));
            }
            CoordinatorMessage::SetRoute(route, reply) => {
                let _ = reply.send(state.set_route(route));
            }
            CoordinatorMessage::Planned(planned) => state.take_plan(&myself, *planned),
            CoordinatorMessage::PlanTrajectories(ask) => state.begin_trajectories(&myself, *ask, 0),
            CoordinatorMessage::TrajectoriesPlanned(planned) => state.take_trajectories(&myself, *planned),
            CoordinatorMessage::EndTrajectories(reply) => drop(reply.send(Ok(state.end_trajectories()))),
            CoordinatorMessage::Watch => state.watch(),
            CoordinatorMessage::Review => {
                state.review(&myself);
                myself.send_after(REVIEW_PERIOD, || CoordinatorMessage::Review);
            }
        }
        Ok(())
    }
}

fn is_settled(coordination: &Coordination, now: NodeTime) -> bool {
    coordination.formation.as_ref().is_some_and(|f| f.is_settled(now))
}

impl CoordinatorState {
    /// Whether a request can be planned at all.
    fn admit(&self, request: &FormationRequest) -> Result<(), Refusal> {
        if let FormationAnchor::Path { route } = &request.anchor {
            self.shared.gate().route(route)?;
        }
        if self.shared.frame().is_none() {
            return Err(Refusal::NoSwarmFrame);
        }
        Ok(())
    }

    fn fly(&mut self, formation: Formation, severity: Severity, text: String) {
        let view_blocked = formation.view_blocked.clone();
        self.leave_trajectories(&formation.members);
        let leader_changed = self.shared.coordination.change().take_up(formation);
        self.generation += 1;
        if leader_changed {
            self.clear_anchors();
        }
        self.publish();
        self.record(severity, text);
        if !view_blocked.is_empty() {
            let text = format!("no free view for the camera of {}", list(&view_blocked));
            self.record(Severity::Advisory, text);
        }
    }

    fn record(&self, severity: Severity, text: impl Into<String>) {
        self.shared
            .events
            .record(self.shared.now(), None, severity, EventKind::Formation, text);
    }

    /// The anchor of a former leader must not be followed.
    fn clear_anchors(&self) {
        let coordination = self.shared.coordination.read();
        let leader = coordination.formation.as_ref().and_then(|f| f.leader);
        drop(coordination);
        for record in self.shared.vehicles.records() {
            if Some(record.id) != leader {
                record.forget_anchor();
            }
        }
        if let Some(swarm) = &self.shared.swarm {
            for (id, remote) in swarm.change_vehicles().iter_mut() {
                if Some(*id) != leader {
                    remote.anchor = None;
                }
            }
        }
    }

    fn publish(&mut self) {
        let now = self.shared.now();
        let coordination = self.shared.coordination.read();
        self.settled = is_settled(&coordination, now);
        let before = self.shared.coordination.intent();
        let withdrawn = self.shared.vehicles.withdrawn();
        let intent = coordination::intent(&before, &coordination, &withdrawn, now);
        drop(coordination);
        let intent = self.with_holds(intent, &before, &withdrawn);
        self.shared.coordination.publish(self.outranking(intent));
    }

    fn dissolve(&mut self) {
        {
            let mut coordination = self.shared.coordination.change();
            coordination.formation = None;
            coordination.route = None;
            coordination.unheard.clear();
        }
        self.generation += 1;
        self.reshape = false;
        self.joins.clear();
        self.publish();
        self.clear_anchors();
        self.record(Severity::Info, "formation dissolved");
    }

    /// Has the leader fly a route, as fast and as wide as the formation can; gives it as it is flown.
    fn set_route(&mut self, route: Route) -> Result<Route, Refusal> {
        let peers = self.shared.peers();
        let asked_m_s = route.speed_m_s;
        let (limits, gate) = (self.plan_limits(), self.shared.gate());
        let fitted = (self.shared.coordination.change()).set_route(route, &peers, &limits, &gate)?;
        let slower = fitted.speed_m_s < asked_m_s;
        for record in self.shared.vehicles.records() {
            record.forget_finished_route();
        }
        self.publish();
        let text = if slower {
            format!(
                "the leader flies a new route at {:.1} m/s: the slowest member allows no more",
                fitted.speed_m_s
            )
        } else {
            "the leader flies a new route".to_owned()
        };
        self.record(Severity::Info, text);
        Ok(fitted)
    }

    /// Every control period: a leader that is lost is replaced at once, without planning; a shape that has been reached is handed to its
    /// members where they keep it by themselves.
    fn watch(&mut self) {
        let now = self.shared.now();
        if !self.is_leading() {
            return;
        }
        self.shared.coordination.see_coordinator(self.shared.now());
        let Some(formation) = self.shared.coordination.read().formation.clone() else {
            return;
        };
        let peers = self.shared.peers();
        let withdrawn = self.shared.vehicles.withdrawn();
        if let Some(lost) = self
            .judging(&formation, &peers, &withdrawn, now)
            .lost_leader(&formation)
        {
            let order = self.plan_limits().leader_order;
            if let Some(next) = coordination::succeed(&formation, lost, now, &order, &peers) {
                self.note_passed_over(&peers, lost);
                let leader = next.leader.map_or_else(String::new, |id| id.to_string());
                self.reshape = true;
                let text = format!("leader {lost} is lost: vehicle {leader} leads");
                self.fly(next, Severity::Advisory, text);
                return;
            }
        }
        if formation.is_settled(now) != self.settled {
            self.publish();
            if formation.keeps_itself(now) {
                self.record(
                    Severity::Info,
                    "formed: the members keep their places by their neighbours",
                );
            }
        }
    }

    /// Keeps the formation true to what is there.
    fn review(&mut self, myself: &ActorRef<CoordinatorMessage>) {
        // A lost leader is succeeded, with everyone where they are, before anything is planned without it.
        let generation = self.generation;
        self.watch();
        if !self.shared.coordinates() {
            return;
        }
        if self.generation != generation {
            // Who has just lost the lead still shows the state it had: the next review sees who is left.
            return;
        }
        let peers = self.shared.peers();
        self.review_trajectories(&peers);
        let now = self.shared.now();
        let finished = |leader| self.has_finished_route(leader);
        let (newcomers, formation) = {
            let mut coordination = self.shared.coordination.change();
            coordination.follow_route(&peers, finished);
            (coordination.newcomers(&peers), coordination.formation.clone())
        };
        let Some(formation) = formation else {
            self.joins.clear();
            self.resume(myself, &peers);
            return;
        };
        if formation.request.members.is_none() {
            self.joins.extend(newcomers);
            self.take_back(&peers);
            self.take_back_heard(&peers);
        }
        self.relieve(&formation, &peers);
        if self.regrouping || now < self.not_before {
            return;
        }
        let withdrawn = self.shared.vehicles.withdrawn();
        let judging = self.judging(&formation, &peers, &withdrawn, now);
        if let Some(changed) = judging.changed(&formation, &self.joins, self.reshape) {
            self.note_unheard(&peers, &changed.gone);
            if self.is_apart(&formation) {
                self.thin_out(&formation, &changed.gone);
            } else {
                self.regroup(myself, &formation, changed);
            }
        }
    }

    fn judging<'a>(
        &self,
        formation: &Formation,
        peers: &'a PeerSnapshot,
        withdrawn: &'a BTreeSet<VehicleId>,
        now: NodeTime,
    ) -> coordination::Judging<'a> {
        let leader = formation.leader.and_then(|leader| peers.entry(leader));
        let overrun = self.shared.overrun();
        coordination::Judging {
            peers,
            withdrawn,
            leader_lost_after_s: self.shared.config.coordinator.leader_lost_after_s,
            leader_silence_s: leader.map_or(0.0, |leader| overrun.silence_s(leader.link.last_heard, now)),
            now,
        }
    }
}

fn list<Id: ToString>(ids: &[Id]) -> String {
    if ids.is_empty() {
        return "nobody".into();
    }
    ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
