//! The link to one vehicle without DDS and without a clock: samples, requests, setpoints and ticks in; messages and events out.
//!
//! Must never do: read a clock, block, or decide otherwise than the link over MAVLink does. What commands, setpoints, modes and the emergency
//! stop mean is that link's code (`skein_px4`); only the wire is another one here.

pub mod estimate;
pub mod setpoint;
pub mod wire_clock;

use crate::sample::{Ack, Sample, Status, Timesync};
use estimate::Estimate;
use setpoint::{Outgoing, Sender};
use skein_domain::link::{LinkEvent, Silence, StreamState};
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{
    AutopilotCommand, FlightMode, LandedState, LinkHealth, NodeTime, Refusal, RequestId, Telemetry, VehicleId,
};
use skein_px4::LinkSettings;
use skein_px4::SendRate;
use skein_px4::acknowledgement::Acknowledgement;
use skein_px4::commands::{Around, CommandOutlet, Commands, Ended, Origin};
use skein_px4::emergency::{ARM_DISARM, EmergencyStop, Urgent};
use skein_px4::events::EventQueue;
use skein_px4::local_origin::LocalOrigin;
use skein_px4::mode_watch::ModeWatch;
use skein_px4::plan::{self, Command, Condition, Situation};
use skein_px4::setpoints::{HoldPlace, SetpointStream, StreamAction};
use skein_px4::status_text::StatusTexts;
use std::sync::Arc;
use wire_clock::{Tick, WireClock};

/// A position older than this is not where the vehicle is now, in seconds.
const FRESH_POSITION_S: f64 = 1.0;
/// Longest time between two ticks, in seconds.
const TICK_MAX_S: f64 = 0.5;
/// Of `timesync_status`: it is about the agent's clock.
const SYNC_WITH_AGENT: u8 = 2;

/// One vehicle's link, without I/O.
#[derive(Debug)]
pub struct VehicleSession {
    settings: Arc<LinkSettings>,
    system_id: u8,
    outbox: Vec<Outgoing>,
    events: EventQueue,
    clock: WireClock,
    origin: LocalOrigin,
    /// PX4 tells no texts over these topics.
    texts: StatusTexts,
    modes: ModeWatch,
    commands: Commands,
    ended: Vec<Ended>,
    stream: SetpointStream,
    estimate: Estimate,
    status: Option<Status>,
    received: SendRate,
    connected: bool,
    silence: Silence,
    refuse_all: Option<Refusal>,
    /// Another autopilot speaks in its namespace: what is sent reaches both.
    duplicate: bool,
    emergency: Option<EmergencyStop>,
}

/// Commands on their way into the outbox.
struct ToOutbox<'a> {
    outbox: &'a mut Vec<Outgoing>,
    stamp_us: u64,
    target_system: u8,
    sender: Sender,
}

impl CommandOutlet for ToOutbox<'_> {
    fn command(&mut self, command: &Command, confirmation: u8) {
        let message = setpoint::command(command, confirmation, self.stamp_us, self.target_system, self.sender);
        self.outbox.push(Outgoing::Command(message));
    }
}

impl VehicleSession {
    /// The link to a vehicle that has just been admitted.
    #[must_use]
    pub fn new(settings: &LinkSettings, system_id: u8, now: NodeTime) -> Self {
        let settings = LinkSettings {
            // No text comes beside a refusal, so that none is awaited.
            refusal_text_s: 0.0,
            ..settings.clone()
        };
        Self {
            settings: Arc::new(settings),
            system_id,
            outbox: Vec::new(),
            events: EventQueue::default(),
            clock: WireClock::default(),
            origin: LocalOrigin::default(),
            texts: StatusTexts::default(),
            modes: ModeWatch::default(),
            commands: Commands::default(),
            ended: Vec::new(),
            stream: SetpointStream::default(),
            estimate: Estimate::default(),
            status: None,
            received: SendRate::default(),
            connected: true,
            silence: Silence::new(now),
            refuse_all: None,
            duplicate: false,
            emergency: None,
        }
    }

