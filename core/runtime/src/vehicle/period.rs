//! One control period of a vehicle: gather what happened, ask the model, carry out what it wants.

use super::VehicleState;
use skein_coordination::steering::{others, own_state, told};
use skein_domain::exchange::{Event, PayloadReport, Severity};
use skein_domain::link::{LinkEvent, StreamState};
use skein_domain::{FlightMode, Refusal, Task};
use skein_state::emergency::EMERGENCY_REQUEST;
use skein_state::is_upload;
use skein_view::EventKind;
use skein_view::PeerSnapshot;
use std::sync::Arc;

impl VehicleState {
    /// The whole period.
    pub(super) async fn period(&mut self) {
        let peers = self.shared.peers();
        let running = self.ensure_model().await;
        if self.takes_back(&peers) {
            return;
        }
        self.watch(&peers).await;
        self.tell_parameters();
        // Taken in any case: none waits for a model that is away.
        let stick = self.record.hand.lock().take(self.shared.now());
        if !running {
            self.hear_of_stop();
            return;
        }
        self.next_leg();
        let mut events = self.gather(&peers);
        events.extend(stick.map(Event::Stick));
        events.push(Event::Tick);
        self.call_model(events).await;
        self.model.life.publish_statistics();
    }

    /// Everything that happened since the last batch, and the vehicle's own state.
    pub(super) fn gather(&mut self, peers: &PeerSnapshot) -> Vec<Event> {
        let mut events = std::mem::take(&mut self.waiting);
        let Some(entry) = peers.entry(self.record.id) else {
            return events;
        };
        let mut own = own_state(entry, self.shared.frame());
        let link = self.record.link();
        for event in link.take_events() {
            // The peers were read before these events came: the model must not see a mode beside an older armed state.
            match event {
                LinkEvent::ArmedChanged { armed } => own.armed = armed,
                LinkEvent::ModeChanged { to, .. } => own.mode = to,
                _ => {}
            }
            self.take_link_event(event, &mut events);
        }
        events.push(Event::Own(own));
        self.gather_surroundings(peers, &mut events);
        let intent = self.shared.coordination.intent();
        let task = intent.tasks.get(&self.record.id);
        let is_new = task.is_some_and(|task| task.version > self.task_version);
        // Not against a reaction that is in force.
        if !is_new || self.may_take_task() {
            events.extend(told(&intent, peers, self.record.id, &mut self.task_version));
        }
        events
    }

    /// What becomes of an emergency stop is told whether a model runs or not. What else the link has to say waits for the model.
    fn hear_of_stop(&mut self) {
        if !self.record.is_stopped() {
            return;
        }
        let link = self.record.link();
        let mut events = std::mem::take(&mut self.waiting);
        for event in link.take_events() {
            self.take_link_event(event, &mut events);
        }
        self.waiting = events;
    }

    /// What a model that carries or observes something wants to know. A vehicle without payloads is spared it.
    fn gather_surroundings(&mut self, peers: &PeerSnapshot, events: &mut Vec<Event>) {
        let tracks = self.shared.observed.tracks();
        if !Arc::ptr_eq(&tracks, &self.model.tracks) {
            events.push(Event::Tracks(tracks.as_ref().clone()));
            self.model.tracks = tracks;
        }
        let payloads = self.record.payloads();
        let keeps = {
            let intent = self.shared.coordination.intent();
            let task = intent.tasks.get(&self.record.id);
            task.is_some_and(|task| matches!(task.task, Task::Keep(_)))
        };
        if keeps || !payloads.is_empty() {
            events.push(Event::Peers(others(peers, self.record.id)));
        }
        for payload in payloads {
            let (revision, report) = {
                let published = payload.state();
                (published.revision, published.report.clone())
            };
            if revision > 0 && self.model.seen.insert(payload.name.clone(), revision) != Some(revision) {
                events.push(Event::Payload(PayloadReport {
                    name: payload.name.clone(),
                    kind: payload.kind,
                    state_json: report.map(|r| r.json.as_ref().to_owned()),
                }));
            }
        }
    }

