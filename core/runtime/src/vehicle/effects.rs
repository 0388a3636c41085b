//! Carries out what a UAV model wants. The only place from which setpoints and requests reach a link, and each passes the gate.

use super::VehicleState;
use crate::arming::{not_held, own_items};
use skein_coordination::steering;
use skein_domain::exchange::{CommandProgress, Effect, Event, Severity};
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{
    AutopilotCommand, FlightLimits, FlightState, NodeTime, PositionNed, Refusal, RequestId, Setpoint, VehicleCommand,
};
use skein_safety::avoidance::{Change, NeighbourId};
use skein_state::emergency;
use skein_state::{Asker, JudgedSetpoint, PayloadMessage, Taken};
use skein_view::{Avoidance, EventKind};
use skein_view::{PeerEntry, PeerSnapshot};

/// A refusal of the same kind is told again after so long, in seconds: at 50 setpoints a second the log would hold nothing else.
const REFUSAL_REPEAT_S: f64 = 2.0;

/// A change of the wanted velocity below this is not worth telling, in metres per second.
const WORTH_TELLING_M_S: f64 = 0.3;
/// Giving way to the same one is told again after so long, in seconds.
const CHANGE_REPEAT_S: f64 = 10.0;

/// Whom a vehicle gives way to, in words.
fn who(id: NeighbourId) -> String {
    match id {
        NeighbourId::Vehicle(vehicle) => format!("vehicle {vehicle}"),
        NeighbourId::Foreign(_) => "something that is not ours".to_owned(),
    }
}

impl VehicleState {
    /// Carries out the effects in order.
    pub(super) fn carry_out(&mut self, effects: Vec<Effect>) {
        for effect in effects {
            match effect {
                Effect::Setpoint(setpoint) => self.setpoint(&setpoint),
                Effect::StopStream => {
                    self.refused_at = None;
                    self.record.link().stop_stream(self.shared.now());
                    self.record.change_state().setpoint = None;
                }
                Effect::Autopilot { request, command } => self.autopilot(request, command),
                Effect::CommandProgress { id, progress } => self.progress(id, progress),
                Effect::State { state, detail } => self.state_changed(state, &detail),
                Effect::Anchor(anchor) => self.record.change_state().anchor = Some(anchor),
                Effect::Notice { severity, text } => {
                    self.record(severity, EventKind::Notice, format!("{}: {text}", self.record.name));
                }
                Effect::TrackingError { distance_m } => {
                    self.record.change_state().tracking_error_m = Some(distance_m);
                }
                Effect::RouteFinished => {
                    let version = self.task_version;
                    self.record.change_state().route_finished = Some(version);
                    self.record(
                        Severity::Info,
                        EventKind::Formation,
                        format!("{}: end of the route", self.record.name),
                    );
                }
                Effect::Report { state_json } => {
                    // The host has held it against the plugin's schema, so that it parses.
                    self.record.change_state().model_state = serde_json::from_str(&state_json).ok();
                }
                Effect::Occurrence { event_json } => self.occurrence(&event_json),
                Effect::PayloadCommand {
                    request,
                    payload,
                    command_json,
                } => self.payload_command(request, &payload, command_json),
                Effect::Capability(capability) => self.record.change_state().capability = Some(capability),
                Effect::Preflight(items) => {
                    self.record.change_state().preflight = own_items(&self.record.model.plugin().manifest().name, items)
                }
                Effect::Limits(limits) => {
                    self.record.change_state().limits = Some(limits).filter(FlightLimits::is_usable)
                }
                // No manifest of a UAV model that names one of these is taken.
                Effect::Mavlink(_) | Effect::Transmit { .. } | Effect::Frame(_) => {}
            }
        }
    }

    fn state_changed(&self, state: FlightState, detail: &str) {
        if !matches!(state, FlightState::GoingTo | FlightState::Leading) {
            self.record.hand.lock().end_any();
        }
        let state = self.shown_state(state);
        {
            let mut published = self.record.change_state();
            published.flight_state = state;
            detail.clone_into(&mut published.detail);
            published.since = self.shared.now();
            if state != FlightState::Leading {
                // Who leads again starts from its own yaw, not from where it once turned a formation to.
                published.anchor = None;
            }
        }
        let text = match detail {
            "" => format!("{}: {state}", self.record.name),
            detail => format!("{}: {state} ({detail})", self.record.name),
        };
        self.record(Severity::Info, EventKind::FlightState { state }, text);
    }

