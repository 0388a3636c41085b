//! The watch over one vehicle: its charge and its ladder of reactions, looked at ten times a second and more, whether its model runs or
//! not. What the ladder orders is done here: through the model where it runs, else by the autopilot, at last by leaving it to the autopilot.
//!
//! Must never do: decide what is dangerous (that is `skein-safety`'s), or act against a pilot.

use super::VehicleState;
use crate::board::{PeerEntry, PeerSnapshot};
use crate::snapshot::EventKind;
use crate::ways;
use skein_domain::exchange::Severity;
use skein_domain::{
    AutopilotCommand, EnergyState, FlightMode, FlightState, LadderEvent, LadderEventKind, LadderSettings, NodeTime,
    Order, PositionNed, Reaction, Refusal, RequestId, Task, VehicleCommand,
};
use skein_safety::Ladder;
use skein_safety::energy::{EnergyEstimator, EnergySample, WayHome};
use skein_safety::ladder::{FenceBreach, Health, TakenUpBy};

/// Time between two looks in seconds.
const LOOK_S: f64 = 0.05;
/// A vehicle slower than this stands, in metres per second.
const STANDS_M_S: f64 = 0.5;
/// Whoever holds stands by then, in seconds.
const STOPPED_WITHIN_S: f64 = 5.0;
/// A vehicle at the boundary is not outside for the error of its position, in metres.
const FENCE_NOISE_M: f64 = 0.5;
/// A battery report older than this says nothing of now, in seconds.
const BATTERY_TOLD_S: f64 = 5.0;
/// Request id of what the watch asks the autopilot for, beyond what models use.
const WATCH_REQUEST: RequestId = RequestId(u32::MAX - 2);

/// What the watch remembers of a vehicle, beyond its actor's life.
#[derive(Debug, Default)]
pub struct Watch {
    ladder: Ladder,
    estimator: EnergyEstimator,
    next: NodeTime,
    /// Where it began to hold, if it holds; a reference that is carried along with a drifting vehicle must not hide the drift.
    held: Option<PositionNed>,
    /// It was the watch that took the vehicle out of its formation.
    withdrew: bool,
    /// Charge against the way home.
    pub energy: Option<EnergyState>,
}

/// Only a hold is left, and what it was for is over.
fn is_over(order: &Order) -> bool {
    order.recovered && order.reaction == Reaction::Hold
}

impl Watch {
    /// Whether a reaction is in force that the coordinator cannot end.
    pub fn is_under_order(&self) -> bool {
        self.ladder.order().is_some_and(|order| !is_over(order))
    }

    /// Alarms that stand now and would do more than warn in flight.
    pub fn would_act(&self, settings: &LadderSettings) -> Vec<String> {
        self.ladder.would_act(settings)
    }

    /// The autopilot restarted.
    pub fn autopilot_restarted(&mut self) {
        self.ladder.autopilot_restarted();
    }

    /// Whether it may come back into the formation that the watch took it out of.
    pub fn may_rejoin(&self) -> bool {
        self.withdrew && self.ladder.order().is_some_and(is_over)
    }
}

impl VehicleState {
    /// One look, if it is time.
    pub(super) async fn watch(&mut self, peers: &PeerSnapshot) {
        let now = self.board.now();
        let Some(entry) = peers.entry(self.cell.id) else { return };
        let settings = self.board.config.safety.ladder.clone();
        let (events, state) = {
            let mut watch = self.cell.watch.lock();
            if now < watch.next {
                return;
            }
            watch.next = now.plus_seconds(LOOK_S);
            let energy = self.assess(&mut watch.estimator, entry, now);
            watch.energy = energy;
            let mut health = self.health(entry, energy, now);
            let drifted_m = self.drifted_m(&mut watch.held, entry);
            health.tracking_error_m = match (health.tracking_error_m, drifted_m) {
                (Some(a), Some(b)) => Some(a.max(b)),
                (a, b) => a.or(b),
            };
            let events = watch.ladder.step(now, &health, &settings);
            (events, watch.ladder.state(&settings))
        };
        let quiet = state.alarms.is_empty() && state.order.is_none();
        self.cell.state.lock().ladder = Some(state).filter(|_| !quiet);
        for event in events {
            self.tell_ladder(&event);
            if event.kind == LadderEventKind::Ordered {
                self.react(event.reaction, now).await;
            }
        }
    }

    fn assess(&self, estimator: &mut EnergyEstimator, entry: &PeerEntry, now: NodeTime) -> Option<EnergyState> {
        let settings = &self.board.config.safety.energy;
        let told_s = now.seconds_since(entry.telemetry.heard.battery);
        let sample = EnergySample {
            // An old report is none: the estimator carries the charge on by itself.
            battery: Some(entry.telemetry.battery)
                .filter(|_| told_s <= BATTERY_TOLD_S)
                .unwrap_or_default(),
            simulated: entry.telemetry.simulated,
            airborne: entry.airborne,
            velocity: entry.telemetry.velocity,
            wind: entry.telemetry.wind,
        };
        estimator.observe(now, &sample, settings);
        let (position, home) = (entry.kinematics?.position, entry.home?);
        let away = position.vector() - home.vector();
        let distance_m = away.xy().norm();
        let receding_m_s = match entry.telemetry.velocity {
            Some(v) if distance_m > 1.0 => (v.vector().xy().dot(&away.xy()) / distance_m).max(0.0),
            _ => 0.0,
        };
        let height_m = self.board.config.safety.returning.height_m;
        let way = WayHome::between(&position, &home, height_m, receding_m_s);
        estimator.assess(now, &way, settings)
    }

