//! The failsafe monitor of one vehicle: its charge and its failsafe policy, looked at ten times a second and more, whether its model runs or
//! not. What the failsafe policy orders is done here: through the model where it runs, else by the autopilot, at last by leaving it to the autopilot.
//!
//! Must never do: decide what is dangerous (that is `skein-safety`'s), or act against a pilot.

use super::VehicleState;
use skein_coordination::ways;
use skein_domain::exchange::Severity;
use skein_domain::{
    AutopilotCommand, EnergyState, FailsafeEvent, FailsafeEventKind, FlightMode, FlightState, NodeTime, Reaction,
    Refusal, RequestId, Task, VehicleCommand,
};
use skein_safety::FailsafePolicy;
use skein_safety::failsafe::{FenceBreach, Health, TakenUpBy};
use skein_state::{FailsafeStep, Holding, Taken};
use skein_view::EventKind;
use skein_view::{PeerEntry, PeerSnapshot};

/// A vehicle at the boundary is not outside for the error of its position, in metres.
const FENCE_NOISE_M: f64 = 0.5;
/// Request id of what the monitor asks the autopilot for, beyond what models use.
const WATCH_REQUEST: RequestId = RequestId(u32::MAX - 2);

impl VehicleState {
    /// One look, if it is time.
    pub(super) async fn watch(&mut self, peers: &PeerSnapshot) {
        let now = self.shared.now();
        let Some(entry) = peers.entry(self.record.id) else {
            return;
        };
        let settings = self.shared.config.safety.failsafe.clone();
        let (events, state) = {
            let mut monitor = self.record.failsafe.lock();
            if !monitor.begin_look(now) {
                return;
            }
            let energy = monitor.assess(entry, &self.shared.config.safety, now);
            let mut health = self.health(entry, energy, now);
            let drifted_m = monitor.drifted_m(entry, self.holding(now));
            health.tracking_error_m = match (health.tracking_error_m, drifted_m) {
                (Some(a), Some(b)) => Some(a.max(b)),
                (a, b) => a.or(b),
            };
            let before = self.shared.tape.is_on().then(|| monitor.policy().clone());
            let judged = monitor.judge(&health, &settings, now);
            if let Some(before) = before.filter(|_| !judged.0.is_empty()) {
                self.record_step(now, before, health, &judged.0);
            }
            judged
        };
        let quiet = state.alarms.is_empty() && state.order.is_none();
        self.record.change_state().failsafe = Some(state).filter(|_| !quiet);
        for event in events {
            self.tell_failsafe(&event);
            if event.kind == FailsafeEventKind::Ordered {
                self.react(event.reaction, now).await;
            }
        }
    }

    fn record_step(&self, at: NodeTime, before: FailsafePolicy, health: Health, events: &[FailsafeEvent]) {
        self.shared.tape.take(|| {
            Taken::Failsafe(Box::new(FailsafeStep {
                at,
                vehicle: self.record.id,
                before,
                health,
                events: events.to_vec(),
            }))
        });
    }

    fn holding(&self, now: NodeTime) -> Holding {
        let published = self.record.state();
        Holding {
            holds: published.flight_state == FlightState::Holding,
            gives_way: published.avoiding.is_some(),
            for_s: now.seconds_since(published.since),
        }
    }

    fn health(&self, entry: &PeerEntry, energy: Option<EnergyState>, now: NodeTime) -> Health {
        let published = self.record.state();
        let wanted = published.setpoint.and_then(|s| s.position);
        let position = entry.kinematics.map(|k| k.position);
        let observed = Health::observed(&entry.telemetry, &entry.link, now);
        let gate = self.shared.gate();
        Health {
            airborne: entry.airborne,
            // The autopilot's own failsafe flies home or lands by itself: nothing is ordered against it either.
            pilot_in_control: observed.pilot_in_control || (self.pilot && !self.released),
            state: published.flight_state,
            lands: observed.lands || self.lands(published.flight_state),
            tracking_error_m: wanted.zip(position).map(|(wanted, have)| wanted.distance_m(&have)),
            breach: position
                .and_then(|at| gate.fences().breach(&at).as_ref().map(FenceBreach::from))
                .filter(|breach| breach.outside_m > FENCE_NOISE_M),
            coordinator_heard: self.needs_coordinator().then(|| self.shared.coordinator_seen()),
            operator_heard: self.shared.operators.heard(),
            energy,
            ..observed
        }
    }