    pub(super) fn progress(&mut self, id: skein_domain::CommandId, progress: CommandProgress) {
        if self.leg_progress(id, &progress) {
            return;
        }
        let name = match progress {
            CommandProgress::Executing => self.commands.get(&id).copied(),
            CommandProgress::Done | CommandProgress::Refused { .. } => self.commands.remove(&id),
        };
        match progress {
            CommandProgress::Executing if name == Some(VehicleCommand::Steer.name()) => {
                self.record.hand.lock().begin(id)
            }
            CommandProgress::Executing => {}
            CommandProgress::Done | CommandProgress::Refused { .. } => self.record.hand.lock().end(id),
        }
        self.record_progress(id, name.unwrap_or("command"), &progress);
        if let CommandProgress::Refused { refusal } = progress {
            self.model.note_refusal(id, refusal);
        }
    }

    fn occurrence(&self, event_json: &str) {
        let Ok(event) = serde_json::from_str::<serde_json::Value>(event_json) else {
            return;
        };
        let text = format!("{}: {event}", self.record.name);
        self.record(Severity::Info, EventKind::Occurrence { payload: None, event }, text);
    }

    /// Passed on to the payload's own actor; its answer comes as a message.
    fn payload_command(&mut self, request: RequestId, payload: &str, command_json: String) {
        let asked = match self.record.payload(payload) {
            None => Err(Refusal::UnknownPayload {
                vehicle: self.record.id,
                payload: payload.to_owned(),
            }),
            Some(record) => {
                let message = PayloadMessage::Command {
                    id: self.shared.next_command_id(),
                    command_json,
                    asker: Asker::Model(request),
                };
                let sent = record.actor.get().map(|actor| actor.cast(message).is_ok());
                sent.filter(|sent| *sent)
                    .map(|_| ())
                    .ok_or_else(|| Refusal::not_running(format!("payload {payload} of vehicle {}", self.record.id)))
            }
        };
        if let Err(refusal) = asked {
            self.waiting.push(Event::PayloadResult {
                request,
                refusal: Some(refusal),
            });
        }
    }

    fn autopilot(&mut self, request: RequestId, command: AutopilotCommand) {
        let now = self.shared.now();
        let link = self.record.link();
        let airborne = self.shared.peers().entry(self.record.id).is_some_and(|e| e.airborne);
        let checked = if self.pilot && command == AutopilotCommand::EnterOffboard {
            Err(Refusal::PilotInControl)
        } else if self.shared.is_stopping() && command == AutopilotCommand::EnterOffboard {
            Err(Refusal::not_permitted("the node is stopping"))
        } else if let (AutopilotCommand::Arm | AutopilotCommand::TakeOff { .. }, Err(held)) =
            (command, not_held(&self.shared))
        {
            Err(held)
        } else if self.record.is_stopped() && command != AutopilotCommand::Disarm {
            Err(emergency::stopped())
        } else {
            self.shared.gate().autopilot(&command, airborne)
        };
        match checked {
            Ok(()) => link.request(now, request, command),
            Err(refusal) => {
                self.waiting.push(Event::AutopilotResult {
                    request,
                    refusal: Some(refusal.clone()),
                });
                self.tell_refusal(now, &refusal);
            }
        }
    }

    fn setpoint(&mut self, setpoint: &Setpoint) {
        let now = self.shared.now();
        match self.checked(setpoint, now) {
            Ok((local, passed)) => {
                let valid_s = self.shared.config.link.setpoint_valid_s;
                self.refused_at = None;
                self.record.link().stream(now, local, now.plus_seconds(valid_s));
                self.record.change_state().setpoint = Some(passed);
            }
            Err(refusal) => {
                // Nobody gives way who is not steered.
                self.record.change_state().avoiding = None;
                self.refused(refusal, now);
            }
        }
    }

    /// The setpoint as the gate lets it pass, in the vehicle's own frame and in the swarm's.
    fn checked(&mut self, setpoint: &Setpoint, now: NodeTime) -> Result<(LocalSetpoint, Setpoint), Refusal> {
        if self.pilot {
            return Err(Refusal::PilotInControl);
        }
        if self.record.is_stopped() {
            return Err(emergency::stopped());
        }
        let peers = self.shared.peers();
        let entry = peers.entry(self.record.id).ok_or(Refusal::NoPosition)?;
        if !entry.link.connected {
            return Err(Refusal::LinkLost {
                vehicle: self.record.id,
            });
        }
        let gate = self.shared.gate();
        let steered = steering::steer(&gate, entry, setpoint, &peers.surroundings, now);
        if let Some(with_period) = self.thinning.wants(&self.shared.tape, &steered, &peers) {
            self.shared.tape.take(|| {
                Taken::Setpoint(Box::new(JudgedSetpoint {
                    at: now,
                    vehicle: self.record.id,
                    asked: *setpoint,
                    answer: steered.clone(),
                    gate: gate.clone(),
                    peers: peers.clone(),
                    with_period,
                }))
            });
        }
        if let Some(too_fast) = &steered.slowed {
            self.tell_refusal(now, too_fast);
        }
        let steered = steered.outcome?;
        let passed = steered.setpoint;
        self.tell_change(steered.change.as_ref(), now);
        Ok((self.to_local(&passed)?, passed))
    }