    /// Its system id.
    #[must_use]
    pub fn system_id(&self) -> u8 {
        self.system_id
    }

    /// Messages to be sent, in order.
    pub fn take_outgoing(&mut self) -> Vec<Outgoing> {
        std::mem::take(&mut self.outbox)
    }

    /// Events since the last call.
    pub fn take_events(&mut self) -> Vec<LinkEvent> {
        self.events.take()
    }

    /// Tells the vehicle's actor something that has no event of its own.
    pub fn notice(&mut self, severity: u8, text: String) {
        self.events.push(LinkEvent::StatusText { severity, text });
    }

    /// When a sample was last heard.
    #[must_use]
    pub fn last_heard(&self) -> NodeTime {
        self.silence.last_heard()
    }

    /// Whether the autopilot's own failsafe is acting.
    #[must_use]
    pub fn in_failsafe(&self) -> bool {
        self.status.is_some_and(|status| status.failsafe)
    }

    /// What the stream is doing.
    #[must_use]
    pub fn stream_state(&self) -> StreamState {
        self.stream.state()
    }

    /// Takes in a sample that has passed the check.
    pub fn on_sample(&mut self, now: NodeTime, sample: &Sample) {
        self.silence.heard(now);
        self.received.on_sent(now);
        if !self.connected {
            self.connected = true;
            self.events.push(LinkEvent::Regained);
        }
        match sample {
            Sample::Local(local) => {
                match self.clock.on_stamp(now, local.stamp_us) {
                    Tick::Steady => {}
                    Tick::Jumped { by_s } => self.events.push(LinkEvent::ClockJumped { by_s }),
                    Tick::Restarted => self.on_reboot(now),
                }
                self.estimate.on_local(now, local, &self.clock, &mut self.origin);
            }
            Sample::Attitude(attitude) => self.estimate.on_attitude(now, attitude),
            Sample::Global(global) => {
                self.estimate.on_global(now, global, &mut self.origin);
            }
            Sample::Status(status) => self.on_status(now, *status),
            Sample::Landed(landed) => {
                if self.estimate.on_landed(landed.landed) {
                    self.poll_commands(now);
                }
            }
            Sample::Battery(battery) => self.estimate.on_battery(now, battery),
            Sample::Gnss(gnss) => self.estimate.on_gnss(now, gnss),
            Sample::Home(home) => self.estimate.on_home(home),
            Sample::Timesync(sync) => self.on_sync(now, *sync),
            Sample::Ack(ack) => self.on_ack(now, *ack),
        }
    }

    fn on_sync(&mut self, now: NodeTime, sync: Timesync) {
        if sync.source != SYNC_WITH_AGENT {
            return;
        }
        let clock = &mut self.clock;
        if clock.on_sync(now, sync.stamp_us, sync.offset_us, sync.round_trip_us) {
            self.on_reboot(now);
        }
    }

    /// Answers to others are not ours, though they may be about the same command.
    fn on_ack(&mut self, now: NodeTime, ack: Ack) {
        let system = u16::from(self.settings.own_system_id);
        let component = u16::from(self.settings.own_component_id);
        let ours = |id: u16, own: u16| id == 0 || id == own;
        let Ok(command) = u16::try_from(ack.command) else {
            return;
        };
        if !ours(ack.target_system.into(), system) || !ours(ack.target_component, component) {
            return;
        }
        let ack = Acknowledgement {
            command,
            result: ack.result,
            target_system: self.settings.own_system_id,
            target_component: self.settings.own_component_id,
        };
        if !self.emergency.as_mut().is_some_and(|stop| stop.acknowledge(&ack)) {
            self.with_commands(now, |commands, around| commands.on_ack(around, &ack));
        }
    }

