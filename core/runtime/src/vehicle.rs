//! The vehicle actor: one per UAV. Once per control period it hands its UAV-model plugin one batch of events and carries out the
//! effects it gets: setpoints and requests go through the safety gate to the link, everything else to the shared state.
//!
//! Order: commands and ticks are handled one after the other, as they came. Bound: at most one tick waits in the mailbox; commands
//! are few and never dropped. Must never do: wait for another actor, or for the vehicle.

mod effects;
mod failsafe;
mod itinerary;
mod model;
mod parameters;
mod period;
mod route;
mod taking_back;

pub(crate) use parameters::words as parameter_words;

use crate::arming;
use crate::plugin_life::PluginLife;
use model::Model;
use parameters::Writes;
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_domain::exchange::{CommandProgress, Event, FaultDrill, Severity};
use skein_domain::{CommandId, FlightState, Incarnation, NodeTime, PositionNed, Refusal, VehicleCommand};
use skein_state::restart::VEHICLE_LIMITS;
use skein_state::{Itinerary, SharedState, Thinning, VehicleMessage, VehicleRecord};
use skein_view::{ActorHealth, ActorStatus, CommandReceipt, EventKind};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// The actor; all of its state is in [`VehicleState`].
pub struct VehicleActor;

/// What an incarnation is started with.
pub struct VehicleArguments {
    pub shared: Arc<SharedState>,
    pub record: Arc<VehicleRecord>,
    pub incarnation: Incarnation,
}

/// State of one incarnation.
pub struct VehicleState {
    shared: Arc<SharedState>,
    record: Arc<VehicleRecord>,
    model: Model,
    /// Events for the next batch that did not come from link or intent.
    waiting: Vec<Event>,
    /// Version of the task last handed to the plugin.
    task_version: u64,
    /// Writes of parameters whose outcome is open.
    writes: Writes,
    /// Commands under way, by name, for the event log.
    commands: BTreeMap<CommandId, &'static str>,
    /// A human or the autopilot's failsafe flies: setpoints are refused until an operator's command.
    pilot: bool,
    /// It is so because we stopped its stream on purpose.
    released: bool,
    /// Where the vehicle was when the gate began to refuse its setpoints: held until one passes again.
    refused_at: Option<PositionNed>,
    /// The refusal last told, and when.
    told_refusal: Option<(&'static str, NodeTime)>,
    /// Which of its setpoints are recorded.
    thinning: Thinning,
    /// Whom it was last told that the vehicle gives way to, whether it can, and when.
    told_change: Option<((String, bool), NodeTime)>,
}

impl Actor for VehicleActor {
    type Msg = VehicleMessage;
    type State = VehicleState;
    type Arguments = VehicleArguments;

    async fn pre_start(
        &self,
        myself: ActorRef<Self::Msg>,
        arguments: Self::Arguments,
    ) -> Result<Self::State, ActorProcessingErr> {
        let VehicleArguments {
            shared,
            record,
            incarnation,
        } = arguments;
        let now = shared.now();
        {
            let mut published = record.change_state();
            published.actor = ActorHealth {
                name: format!("vehicle-{}", record.id),
                status: ActorStatus::Running,
                incarnation,
                last_error: std::mem::take(&mut published.actor.last_error),
                since: now,
            };
        }
        record.actor.begin(myself);
        Ok(VehicleState {
            model: Model::new(PluginLife::new(shared.clone(), record.model.clone(), &VEHICLE_LIMITS)),
            shared,
            record,
            waiting: Vec::new(),
            task_version: 0,
            writes: Writes::default(),
            commands: BTreeMap::new(),
            pilot: false,
            released: false,
            refused_at: None,
            told_refusal: None,
            thinning: Thinning::default(),
            told_change: None,
        })
    }