    /// Says that the separation filter or a fence changes what the vehicle wants: at its beginning, and when it cannot be kept apart.
    fn tell_change(&mut self, change: Option<&Change>, now: NodeTime) {
        let noted = change.filter(|c| c.by_m_s > WORTH_TELLING_M_S || !c.feasible);
        self.record.change_state().avoiding = noted.map(|c| Avoidance {
            by_m_s: c.by_m_s,
            because: c.because.map(who),
            distance_m: Some(c.distance_m).filter(|d| d.is_finite()),
            predicted_m: Some(c.predicted_m).filter(|d| d.is_finite()),
            feasible: c.feasible,
        });
        let Some(change) = noted else { return };
        let because = change.because.map_or_else(|| "a fence".to_owned(), who);
        let told = (because.clone(), change.feasible);
        let repeated = self
            .told_change
            .as_ref()
            .is_some_and(|(what, at)| *what == told && now.seconds_since(*at) < CHANGE_REPEAT_S);
        if repeated {
            return;
        }
        self.told_change = Some((told, now));
        let (severity, how) = if change.feasible {
            (Severity::Info, "gives way to")
        } else {
            (Severity::Warning, "cannot keep its distance from")
        };
        let near = Some(change.distance_m).filter(|d| d.is_finite());
        let at = near.map_or_else(String::new, |d| format!(", {d:.1} m away"));
        let text = format!("{}: {how} {because}{at}", self.record.name);
        self.record(severity, EventKind::Avoidance, text);
    }

    /// Sends a setpoint that holds it at a place, off others and inside of the fences.
    pub(super) fn hold_at(&self, place: PositionNed, entry: &PeerEntry, peers: &PeerSnapshot, now: NodeTime) {
        let hold = steering::hold(&self.shared.gate(), entry, place, &peers.surroundings, now);
        if let Ok(local) = self.to_local(&hold) {
            let valid_s = self.shared.config.link.setpoint_valid_s;
            self.record.link().stream(now, local, now.plus_seconds(valid_s));
        }
    }

    fn to_local(&self, setpoint: &Setpoint) -> Result<LocalSetpoint, Refusal> {
        let frame = self.shared.frame().ok_or(Refusal::NoSwarmFrame)?;
        let peers = self.shared.peers();
        let local_frame = peers
            .entry(self.record.id)
            .and_then(|e| e.telemetry.local_frame)
            .ok_or(Refusal::NoPosition)?;
        Ok(LocalSetpoint {
            position: setpoint.position.map(|p| local_frame.from_swarm(&frame, &p)),
            velocity: setpoint.velocity,
            acceleration: setpoint.forward_acceleration(),
            yaw_rad: setpoint.yaw_rad,
            yaw_rate_rad_s: setpoint.yaw_rate_rad_s,
        })
    }

    /// A refused setpoint is answered with a stop: the vehicle holds where it was when the refusals began. Nothing is sent when the
    /// vehicle is not ours to steer or cannot be steered.
    fn refused(&mut self, refusal: Refusal, now: NodeTime) {
        // That the link is lost, or that a pilot or the autopilot itself flies, was told when it began: that nothing is sent says no more.
        if !matches!(refusal, Refusal::LinkLost { .. } | Refusal::PilotInControl) {
            self.tell_refusal(now, &refusal);
        }
        let peers = self.shared.peers();
        let entry = peers.entry(self.record.id);
        if steering::is_answered_by_holding(&refusal)
            && let Some(entry) = entry
            && let Some(own) = entry.kinematics
        {
            let place = *self.refused_at.get_or_insert(own.position);
            self.hold_at(place, entry, &peers, now);
        }
        self.waiting.push(Event::Refused(refusal));
    }

    fn tell_refusal(&mut self, now: NodeTime, refusal: &Refusal) {
        let repeated = self
            .told_refusal
            .is_some_and(|(code, told)| code == refusal.code() && now.seconds_since(told) < REFUSAL_REPEAT_S);
        if repeated {
            return;
        }
        self.told_refusal = Some((refusal.code(), now));
        let text = format!("{}: refused by the safety gate: {refusal}", self.record.name);
        self.record(
            Severity::Warning,
            EventKind::Refused {
                refusal: refusal.clone(),
            },
            text,
        );
    }
}