    fn on_status(&mut self, now: NodeTime, status: Status) {
        let armed_before = self.status.replace(status).map(|before| before.armed());
        let armed = status.armed();
        self.estimate.on_status(now, &status);
        if armed_before.is_some_and(|before| before != armed) {
            self.events.push(LinkEvent::ArmedChanged { armed });
        }
        let round_trip_s = self.clock.round_trip_s().unwrap_or(0.0);
        let settled = |stop: &EmergencyStop| stop.is_settled(now, round_trip_s);
        if !armed && self.emergency.as_ref().is_some_and(settled) {
            self.end_emergency(now, Ok(()));
        }
        let mode = self.estimate.telemetry().mode;
        if let Some(change) = self.modes.on_mode(now, mode) {
            let (from, to, commanded) = (change.from, change.to, change.commanded);
            self.events.push(LinkEvent::ModeChanged { from, to, commanded });
            // On the ground nobody is taken out of anyone's control: after a landing PX4 changes its mode by itself.
            if from == FlightMode::Offboard && !commanded && armed {
                let action = self.stream.taken_over();
                self.act(now, action);
            }
        }
        if !armed && self.estimate.telemetry().landed == LandedState::OnGround {
            self.stream.unbar();
        } else if mode == FlightMode::Offboard {
            self.stream.handed_back();
        }
        self.poll_commands(now);
    }

    /// The autopilot restarted: it has forgotten its frame and every command; so must we.
    pub fn on_reboot(&mut self, now: NodeTime) {
        self.events.push(LinkEvent::Rebooted);
        self.origin.restart();
        self.clock = WireClock::default();
        self.estimate.restart();
        let refusal = Refusal::Autopilot {
            result: "rebooted".to_owned(),
            text: String::new(),
        };
        self.commands.end_all(&mut self.ended, &refusal);
        self.finish_commands();
        // Its frame may be another now: no old position must reach it.
        let action = self.stream.stop();
        self.act(now, action);
    }

    /// Does what has become due; gives when to come again.
    pub fn on_tick(&mut self, now: NodeTime) -> NodeTime {
        self.poll_emergency(now);
        self.check_lost(now);
        self.poll_stream(now);
        self.poll_commands(now);
        let lost = self.silence.since().plus_seconds(self.settings.lost_after_s);
        let due = [
            self.stream.due(&self.settings),
            self.commands.due(),
            self.emergency.as_ref().map(EmergencyStop::due),
            Some(lost).filter(|_| self.connected),
        ];
        let latest = now.plus_seconds(TICK_MAX_S);
        due.into_iter().flatten().fold(latest, NodeTime::min)
    }

    /// Declares the link lost if it has been silent for too long. True if it is declared now.
    pub fn check_lost(&mut self, now: NodeTime) -> bool {
        self.silence.look(now);
        if !self.connected || now.seconds_since(self.silence.since()) <= self.settings.lost_after_s {
            return false;
        }
        self.connected = false;
        self.clock.doubt();
        self.events.push(LinkEvent::Lost);
        true
    }

    /// Another one speaks as the vehicle from now on: it may have started anew.
    pub fn doubt_clock(&mut self) {
        self.clock.doubt();
    }

    /// Asks the autopilot for something; the outcome comes as an event.
    pub fn request(&mut self, now: NodeTime, request: RequestId, command: AutopilotCommand) {
        if command == AutopilotCommand::EmergencyStop {
            // Its refusal comes as an event as well.
            let _ = self.stop_motors(now, request);
            return;
        }
        let planned = match self.refusal(now, command.brings_to_rest()) {
            Some(refusal) => Err(refusal),
            None if self.emergency.is_some() => Err(Refusal::NotPermitted {
                detail: "an emergency stop is under way".to_owned(),
            }),
            None => plan::plan(command, &self.situation(now)),
        };
        match planned {
            Ok(plan) => {
                if plan.condition == Condition::Streaming {
                    self.stream.unbar();
                }
                self.with_commands(now, |commands, around| {
                    commands.start(around, Origin::Request(request), plan)
                });
            }
            Err(refusal) => self.fail(request, refusal),
        }
    }

    /// A route, or anything else that this interface of PX4 does not have.
    pub fn not_supported(&mut self, request: RequestId, what: &str) {
        let detail = format!("{what} over DDS: PX4 has no topic for it");
        self.fail(request, Refusal::NotSupported { detail });
    }