    pub(super) fn take_link_event(&mut self, event: LinkEvent, events: &mut Vec<Event>) {
        let name = &self.record.name;
        match event {
            LinkEvent::Result { request, outcome } if request == EMERGENCY_REQUEST => self.tell_emergency(&outcome),
            LinkEvent::StopUnconfirmed { after_s } => {
                let text = format!(
                    "{name}: EMERGENCY STOP NOT CONFIRMED after {after_s:.1} s: the motors may still run; it is sent again and again"
                );
                self.record(Severity::Critical, EventKind::EmergencyStop, text);
            }
            LinkEvent::Result { request, outcome } if is_upload(request) => self.tell_upload(request, outcome),
            LinkEvent::Result { request, outcome } => {
                events.push(Event::AutopilotResult {
                    request,
                    refusal: outcome.err(),
                });
            }
            LinkEvent::ModeChanged { from, to, commanded } => {
                self.watch_pilot(from, to, commanded);
                events.push(Event::ModeChanged { from, to, commanded });
            }
            LinkEvent::ArmedChanged { armed } => {
                self.pilot &= armed;
                let what = if armed { "armed" } else { "disarmed" };
                self.record(Severity::Info, EventKind::Notice, format!("{name} {what}"));
            }
            LinkEvent::Lost => {
                self.record(Severity::Critical, EventKind::LinkLost, format!("{name}: link lost"));
                events.push(Event::LinkLost(true));
            }
            LinkEvent::Regained => {
                let text = format!("{name}: link regained");
                self.record(Severity::Advisory, EventKind::LinkRegained, text);
                events.push(Event::LinkLost(false));
            }
            LinkEvent::Rebooted => {
                let text = format!("{name}: autopilot restarted");
                self.record(Severity::Warning, EventKind::AutopilotRebooted, text);
                self.record.failsafe.lock().autopilot_restarted();
                events.push(Event::Rebooted);
            }
            LinkEvent::StatusText { severity, text } => {
                let level = match severity {
                    0..=2 => Severity::Critical,
                    3 | 4 => Severity::Warning,
                    _ => Severity::Info,
                };
                self.record(level, EventKind::StatusText, format!("{name}: {text}"));
            }
            LinkEvent::Stream(state) => self.tell_stream(state),
            LinkEvent::ClockJumped { by_s } => {
                let text = format!("{name}: the autopilot's clock jumped by {by_s:.3} s");
                self.record(Severity::Warning, EventKind::Notice, text);
            }
            LinkEvent::RoutePointReached { index } => {
                let text = format!("{name}: point {index} of its route reached");
                self.record(Severity::Info, EventKind::Notice, text);
            }
        }
    }

    /// What became of an emergency stop.
    fn tell_emergency(&self, outcome: &Result<(), Refusal>) {
        let name = &self.record.name;
        let (severity, text) = match outcome {
            Ok(()) => (Severity::Warning, format!("{name}: motors stopped")),
            Err(refusal) => (
                Severity::Critical,
                format!("{name}: it is not known whether the motors stopped: {refusal}"),
            ),
        };
        self.record(severity, EventKind::EmergencyStop, text);
    }

    fn tell_stream(&self, state: StreamState) {
        let name = &self.record.name;
        let (severity, text) = match state {
            StreamState::HoldingExpired => (
                Severity::Warning,
                format!("{name}: no fresh setpoint, the link holds position"),
            ),
            StreamState::GivenUp => (
                Severity::Critical,
                format!("{name}: no fresh setpoint for too long, the stream is stopped on purpose"),
            ),
            StreamState::Fresh | StreamState::Stopped => return,
        };
        self.record(severity, EventKind::Stream, text);
    }

    /// Leaving OFFBOARD unasked, or a mode only a pilot chooses, takes the vehicle out of the swarm's control. The stream ends at once:
    /// PX4 would go back to OFFBOARD by itself as long as setpoints come, also out of its own failsafe.
    fn watch_pilot(&mut self, from: FlightMode, to: FlightMode, commanded: bool) {
        let by_stick = matches!(
            to,
            FlightMode::Manual
                | FlightMode::Altitude
                | FlightMode::Position
                | FlightMode::Acro
                | FlightMode::Stabilized
        );
        if commanded || (from != FlightMode::Offboard && !by_stick) || to == FlightMode::Offboard || self.pilot {
            return;
        }
        let now = self.shared.now();
        let link = self.record.link();
        let (telemetry, _) = link.read(now);
        if !telemetry.armed {
            return;
        }
        self.pilot = true;
        link.stop_stream(now);
        let why = if telemetry.failsafe {
            "by the autopilot's own failsafe"
        } else {
            "without being told: a pilot or another ground station is in control"
        };
        let text = format!("{}: {from} left for {to} {why}", self.record.name);
        let failsafe = telemetry.failsafe;
        self.record(Severity::Warning, EventKind::TakenOver { failsafe, from, to }, text);
    }
}