    async fn handle(
        &self,
        _myself: ActorRef<Self::Msg>,
        message: Self::Msg,
        state: &mut Self::State,
    ) -> Result<(), ActorProcessingErr> {
        match message {
            VehicleMessage::Tick => {
                state.record.actor.take_tick();
                state.period().await;
            }
            VehicleMessage::Command {
                id,
                command,
                legs,
                not_before,
                reply,
            } => {
                let by_operator = reply.is_some();
                if by_operator && state.shared.resume.commanded(state.record.id) {
                    state.refused_at = None;
                }
                let refusal = match state.permitted(&command, by_operator) {
                    Ok(()) => state.command(id, command, legs, not_before).await.err(),
                    Err(refusal) => Some(state.refuse(id, &command, refusal)),
                };
                if by_operator && refusal.is_none() {
                    state.taken_up_by_operator();
                }
                // The asker may have given up waiting; the event log has the outcome all the same.
                let _ = reply.map(|reply| {
                    reply.send(CommandReceipt {
                        vehicle: state.record.id,
                        id,
                        refusal,
                    })
                });
            }
            VehicleMessage::PayloadResult { request, refusal } => {
                state.waiting.push(Event::PayloadResult { request, refusal });
            }
            VehicleMessage::UploadRoute(route) => state.upload_route(&route),
            VehicleMessage::WriteParameter(order) => state.write_parameter(order),
            VehicleMessage::Drill(drill) => {
                state.waiting.push(Event::FaultDrill(drill));
            }
            VehicleMessage::Kill => {
                if !state.model.life.kill() {
                    state.waiting.push(Event::FaultDrill(FaultDrill::Panic));
                }
            }
            VehicleMessage::Exchange(plugin, reply) => {
                let outcome = state.model.life.exchange(plugin).await.map_err(|e| e.to_string());
                state.model_renewed();
                // Whoever asked may have given up waiting; the event log has it.
                let _ = reply.send(outcome);
            }
            // Without its state if it was given up: what it thought then is not what the autopilot has done since.
            VehicleMessage::Reset => {
                let fresh = state.record.model.health().status == ActorStatus::GivenUp;
                state.model.life.reset(fresh);
                state.refuse_lost();
                state.task_version = 0;
            }
        }
        Ok(())
    }
}

impl VehicleState {
    /// Checks a command and hands it, or its first leg, to the plugin at once; `Ok` once the plugin has taken it up.
    async fn command(
        &mut self,
        id: CommandId,
        command: VehicleCommand,
        mut legs: VecDeque<VehicleCommand>,
        not_before: NodeTime,
    ) -> Result<(), Refusal> {
        let admitted = legs.iter().chain([&command]).try_for_each(|part| self.admit(part));
        if let Err(refusal) = admitted {
            return Err(self.refuse(id, &command, refusal));
        }
        if matches!(command, VehicleCommand::Arm | VehicleCommand::TakeOff { .. }) {
            self.record.set_stopped(false);
        }
        let (flown, flown_id) = match legs.pop_front() {
            Some(leg) => (leg, self.shared.next_command_id()),
            None => (command, id),
        };
        self.commands.insert(flown_id, flown.name());
        let was_pilot = std::mem::replace(&mut self.pilot, false);
        let peers = self.shared.peers();
        let mut events = self.gather(&peers);
        events.push(Event::Command {
            id: flown_id,
            command: flown,
            not_before,
        });
        let asked = self.model.life.incarnation();
        self.call_model(events).await;
        if let Some(refusal) = self.model.take_refusal(flown_id) {
            self.pilot = was_pilot;
            return Err(refusal);
        }
        if matches!(flown, VehicleCommand::Steer)
            && let Err(refusal) = self.begin_by_hand(flown_id, asked)
        {
            self.pilot = was_pilot;
            return Err(self.refuse(id, &command, refusal));
        }
        // Most of the time the model has said of the former leg that it is replaced; between two legs it had nothing to say.
        self.abandon_itinerary();
        self.record.commanded.begin(id, command);
        if flown_id != id {
            self.record_progress(id, command.name(), &CommandProgress::Executing);
            self.begin_itinerary(Itinerary {
                id,
                name: command.name(),
                returns: matches!(command, VehicleCommand::Return),
                legs,
                current: Some(flown_id),
            });
        }
        Ok(())
    }

    /// Who is flown by hand has left its formation, unless it leads it.
    fn begin_by_hand(&mut self, id: CommandId, asked: Incarnation) -> Result<(), Refusal> {
        let answered = self.model.life.is_running() && self.model.life.incarnation() == asked;
        if answered && !self.record.hand.lock().is_by(id) {
            // A command that it has no word for is nothing to an older library.
            self.commands.remove(&id);
            return Err(Refusal::not_supported(format!(
                "the model of vehicle {} is not flown by hand",
                self.record.id
            )));
        }
        if self.record.state().flight_state != FlightState::Leading {
            self.shared.vehicles.withdraw(&self.record);
        }
        Ok(())
    }

    /// What the failsafe policy and the preflight report say to a command.
    fn permitted(&self, command: &VehicleCommand, by_operator: bool) -> Result<(), Refusal> {
        if by_operator {
            self.failsafe_permits(command)?;
        }
        match command {
            VehicleCommand::Arm | VehicleCommand::TakeOff { .. } => arming::may_arm(&self.shared, &self.record),
            _ => Ok(()),
        }
    }

    /// Puts a refusal on record and gives it back.
    fn refuse(&self, id: CommandId, command: &VehicleCommand, refusal: Refusal) -> Refusal {
        let progress = CommandProgress::Refused {
            refusal: refusal.clone(),
        };
        self.record_progress(id, command.name(), &progress);
        refusal
    }

    /// What can be said of a command before the model sees it.
    fn admit(&self, command: &VehicleCommand) -> Result<(), Refusal> {
        let peers = self.shared.peers();
        let entry = peers.entry(self.record.id);
        if !entry.is_some_and(|e| e.link.connected) {
            return Err(Refusal::LinkLost {
                vehicle: self.record.id,
            });
        }
        self.shared
            .gate()
            .command(command, entry.and_then(|e| e.home.as_ref()))?;
        if !self.model.life.is_running() {
            return Err(Refusal::not_running(format!("model of vehicle {}", self.record.id)));
        }
        Ok(())
    }

    /// Writes a command's progress to the event log.
    fn record_progress(&self, id: CommandId, name: &str, progress: &CommandProgress) {
        self.record.commanded.progress(id, progress);
        let words = name.replace('_', " ");
        let (severity, text) = match progress {
            CommandProgress::Executing => (Severity::Info, format!("{}: {words} taken up", self.record.name)),
            CommandProgress::Done => (Severity::Info, format!("{}: {words} done", self.record.name)),
            CommandProgress::Refused {
                refusal: Refusal::Superseded,
            } => (
                Severity::Info,
                format!("{}: {words} replaced by a newer command", self.record.name),
            ),
            CommandProgress::Refused { refusal } => (
                Severity::Warning,
                format!("{}: {words} refused: {refusal}", self.record.name),
            ),
        };
        let kind = EventKind::Command {
            id,
            command: name.to_owned(),
            progress: progress.clone(),
        };
        self.record(severity, kind, text);
    }

    fn record(&self, severity: Severity, kind: EventKind, text: impl Into<String>) {
        self.shared
            .events
            .record(self.shared.now(), Some(self.record.id), severity, kind, text);
    }
}