    fn fail(&mut self, request: RequestId, refusal: Refusal) {
        let outcome = Err(refusal);
        self.events.push(LinkEvent::Result { request, outcome });
    }

    /// Takes a setpoint that is valid until `expires`, and sends it.
    pub fn stream(&mut self, now: NodeTime, setpoint: LocalSetpoint, expires: NodeTime) {
        // One that runs goes on: without it the vehicle that it flies is left to its failsafe.
        if self.refuse_all.is_some() || (self.duplicate && !self.stream.is_active()) {
            return;
        }
        let action = self.stream.offer(now, setpoint, expires, &self.settings);
        self.act(now, action);
        if self.commands.is_entering_offboard() {
            self.poll_commands(now);
        }
    }

    /// Setpoints may be sent again although the autopilot's failsafe took the vehicle out of OFFBOARD.
    pub fn resume_stream(&mut self) {
        self.stream.handed_back();
    }

    /// Ends the stream on purpose.
    pub fn stop_stream(&mut self, now: NodeTime) {
        let action = self.stream.stop();
        self.act(now, action);
    }

    /// Refuses everything from now on: its topics are another vehicle's.
    pub fn refuse_all(&mut self, now: NodeTime, refusal: Refusal) {
        self.end(now, &refusal);
        self.refuse_all = Some(refusal);
    }

    fn end(&mut self, now: NodeTime, refusal: &Refusal) {
        self.commands.end_all(&mut self.ended, refusal);
        self.finish_commands();
        let action = self.stream.give_up();
        self.act(now, action);
    }

    /// Another autopilot speaks in its namespace, or none any more. On the ground nothing is begun then; one that flies is flown on, and can be
    /// brought to rest.
    pub fn set_duplicate(&mut self, now: NodeTime, duplicate: bool) {
        if duplicate && !self.duplicate && !self.status.is_some_and(|status| status.armed()) {
            self.end(now, &self.duplicate_refusal());
        }
        self.duplicate = duplicate;
    }

    fn duplicate_refusal(&self) -> Refusal {
        Refusal::DuplicateSystemId {
            system_id: self.system_id,
        }
    }

    /// Whether another autopilot speaks in its namespace.
    #[must_use]
    pub fn is_duplicate(&self) -> bool {
        self.duplicate
    }

    /// Latest telemetry and link health.
    pub fn read(&mut self, now: NodeTime) -> (Telemetry, LinkHealth) {
        self.check_lost(now);
        let mut telemetry = *self.estimate.telemetry();
        telemetry.local_frame = self.origin.frame();
        telemetry.position_time = self.estimate.position_time();
        let health = LinkHealth {
            connected: self.connected,
            last_heard: self.silence.last_heard(),
            // Best effort: what was lost on the way is not told.
            loss: 0.0,
            round_trip_s: self.clock.round_trip_s().map(|seconds| seconds as f32),
            clock_offset_s: self.clock.offset_s(now),
            receive_rate_hz: self.received.rate_hz(now),
            setpoint_rate_hz: self.stream.rate_hz(now),
        };
        (telemetry, health)
    }

    /// Why something is not asked of it now, whether that brings it to rest or not.
    fn refusal(&mut self, now: NodeTime, brings_to_rest: bool) -> Option<Refusal> {
        self.check_lost(now);
        if self.refuse_all.is_some() {
            return self.refuse_all.clone();
        }
        if self.duplicate && !brings_to_rest {
            return Some(self.duplicate_refusal());
        }
        (!self.connected).then(|| Refusal::LinkLost {
            vehicle: VehicleId(u16::from(self.system_id)),
        })
    }

