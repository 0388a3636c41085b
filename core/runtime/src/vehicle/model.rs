//! What a vehicle's actor adds to the life of its UAV-model instance: which events a new one must be told, what it said of a command,
//! and handing the vehicle to its autopilot when the model is given up.

use super::VehicleState;
use crate::plugin_life::{Called, PluginLife};
use skein_domain::exchange::{CommandProgress, Event};
use skein_domain::{AutopilotCommand, CommandId, FlightMode, FlightState, NodeTime, Refusal, RequestId};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The request id of requests that the actor itself makes, beyond what models use.
const ACTOR_REQUEST: RequestId = RequestId(u32::MAX);

/// The model instance and what it knows.
pub(super) struct Model {
    pub(super) life: PluginLife,
    /// A refusal reported within the present call, for the command's receipt.
    refusal: Option<(CommandId, Refusal)>,
    /// Revisions of the payloads' reports that it has.
    pub(super) seen: BTreeMap<String, u64>,
    /// What it knows to be tracked.
    pub(super) tracks: Arc<Vec<skein_domain::payload::Track>>,
}

impl Model {
    pub(super) fn new(life: PluginLife) -> Self {
        Self {
            life,
            refusal: None,
            seen: BTreeMap::new(),
            tracks: Arc::default(),
        }
    }

    pub(super) fn note_refusal(&mut self, id: CommandId, refusal: Refusal) {
        self.refusal = Some((id, refusal));
    }

    pub(super) fn take_refusal(&mut self, id: CommandId) -> Option<Refusal> {
        self.refusal
            .take_if(|(noted, _)| *noted == id)
            .map(|(_, refusal)| refusal)
    }

    /// A new instance has the state of the one before it, but not what others told that one.
    fn forget_what_was_told(&mut self) {
        self.seen.clear();
        self.tracks = Arc::default();
    }
}

impl VehicleState {
    /// Starts the model if it is not running and its back-off is over; tells whether it runs.
    pub(super) async fn ensure_model(&mut self) -> bool {
        let was_running = self.model.life.is_running();
        let (running, given_up) = self.model.life.ensure().await;
        if running && !was_running {
            self.model_renewed();
        }
        if given_up.is_some() {
            self.hand_to_autopilot(self.shared.now());
        }
        running
    }

    /// Hands a batch to the model and carries out its effects.
    pub(super) async fn call_model(&mut self, events: Vec<Event>) {
        let before = self.model.life.incarnation();
        match self.model.life.call(events, &[]).await {
            Called::Answered(effects, _) => {
                self.record.change_state().task_version = self.task_version;
                self.carry_out(effects);
            }
            Called::Failed => {}
            Called::GivenUp(_) => self.hand_to_autopilot(self.shared.now()),
        }
        self.refuse_lost();
        if self.model.life.incarnation() != before {
            self.model_renewed();
        }
    }

    /// Says of commands that two incarnations failed with, or that none will come for, that they are not carried out.
    pub(super) fn refuse_lost(&mut self) {
        for id in self.model.life.take_lost() {
            let refusal = Refusal::not_running(format!("model of vehicle {}", self.record.id));
            self.progress(id, CommandProgress::Refused { refusal });
        }
    }

    /// The instance is another now. It has its task from the snapshot, but a newer one may have come meanwhile.
    pub(super) fn model_renewed(&mut self) {
        self.task_version = self.record.state().task_version;
        self.model.forget_what_was_told();
    }

    /// The model is given up: the autopilot itself holds the vehicle, without setpoints.
    fn hand_to_autopilot(&mut self, now: NodeTime) {
        let link = self.record.link();
        let flying = self.shared.peers().entry(self.record.id).is_some_and(|e| e.airborne);
        if flying && !self.pilot {
            link.request(now, ACTOR_REQUEST, AutopilotCommand::SetMode { mode: FlightMode::Hold });
        }
        self.record.hand.lock().end_any();
        let mut published = self.record.change_state();
        published.flight_state = FlightState::Faulted;
        published.detail = "its model failed too often; the autopilot holds".into();
        published.since = now;
    }
}
