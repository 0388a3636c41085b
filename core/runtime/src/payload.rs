//! The payload actor: one per payload of a vehicle. It hands its plugin one batch of events when its tick is due and at once for a
//! command, and carries out the effects: messages to the device pass the gate, a report goes to the shared state.
//!
//! Order: commands and ticks are handled one after the other, as they came. Bound: at most one tick waits in the mailbox; messages of
//! the device wait in queues that drop the oldest. Must never do: wait for another actor or for the device, or send anything that
//! moves a vehicle.

mod effects;
mod period;
mod tap;
pub mod transport;

use crate::plugin_life::{Called, PluginLife};
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_config::Escalation;
use skein_domain::exchange::{CommandProgress, Event, FaultDrill, Severity};
use skein_domain::link::VehicleLink;
use skein_domain::{CommandId, Incarnation, NodeTime, Refusal, VehicleCommand};
use skein_plugin_host::Frame;
use skein_state::restart::PAYLOAD_LIMITS;
use skein_state::{Asker, PayloadMessage, PayloadRecord, SharedState, VehicleMessage, VehicleRecord};
use skein_view::{ActorHealth, ActorStatus, CommandReceipt, EventKind};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use tap::Tap;
use transport::Transport;

/// The actor.
pub struct Payload;

/// What an incarnation is started with.
pub struct PayloadArguments {
    pub shared: Arc<SharedState>,
    pub vehicle: Arc<VehicleRecord>,
    pub record: Arc<PayloadRecord>,
    pub incarnation: Incarnation,
}

/// State of one incarnation.
pub struct PayloadState {
    shared: Arc<SharedState>,
    vehicle: Arc<VehicleRecord>,
    record: Arc<PayloadRecord>,
    life: PluginLife,
    /// The tap, and the link it listens on.
    tap: Option<(Arc<Tap>, Arc<dyn VehicleLink>)>,
    transport: Option<Transport>,
    /// Events for the next batch.
    waiting: Vec<Event>,
    /// Revisions of the siblings' reports that the plugin has.
    seen: BTreeMap<String, u64>,
    /// The frame of each camera that the plugin was shown last, if it is a detector.
    seen_frames: BTreeMap<String, u64>,
    /// Operators' commands under way, by name. What its own model asks of it many times a second would drown the event log.
    commands: BTreeMap<CommandId, String>,
    /// A refusal told within the present call, for the command's receipt.
    refusal: Option<(CommandId, Refusal)>,
    /// The refusal of the gate last told, and when.
    told_refusal: Option<(&'static str, NodeTime)>,
    tracks: Arc<Vec<skein_domain::payload::Track>>,
}

impl Actor for Payload {
    type Msg = PayloadMessage;
    type State = PayloadState;
    type Arguments = PayloadArguments;

    async fn pre_start(
        &self,
        myself: ActorRef<PayloadMessage>,
        arguments: PayloadArguments,
    ) -> Result<PayloadState, ActorProcessingErr> {
        let PayloadArguments {
            shared,
            vehicle,
            record,
            incarnation,
        } = arguments;
        {
            let mut published = record.change_state();
            published.actor = ActorHealth {
                name: record.life.health().name.clone(),
                status: ActorStatus::Running,
                incarnation,
                last_error: std::mem::take(&mut published.actor.last_error),
                since: shared.now(),
            };
        }
        record.actor.begin(myself);
        Ok(PayloadState {
            life: PluginLife::new(shared.clone(), record.life.clone(), &PAYLOAD_LIMITS),
            tap: None,
            transport: record.transport.clone().map(Transport::open),
            waiting: Vec::new(),
            seen: BTreeMap::new(),
            seen_frames: BTreeMap::new(),
            commands: BTreeMap::new(),
            refusal: None,
            told_refusal: None,
            tracks: Arc::default(),
            shared,
            vehicle,
            record,
        })
    }

    async fn handle(
        &self,
        _: ActorRef<PayloadMessage>,
        message: PayloadMessage,
        state: &mut PayloadState,
    ) -> Result<(), ActorProcessingErr> {
        match message {
            PayloadMessage::Tick => {
                state.record.actor.take_tick();
                state.period(true).await;
            }
            PayloadMessage::Command {
                id,
                command_json,
                asker,
            } => state.command(id, command_json, asker).await,
            PayloadMessage::Drill(drill) => state.waiting.push(Event::FaultDrill(drill)),
            PayloadMessage::Kill => {
                if !state.life.kill() {
                    state.waiting.push(Event::FaultDrill(FaultDrill::Panic));
                }
            }
            PayloadMessage::Exchange(plugin, reply) => {
                let outcome = state.life.exchange(plugin).await.map_err(|e| e.to_string());
                state.seen.clear();
                // Whoever asked may have given up waiting; the event log has it.
                let _ = reply.send(outcome);
            }
            // Without its state if it was given up: it failed with that often enough.
            PayloadMessage::Reset => {
                let fresh = state.record.life.health().status == ActorStatus::GivenUp;
                state.life.reset(fresh);
                state.refuse_lost();
            }
        }
        Ok(())
    }
}

impl PayloadState {
    /// Checks a command against the plugin's schema and hands it over at once.
    async fn command(&mut self, id: CommandId, command_json: String, asker: Asker) {
        if matches!(asker, Asker::Operator(_)) {
            self.commands.insert(id, command_name(&command_json));
        }
        let refusal = self.try_command(id, command_json).await.err();
        if refusal.is_some() {
            self.commands.remove(&id);
        }
        match asker {
            Asker::Operator(reply) => {
                let receipt = CommandReceipt {
                    vehicle: self.vehicle.id,
                    id,
                    refusal,
                };
                // The asker may have given up waiting.
                let _ = reply.send(receipt);
            }
            Asker::Model(request) => {
                if let Some(actor) = self.vehicle.actor.get() {
                    // A vehicle's actor that has just ended asks again.
                    let _ = actor.cast(VehicleMessage::PayloadResult { request, refusal });
                }
            }
        }
    }