    /// How far a vehicle that holds is from where it began to. Giving way to somebody is no drift.
    fn drifted_m(&self, held: &mut Option<PositionNed>, entry: &PeerEntry) -> Option<f64> {
        let kinematics = entry.kinematics?;
        let (holds, gives_way, for_s) = {
            let published = self.cell.state.lock();
            (
                published.flight_state == FlightState::Holding,
                published.avoiding.is_some(),
                self.board.now().seconds_since(published.since),
            )
        };
        if !holds || gives_way || !entry.airborne {
            *held = None;
            return None;
        }
        // Who never comes to stand is drifting from the start.
        if held.is_none() && (kinematics.velocity.norm() < STANDS_M_S || for_s > STOPPED_WITHIN_S) {
            *held = Some(kinematics.position);
        }
        held.map(|place| place.distance_m(&kinematics.position))
    }

    fn health(&self, entry: &PeerEntry, energy: Option<EnergyState>, now: NodeTime) -> Health {
        let published = self.cell.state.lock();
        let wanted = published.setpoint.and_then(|s| s.position);
        let position = entry.kinematics.map(|k| k.position);
        let observed = Health::observed(&entry.telemetry, &entry.link, now);
        let gate = self.board.gate();
        Health {
            airborne: entry.airborne,
            // The autopilot's own failsafe flies home or lands by itself: nothing is ordered against it either.
            pilot_in_control: observed.pilot_in_control || (self.pilot && !self.released),
            state: published.flight_state,
            tracking_error_m: wanted.zip(position).map(|(wanted, have)| wanted.distance_m(&have)),
            breach: position
                .and_then(|at| gate.fences().breach(&at).as_ref().map(FenceBreach::from))
                .filter(|breach| breach.outside_m > FENCE_NOISE_M),
            coordinator_heard: self.needs_coordinator().then(|| self.board.coordinator_seen()),
            operator_heard: self.board.operator_heard(),
            energy,
            ..observed
        }
    }

    /// Whether it does something that a coordinator has to look after. Members that keep their places by their neighbours need none.
    fn needs_coordinator(&self) -> bool {
        let intent = self.board.intent.load();
        let by_neighbours = intent.tasks.values().any(|t| matches!(t.task, Task::Keep(_)));
        let task = intent.tasks.get(&self.cell.id);
        !by_neighbours && task.is_some_and(|t| matches!(t.task, Task::Lead { .. } | Task::Follow { .. }))
    }

    fn tell_ladder(&self, event: &LadderEvent) {
        let severity = match (event.kind, event.reaction) {
            (LadderEventKind::Cleared | LadderEventKind::Ended | LadderEventKind::TakenUp, _)
            | (LadderEventKind::Effective, _) => Severity::Info,
            (LadderEventKind::Ordered | LadderEventKind::Ineffective, _) => Severity::Critical,
            (_, Reaction::Warn) => Severity::Advisory,
            _ => Severity::Warning,
        };
        let text = format!("{}: {}", self.cell.name, event.reason);
        self.record(severity, EventKind::Ladder { event: event.clone() }, text);
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
        let withdrew = self.board.withdraw(&self.cell);
        self.cell.watch.lock().withdrew = withdrew;
        let id = self.board.next_command_id();
        let legs = ways::legs(&self.board, self.cell.id, &command).unwrap_or_default();
        let taken_up = self.model.life.is_running() && self.command(id, command, legs, now).await.is_ok();
        if !taken_up {
            self.cell.link.load().0.request(now, WATCH_REQUEST, by_autopilot);
        }
    }

    /// Stops the stream on purpose, so that the autopilot's own failsafe acts. It is out of our hands until an operator commands it.
    fn release(&mut self, now: NodeTime) {
        self.board.withdraw(&self.cell);
        self.pilot = true;
        self.released = true;
        self.cell.link.load().0.stop_stream(now);
        let text = format!("{}: left to its autopilot's own failsafe", self.cell.name);
        self.record(Severity::Critical, EventKind::Notice, text);
    }

    /// An operator's command that was accepted takes the vehicle up again.
    pub(super) fn taken_up_by_operator(&mut self) {
        self.released = false;
        let told = {
            let mut watch = self.cell.watch.lock();
            watch.withdrew = false;
            watch.ladder.take_up(TakenUpBy::Operator)
        };
        if let Ok(Some(event)) = told {
            self.tell_ladder(&event);
        }
    }

    /// Whether a task of the coordinator may be taken up: not against a reaction that is in force.
    pub(super) fn may_take_task(&mut self) -> bool {
        let told = self.cell.watch.lock().ladder.take_up(TakenUpBy::Coordinator);
        match told {
            Ok(Some(event)) => {
                self.tell_ladder(&event);
                true
            }
            Ok(None) => true,
            Err(_) => false,
        }
    }

    /// What the ladder says to a command of an operator.
    pub(super) fn ladder_permits(&self, command: &VehicleCommand) -> Result<(), Refusal> {
        self.cell.watch.lock().ladder.permits(command)
    }
}