    /// Stops the motors at once, whoever else hears it.
    ///
    /// # Errors
    /// When its topics are another vehicle's.
    pub fn stop_motors(&mut self, now: NodeTime, request: RequestId) -> Result<(), Refusal> {
        if let Some(refusal) = self.refuse_all.clone() {
            self.fail(request, refusal.clone());
            return Err(refusal);
        }
        self.end_emergency(now, Err(Refusal::Superseded));
        self.emergency = Some(EmergencyStop::new(request, now));
        // First of all the command itself: nothing that follows may keep it waiting.
        self.poll_emergency(now);
        self.commands.end_flying(&mut self.ended, &Refusal::Superseded);
        self.finish_commands();
        let action = self.stream.bar_for_good();
        self.act(now, action);
        Ok(())
    }

    fn poll_emergency(&mut self, now: NodeTime) {
        let sender = self.sender();
        let Some(stop) = &mut self.emergency else { return };
        match stop.poll(now, &self.texts) {
            Urgent::Wait => {}
            Urgent::Send(command, before) => {
                let stamp_us = self.clock.stamp_us(now);
                let message = setpoint::command(&command, before, stamp_us, self.system_id, sender);
                self.outbox.push(Outgoing::Command(message));
            }
            Urgent::Unconfirmed(after_s) => self.events.push(LinkEvent::StopUnconfirmed { after_s }),
            Urgent::Over(refusal) => self.end_emergency(now, Err(refusal)),
        }
    }

    fn end_emergency(&mut self, now: NodeTime, outcome: Result<(), Refusal>) {
        if let Some(stop) = self.emergency.take() {
            self.commands.rest(ARM_DISARM, EmergencyStop::rests_until(now));
            let request = stop.request();
            self.events.push(LinkEvent::Result { request, outcome });
        }
    }

    fn sender(&self) -> Sender {
        Sender {
            system_id: self.settings.own_system_id,
            component_id: self.settings.own_component_id,
        }
    }

    fn situation(&self, now: NodeTime) -> Situation {
        let telemetry = self.estimate.telemetry();
        let age_s = now.seconds_since(telemetry.heard.global);
        Situation {
            mode: telemetry.mode,
            armed: telemetry.armed,
            landed: telemetry.landed,
            streaming: self.stream.is_active(),
            place: telemetry.global.filter(|_| age_s <= FRESH_POSITION_S),
            home: telemetry.home,
        }
    }

    fn poll_stream(&mut self, now: NodeTime) {
        let estimate = &self.estimate;
        let place = || {
            let telemetry = estimate.telemetry();
            let age_s = now.seconds_since(telemetry.heard.local);
            HoldPlace {
                position: telemetry.local.filter(|_| age_s <= FRESH_POSITION_S),
                yaw_rad: estimate.yaw_rad(),
            }
        };
        let action = self.stream.poll(now, place, &self.settings);
        self.act(now, action);
    }

    fn act(&mut self, now: NodeTime, action: StreamAction) {
        if let Some(setpoint) = action.send {
            let stamp_us = self.clock.stamp_us(now);
            self.outbox.push(setpoint::setpoint(&setpoint, stamp_us));
        }
        if let Some(state) = action.changed {
            self.events.push(LinkEvent::Stream(state));
        }
    }

    fn poll_commands(&mut self, now: NodeTime) {
        self.with_commands(now, Commands::poll);
    }

    fn with_commands(&mut self, now: NodeTime, act: impl FnOnce(&mut Commands, &mut Around<'_>)) {
        let (situation, sender) = (self.situation(now), self.sender());
        let mut outlet = ToOutbox {
            stamp_us: self.clock.stamp_us(now),
            target_system: self.system_id,
            sender,
            outbox: &mut self.outbox,
        };
        let mut around = Around {
            now,
            settings: &self.settings,
            situation,
            stream_has_run: self.stream.has_run(now, self.settings.offboard_lead_s),
            texts: &self.texts,
            modes: &mut self.modes,
            outlet: &mut outlet,
            ended: &mut self.ended,
        };
        act(&mut self.commands, &mut around);
        self.finish_commands();
    }

    fn finish_commands(&mut self) {
        for Ended { origin, outcome } in self.ended.drain(..) {
            if let Origin::Request(request) = origin {
                self.events.push(LinkEvent::Result { request, outcome });
            }
        }
    }
}

#[cfg(test)]
mod tests;