    async fn try_command(&mut self, id: CommandId, command_json: String) -> Result<(), Refusal> {
        let plugin = self.record.life.plugin();
        plugin
            .manifest()
            .check_command(&command_json)
            .map_err(|e| Refusal::invalid(e.to_string()))?;
        if !self.ensure().await {
            return Err(Refusal::not_running(format!(
                "payload {} of vehicle {}",
                self.record.name, self.vehicle.id
            )));
        }
        self.waiting.push(Event::PayloadCommand { id, command_json });
        self.period(false).await;
        match self.refusal.take_if(|(refused, _)| *refused == id) {
            Some((_, refusal)) => Err(refusal),
            None => Ok(()),
        }
    }

    /// Starts the instance if it can be; tells whether it runs.
    async fn ensure(&mut self) -> bool {
        let was_running = self.life.is_running();
        let (running, given_up) = self.life.ensure().await;
        if running && !was_running {
            // A new instance knows of nothing yet.
            self.record.video.begin(self.shared.now());
            self.seen.clear();
            self.tracks = Arc::default();
        }
        if let Some(why) = given_up {
            self.escalate(&why);
        }
        running
    }

    /// Hands a batch over and carries out what comes back.
    async fn call(&mut self, events: Vec<Event>, frames: &[Arc<Frame>]) {
        let before = self.life.incarnation();
        match self.life.call(events, frames).await {
            Called::Answered(effects, frames) => self.carry_out(effects, frames),
            Called::Failed => {}
            Called::GivenUp(why) => self.escalate(&why),
        }
        self.refuse_lost();
        if self.life.incarnation() != before {
            self.seen.clear();
            self.tracks = Arc::default();
            if !self.life.is_running() {
                self.withdraw_report();
            }
        }
    }

    /// Says of commands that two incarnations failed with, or that none will come for, that they are not carried out.
    fn refuse_lost(&mut self) {
        for id in self.life.take_lost() {
            let refusal = Refusal::not_running(format!("payload {} of vehicle {}", self.record.name, self.vehicle.id));
            self.progress(id, CommandProgress::Refused { refusal });
        }
    }

    /// What was reported is not true any more.
    fn withdraw_report(&self) {
        let mut published = self.record.change_state();
        if published.report.take().is_some() {
            published.revision += 1;
        }
    }

    /// The plugin failed too often.
    fn escalate(&self, why: &str) {
        self.withdraw_report();
        escalate(&self.shared, &self.vehicle, &self.record, why);
    }
}

/// A payload failed too often, plugin or actor: its vehicle is degraded, and does what the configuration says.
pub fn escalate(shared: &SharedState, vehicle: &VehicleRecord, record: &PayloadRecord, why: &str) {
    let name = &record.name;
    let (severity, what, command) = match record.rule.on_failure {
        Escalation::Degrade => (Severity::Warning, "flies on without it", None),
        Escalation::Hold => (Severity::Critical, "holds", Some(VehicleCommand::Hold)),
        Escalation::Return => (Severity::Critical, "returns", Some(VehicleCommand::Return)),
    };
    let kind = EventKind::Payload { payload: name.clone() };
    let text = format!(
        "{}: {name} failed too often ({why}); the vehicle is degraded and {what}",
        vehicle.name
    );
    let now = shared.now();
    shared.events.record(now, Some(vehicle.id), severity, kind, text);
    let flying = shared.peers().entry(vehicle.id).is_some_and(|e| e.airborne);
    let Some(command) = command.filter(|_| flying) else {
        return;
    };
    shared.vehicles.withdraw(vehicle);
    if let Some(actor) = vehicle.actor.get() {
        let message = VehicleMessage::Command {
            id: shared.next_command_id(),
            command,
            legs: VecDeque::new(),
            not_before: now,
            reply: None,
        };
        // A vehicle's actor that has just ended comes up with its last task; the degradation stays visible.
        let _ = actor.cast(message);
    }
}

/// The command's own word for itself, for the event log.
fn command_name(command_json: &str) -> String {
    serde_json::from_str::<serde_json::Value>(command_json)
        .ok()
        .and_then(|value| value.get("command").and_then(|c| c.as_str()).map(ToOwned::to_owned))
        .unwrap_or_else(|| "command".into())
}