    /// Whether it was commanded to land where it is, also while its autopilot does not do so yet. A flight to a landing spot is another command.
    fn lands(&self, state: FlightState) -> bool {
        state == FlightState::Landing && self.record.commanded.command() == Some(VehicleCommand::Land)
    }

    /// Whether it does something that a coordinator has to look after. Members that keep their places by their neighbours need none.
    fn needs_coordinator(&self) -> bool {
        let intent = self.shared.coordination.intent();
        let by_neighbours = intent.tasks.values().any(|t| matches!(t.task, Task::Keep(_)));
        let task = intent.tasks.get(&self.record.id);
        !by_neighbours && task.is_some_and(|t| matches!(t.task, Task::Lead { .. } | Task::Follow { .. }))
    }

    fn tell_failsafe(&self, event: &FailsafeEvent) {
        let severity = match (event.kind, event.reaction) {
            (FailsafeEventKind::Cleared | FailsafeEventKind::Ended | FailsafeEventKind::TakenUp, _)
            | (FailsafeEventKind::Effective, _) => Severity::Info,
            (FailsafeEventKind::Ordered | FailsafeEventKind::Ineffective, _) => Severity::Critical,
            (_, Reaction::Warn) => Severity::Advisory,
            _ => Severity::Warning,
        };
        let text = format!("{}: {}", self.record.name, event.reason);
        self.record(severity, EventKind::Failsafe { event: event.clone() }, text);
    }

    /// Carries out a reaction: it leaves the formation, and its model is commanded; without one its autopilot is.
    async fn react(&mut self, reaction: Reaction, now: NodeTime) {
        let (command, by_autopilot) = match reaction {
            Reaction::Warn => return,
            Reaction::Hold => (
                VehicleCommand::Hold,
                AutopilotCommand::SetMode { mode: FlightMode::Hold },
            ),
            Reaction::Return => (VehicleCommand::Return, AutopilotCommand::ReturnToLaunch),
            Reaction::Land => (VehicleCommand::Land, AutopilotCommand::Land),
            Reaction::Release => return self.release(now),
        };
        let withdrew = self.shared.vehicles.withdraw(&self.record);
        self.record.failsafe.lock().reacted(withdrew);
        let id = self.shared.next_command_id();
        let legs = ways::legs(
            self.shared.gate().fences(),
            &self.shared.peers(),
            self.record.id,
            &command,
        )
        .unwrap_or_default();
        let taken_up = self.model.life.is_running() && self.command(id, command, legs, now).await.is_ok();
        if !taken_up {
            self.record.link().request(now, WATCH_REQUEST, by_autopilot);
        }
    }

    /// Stops the stream on purpose, so that the autopilot's own failsafe acts. It is out of our control until an operator commands it.
    fn release(&mut self, now: NodeTime) {
        self.shared.vehicles.withdraw(&self.record);
        self.pilot = true;
        self.released = true;
        self.record.link().stop_stream(now);
        let text = format!("{}: left to its autopilot's own failsafe", self.record.name);
        self.record(Severity::Critical, EventKind::Notice, text);
    }

    /// An operator's command that was accepted takes the vehicle up again.
    pub(super) fn taken_up_by_operator(&mut self) {
        self.released = false;
        let told = self.record.failsafe.lock().take_up(TakenUpBy::Operator);
        if let Ok(Some(event)) = told {
            self.tell_failsafe(&event);
        }
    }

    /// Whether a task of the coordinator may be taken up: not against a reaction that is in force.
    pub(super) fn may_take_task(&mut self) -> bool {
        let told = self.record.failsafe.lock().take_up(TakenUpBy::Coordinator);
        match told {
            Ok(Some(event)) => {
                self.tell_failsafe(&event);
                true
            }
            Ok(None) => true,
            Err(_) => false,
        }
    }

    /// What the failsafe policy says to a command of an operator.
    pub(super) fn failsafe_permits(&self, command: &VehicleCommand) -> Result<(), Refusal> {
        self.record.failsafe.lock().permits(command)
    }
}
