//! The life of a vehicle's UAV-model instance: create, call, snapshot, restart after a failure with the last snapshot, give up.

use super::VehicleState;
use crate::restart::{Decision, RestartHistory, VEHICLE_LIMITS};
use crate::snapshot::{ActorHealth, ActorStatus, EventKind};
use skein_domain::exchange::{Create, Event, EventBatch, Severity};
use skein_domain::{AutopilotCommand, CommandId, FlightMode, FlightState, Incarnation, NodeTime, Refusal, RequestId};
use skein_plugin_host::Instance;

/// How often a snapshot is taken while nothing special happens, in seconds: what a restarted model may be behind.
const SNAPSHOT_EVERY_S: f64 = 0.2;

/// The request id of requests that the actor itself makes, beyond what models use.
const ACTOR_REQUEST: RequestId = RequestId(u32::MAX);

/// The model instance and what is needed to start it again.
pub(super) struct Model {
    instance: Option<Instance>,
    incarnation: Incarnation,
    history: RestartHistory,
    /// Not started again before; `None` when given up.
    start_at: Option<NodeTime>,
    snapshot_at: NodeTime,
    /// A refusal reported within the present call, for the command's receipt.
    refusal: Option<(CommandId, Refusal)>,
}

impl Model {
    pub(super) fn new(incarnation: Incarnation) -> Self {
        Self {
            instance: None,
            incarnation,
            history: RestartHistory::default(),
            start_at: Some(NodeTime(0)),
            snapshot_at: NodeTime(0),
            refusal: None,
        }
    }

    pub(super) fn is_running(&self) -> bool {
        self.instance.is_some()
    }

    pub(super) fn incarnation(&self) -> Incarnation {
        self.incarnation
    }

    pub(super) fn note_refusal(&mut self, id: CommandId, refusal: Refusal) {
        self.refusal = Some((id, refusal));
    }

    pub(super) fn take_refusal(&mut self, id: CommandId) -> Option<Refusal> {
        self.refusal
            .take_if(|(noted, _)| *noted == id)
            .map(|(_, refusal)| refusal)
    }
}

impl VehicleState {
    /// Starts the model if it is not running and its back-off is over; tells whether it runs.
    pub(super) async fn ensure_model(&mut self) -> bool {
        if self.model.is_running() {
            return true;
        }
        let now = self.board.now();
        if self.model.start_at.is_none_or(|at| at > now) {
            return false;
        }
        let create = Create {
            vehicle: self.cell.id,
            incarnation: self.model.incarnation,
            config_json: self.cell.model_config_json.clone(),
            snapshot: self.cell.snapshot.lock().clone(),
            now,
            payload: None,
            system_id: Some(self.cell.system_id),
        };
        match self.board.runners.create(self.cell.plugin.clone(), create).await {
            Ok(instance) => {
                self.model.instance = Some(instance);
                // The instance has its task from the snapshot, but a newer one may have come meanwhile.
                self.task_version = self.cell.state.lock().task_version;
                self.publish_model(ActorStatus::Running, None);
                if self.model.incarnation > Incarnation(1) {
                    self.tell_model(Severity::Advisory, ActorStatus::Running, "runs again with its state");
                }
                true
            }
            Err(error) => {
                self.model_failed(&error.to_string());
                false
            }
        }
    }

    /// Hands a batch to the model and carries out its effects.
    pub(super) async fn call_model(&mut self, events: Vec<Event>) {
        let Some(instance) = &self.model.instance else { return };
        let urgent = events
            .iter()
            .any(|e| matches!(e, Event::Command { .. } | Event::Task(_)));
        match instance
            .call(EventBatch {
                now: self.board.now(),
                events,
            })
            .await
        {
            Ok(batch) => {
                self.cell.state.lock().task_version = self.task_version;
                let changed = batch
                    .effects
                    .iter()
                    .any(|e| matches!(e, skein_domain::exchange::Effect::State { .. }));
                self.carry_out(batch.effects);
                if urgent || changed {
                    // What a command or task brought about must survive a failure in the very next call.
                    self.model.snapshot_at = NodeTime(0);
                    self.keep_snapshot().await;
                }
            }
            Err(error) => self.model_failed(&error.to_string()),
        }
    }

    /// Takes a snapshot if it is time for one.
    pub(super) async fn keep_snapshot(&mut self) {
        let now = self.board.now();
        let Some(instance) = &self.model.instance else { return };
        if self.model.snapshot_at > now {
            return;
        }
        self.model.snapshot_at = now.plus_seconds(SNAPSHOT_EVERY_S);
        match instance.snapshot().await {
            Ok(snapshot) => *self.cell.snapshot.lock() = Some(snapshot),
            Err(error) => self.model_failed(&error.to_string()),
        }
    }

    /// Ends the failed instance and decides when the next starts. Meanwhile the link holds position by itself.
    fn model_failed(&mut self, error: &str) {
        let now = self.board.now();
        self.model.instance = None;
        self.model.incarnation = self.model.incarnation.next();
        match self.model.history.decide(&VEHICLE_LIMITS, now, fraction(now)) {
            Decision::RestartAfter(delay_s) => {
                self.model.start_at = Some(now.plus_seconds(delay_s));
                self.publish_model(ActorStatus::Restarting, Some(error));
                self.tell_model(
                    Severity::Warning,
                    ActorStatus::Restarting,
                    &format!("failed: {error}; restarting"),
                );
            }
            Decision::GiveUp => {
                self.model.start_at = None;
                self.publish_model(ActorStatus::GivenUp, Some(error));
                self.tell_model(
                    Severity::Critical,
                    ActorStatus::GivenUp,
                    &format!("failed too often: {error}"),
                );
                self.hand_to_autopilot(now);
            }
        }
    }

    /// The model is given up: the autopilot itself holds the vehicle, without setpoints.
    fn hand_to_autopilot(&mut self, now: NodeTime) {
        let link = self.cell.link.load_full();
        let flying = self.board.peers.load().entry(self.cell.id).is_some_and(|e| e.airborne);
        if flying && !self.pilot {
            link.0
                .request(now, ACTOR_REQUEST, AutopilotCommand::SetMode { mode: FlightMode::Hold });
        }
        let mut published = self.cell.state.lock();
        published.flight_state = FlightState::Faulted;
        published.detail = "its model failed too often; the autopilot holds".into();
        published.since = now;
    }

    fn publish_model(&self, status: ActorStatus, error: Option<&str>) {
        let mut published = self.cell.state.lock();
        let last_error = error.map_or_else(|| published.model.last_error.clone(), ToOwned::to_owned);
        published.model = ActorHealth {
            name: format!("model-{}", self.cell.id),
            status,
            incarnation: self.model_incarnation(),
            last_error,
            since: self.board.now(),
        };
    }

    fn tell_model(&self, severity: Severity, status: ActorStatus, what: &str) {
        let kind = EventKind::Supervision {
            actor: format!("model-{}", self.cell.id),
            status,
        };
        self.record(severity, kind, format!("{}: model {what}", self.cell.name));
    }
}

/// Jitter for the back-off: the microseconds of the failure's time are as good as random between vehicles.
fn fraction(now: NodeTime) -> f64 {
    (now.0 % 1_000) as f64 / 1_000.0
}
