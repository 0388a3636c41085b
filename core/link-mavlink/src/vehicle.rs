//! The link to one vehicle without sockets or clock: frames, requests, setpoints and ticks in; frames and events out.
//!
//! Must never do: read a clock, block, or send anything but into its [`Outbox`]. The same calls in the same order give the same
//! result: recorded flights are replayed through it.

pub mod boot;
pub mod clock_sync;
mod emergency;
mod inbound;
mod messages;
pub mod parameters;
pub mod rates;
pub mod route;
mod services;
pub(crate) mod telemetry;
pub mod traffic;

use crate::decode::{Heartbeat, Inbound};
use crate::frame::FrameHeader;
use crate::outbox::Outbox;
use boot::BootWatch;
use clock_sync::ClockSync;
use mavlink::dialects::common::{HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavState, MavType};
pub(crate) use messages::command_long;
use messages::{FramesTo, position_target};
use parameters::Parameters;
use rates::{RateKeeper, Tuning};
use route::RouteUpload;
use skein_domain::link::{LinkEvent, Silence, StreamState};
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{AutopilotCommand, LinkHealth, NodeTime, Refusal, RequestId, Telemetry, VehicleId};
use skein_px4::LinkSettings;
use skein_px4::commands::{Around, Commands, Ended, Origin};
use skein_px4::emergency::EmergencyStop;
use skein_px4::events::EventQueue;
use skein_px4::local_origin::LocalOrigin;
use skein_px4::mode_watch::ModeWatch;
use skein_px4::plan::{self, Condition, Situation};
use skein_px4::setpoints::{HoldPlace, SetpointStream, StreamAction};
use skein_px4::status_text::StatusTexts;
use std::sync::Arc;
use telemetry::Estimate;
use traffic::Traffic;

pub use skein_px4::AUTOPILOT_COMPONENT;
/// A position older than this is not where the vehicle is now, in seconds.
const FRESH_POSITION_S: f64 = 1.0;
/// Longest time between two ticks, in seconds.
const TICK_MAX_S: f64 = 0.5;

/// Who a vehicle's autopilot is.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct AutopilotIdentity {
    /// `MAV_AUTOPILOT`; 12 is PX4.
    pub autopilot: u8,
    /// `MAV_TYPE`; 2 is a quadrotor.
    pub vehicle_type: u8,
    /// Firmware version: major, minor, patch, and kind (0 development .. 255 release). Absent until it says.
    pub firmware: Option<[u8; 4]>,
    /// Number of the hardware. Absent until it says.
    pub uid: Option<u64>,
}

impl AutopilotIdentity {
    /// Whether it is PX4's software in the loop, with whatever simulator: its hardware's number is the text `SIMULATIONID`, of which
    /// MAVLink tells `ONID` and `LATI`, and to whose first letter PX4 adds its system id less one.
    #[must_use]
    pub fn is_simulated(&self) -> bool {
        self.uid.is_some_and(|uid| uid.to_le_bytes()[1..] == *b"NIDLATI")
    }
}

/// One vehicle's link, without I/O.
#[derive(Debug)]
pub struct VehicleCore {
    settings: Arc<LinkSettings>,
    system_id: u8,
    identity: AutopilotIdentity,
    outbox: Outbox,
    events: EventQueue,
    traffic: Traffic,
    boot: BootWatch,
    clock: ClockSync,
    origin: LocalOrigin,
    texts: StatusTexts,
    modes: ModeWatch,
    commands: Commands,
    ended: Vec<Ended>,
    rates: RateKeeper,
    parameters: Parameters,
    stream: SetpointStream,
    estimate: Estimate,
    heartbeat: Option<Heartbeat>,
    connected: bool,
    silence: Silence,
    next_heartbeat: NodeTime,
    /// Another autopilot with its system id is heard at its own place: what is sent reaches both.
    duplicate: bool,
    interleaved: Option<NodeTime>,
    emergency: Option<EmergencyStop>,
    route: RouteUpload,
}

impl VehicleCore {
    /// The link to a vehicle that was just heard for the first time.
    #[must_use]
    pub fn new(settings: Arc<LinkSettings>, system_id: u8, first: &Heartbeat, now: NodeTime) -> Self {
        let identity = AutopilotIdentity {
            autopilot: first.autopilot,
            vehicle_type: first.vehicle_type,
            ..AutopilotIdentity::default()
        };
        let mut parameters = Parameters::default();
        parameters.set_by_number(first.autopilot != Heartbeat::AUTOPILOT_PX4);
        parameters.set_armed(first.armed());
        Self {
            outbox: Outbox::new(settings.own_system_id, settings.own_component_id),
            rates: RateKeeper::new(settings.rates, system_id, now),
            settings,
            system_id,
            identity,
            events: EventQueue::default(),
            traffic: Traffic::default(),
            boot: BootWatch::default(),
            clock: ClockSync::default(),
            origin: LocalOrigin::default(),
            texts: StatusTexts::default(),
            modes: ModeWatch::default(),
            commands: Commands::default(),
            ended: Vec::new(),
            parameters,
            stream: SetpointStream::default(),
            estimate: Estimate::default(),
            heartbeat: None,
            connected: true,
            silence: Silence::new(now),
            next_heartbeat: now,
            duplicate: false,
            interleaved: None,
            emergency: None,
            route: RouteUpload::default(),
        }
    }

    /// Its system id.
    #[must_use]
    pub fn system_id(&self) -> u8 {
        self.system_id
    }

    /// Who its autopilot is.
    #[must_use]
    pub fn identity(&self) -> &AutopilotIdentity {
        &self.identity
    }

    /// Frames to be sent.
    pub fn outbox(&mut self) -> &mut Outbox {
        &mut self.outbox
    }

    /// Events since the last call.
    pub fn take_events(&mut self) -> Vec<LinkEvent> {
        self.events.take()
    }

    /// When the last frame of its autopilot was heard.
    #[must_use]
    pub fn last_heard(&self) -> NodeTime {
        self.silence.last_heard()
    }

    /// For how long none has been heard, in seconds, without the time in which this node did not listen.
    pub fn silent_s(&mut self, now: NodeTime) -> f64 {
        self.silence.look(now);
        now.seconds_since(self.silence.since())
    }

    /// Whether the motors are armed, as the last heartbeat says.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.heartbeat.is_some_and(|heartbeat| heartbeat.armed())
    }

    /// Whether the autopilot's own failsafe is acting, as its last heartbeat says.
    #[must_use]
    pub fn in_failsafe(&self) -> bool {
        self.heartbeat.is_some_and(|heartbeat| heartbeat.failsafe())
    }

    /// When two autopilots were last heard with one system id from one place.
    #[must_use]
    pub fn interleaved(&self) -> Option<NodeTime> {
        self.interleaved
    }

    /// Notes any frame of its system; `read` is what a message that is read here says, from the autopilot only.
    pub fn on_frame(&mut self, now: NodeTime, header: &FrameHeader, read: Option<Inbound>) {
        self.take(now, header, read, false);
    }

    /// The same for a message that a payload wants as well.
    pub fn on_wanted_frame(&mut self, now: NodeTime, header: &FrameHeader, read: Option<Inbound>) {
        self.take(now, header, read, true);
    }

    fn take(&mut self, now: NodeTime, header: &FrameHeader, read: Option<Inbound>, wanted: bool) {
        let autopilot = header.component_id == AUTOPILOT_COMPONENT;
        self.traffic.on_frame(now, header.component_id, header.sequence);
        if !autopilot {
            return;
        }
        self.silence.heard(now);
        if !self.connected {
            self.connected = true;
            self.events.push(LinkEvent::Regained);
        }
        let id = header.message_id;
        match read {
            _ if wanted => self.rates.on_wanted(id),
            Some(_) => self.rates.on_message(id),
            None => self.rates.on_unused(id),
        }
        if let Some(message) = read {
            self.on_message(now, message);
        }
    }

    /// A payload wants messages from now on; none of them is turned off, and what was is asked for again.
    pub fn want(&mut self, wants: impl Fn(u32) -> bool) {
        self.rates.want(wants);
    }

    /// Does what has become due; gives when to come again.
    pub fn on_tick(&mut self, now: NodeTime) -> NodeTime {
        self.poll_emergency(now);
        self.check_lost(now);
        while let Some(text) = self.texts.poll(now) {
            self.on_text(Some(text));
        }
        self.poll_stream(now);
        self.poll_commands(now);
        self.poll_route(now);
        if self.connected {
            self.send_parameters(now);
            if let Some(request) = self.clock.poll(
                now,
                self.settings.timesync_hz,
                self.identity.is_simulated(),
                self.target(),
            ) {
                self.outbox.push(&request);
            }
            if !self.commands.is_tuning()
                && let Some(tuning) = self.rates.poll(now)
            {
                let (origin, plan) = match tuning {
                    Tuning::Rate(id, plan) => (Origin::Rate(id), plan),
                    Tuning::Copy(id, plan) => (Origin::Copy(id), plan),
                };
                self.with_commands(now, |commands, around| commands.start(around, origin, plan));
            }
        }
        if self.settings.heartbeat_hz > 0.0 && now >= self.next_heartbeat {
            self.next_heartbeat = now.plus_seconds(1.0 / self.settings.heartbeat_hz);
            self.outbox.push(&own_heartbeat());
        }
        self.due(now)
    }

    fn due(&self, now: NodeTime) -> NodeTime {
        let mut due = now.plus_seconds(TICK_MAX_S).min(self.next_heartbeat);
        let lost = self.silence.since().plus_seconds(self.settings.lost_after_s);
        let tuning = if self.commands.is_tuning() {
            None
        } else {
            Some(self.rates.due())
        };
        let when_connected = [Some(lost), tuning, Some(self.clock.due()), self.parameters.due()];
        let always = [
            self.stream.due(&self.settings),
            self.commands.due(),
            self.emergency.as_ref().map(EmergencyStop::due),
            self.route.due(),
        ];
        for next in always
            .into_iter()
            .chain(when_connected.into_iter().filter(|_| self.connected))
            .flatten()
        {
            due = due.min(next);
        }
        due
    }

    /// Declares the link lost if it has been silent for too long. True if it is declared now.
    pub fn check_lost(&mut self, now: NodeTime) -> bool {
        self.silence.look(now);
        if !self.connected || now.seconds_since(self.silence.since()) <= self.settings.lost_after_s {
            return false;
        }
        self.connected = false;
        self.traffic.restart();
        self.estimate.forget_readiness();
        self.events.push(LinkEvent::Lost);
        self.parameters.break_off("the link was lost", false);
        self.break_off_route(&Refusal::LinkLost {
            vehicle: VehicleId(u16::from(self.system_id)),
        });
        true
    }

    /// Asks the autopilot for something; the outcome comes as an event.
    pub fn request(&mut self, now: NodeTime, request: RequestId, command: AutopilotCommand) {
        if command == AutopilotCommand::EmergencyStop {
            self.stop_motors(now, request);
            return;
        }
        let planned = match self.refusal(now, command.brings_to_rest()) {
            Some(refusal) => Err(refusal),
            None if self.is_stopping_motors() => Err(Refusal::NotPermitted {
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
            Err(refusal) => self.events.push(LinkEvent::Result {
                request,
                outcome: Err(refusal),
            }),
        }
    }

    /// Takes a setpoint that is valid until `expires`, and sends it.
    pub fn stream(&mut self, now: NodeTime, setpoint: LocalSetpoint, expires: NodeTime) {
        // One that runs goes on: without it the vehicle that it flies is left to its failsafe.
        if self.duplicate && !self.stream.is_active() {
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

    /// What the stream is doing.
    #[must_use]
    pub fn stream_state(&self) -> StreamState {
        self.stream.state()
    }

    /// Another autopilot with its system id is heard at its own place, or none any more. On the ground nothing is begun then; one that flies
    /// is flown on, and can be brought to rest.
    pub fn set_duplicate(&mut self, now: NodeTime, duplicate: bool) {
        if duplicate && !self.duplicate {
            let refusal = self.duplicate_refusal();
            self.parameters.break_off(&refusal.to_string(), false);
            self.break_off_route(&refusal);
            if !self.is_armed() {
                self.commands.end_all(&mut self.ended, &refusal);
                self.finish_commands();
                let action = self.stream.give_up();
                self.act(now, action);
            }
        }
        self.duplicate = duplicate;
    }

    /// Whether another autopilot with its system id is heard at its own place.
    #[must_use]
    pub fn is_duplicate(&self) -> bool {
        self.duplicate
    }

    fn duplicate_refusal(&self) -> Refusal {
        Refusal::DuplicateSystemId {
            system_id: self.system_id,
        }
    }

    /// Latest telemetry and link health.
    pub fn read(&mut self, now: NodeTime) -> (Telemetry, LinkHealth) {
        self.check_lost(now);
        let mut telemetry = *self.estimate.telemetry();
        telemetry.local_frame = self.origin.frame();
        telemetry.position_time = self.estimate.position_time(&self.clock);
        let health = LinkHealth {
            connected: self.connected,
            last_heard: self.silence.last_heard(),
            loss: self.traffic.loss(now),
            round_trip_s: self.clock.round_trip_s().map(|seconds| seconds as f32),
            clock_offset_s: self.clock.offset_s(now),
            receive_rate_hz: self.traffic.rate_hz(now),
            setpoint_rate_hz: self.stream.rate_hz(now),
        };
        (telemetry, health)
    }

    /// Why something is not asked of it now, whether that brings it to rest or not.
    fn refusal(&mut self, now: NodeTime, brings_to_rest: bool) -> Option<Refusal> {
        self.check_lost(now);
        if self.duplicate && !brings_to_rest {
            return Some(self.duplicate_refusal());
        }
        (!self.connected).then(|| Refusal::LinkLost {
            vehicle: VehicleId(u16::from(self.system_id)),
        })
    }

    fn target(&self) -> (u8, u8) {
        (self.system_id, AUTOPILOT_COMPONENT)
    }

    fn situation(&self, now: NodeTime) -> Situation {
        let telemetry = self.estimate.telemetry();
        Situation {
            mode: telemetry.mode,
            armed: telemetry.armed,
            landed: telemetry.landed,
            streaming: self.stream.is_active(),
            place: telemetry
                .global
                .filter(|_| self.estimate.global_age_s(now) <= FRESH_POSITION_S),
            home: telemetry.home,
        }
    }

    fn poll_stream(&mut self, now: NodeTime) {
        let estimate = &self.estimate;
        let place = || HoldPlace {
            position: estimate
                .telemetry()
                .local
                .filter(|_| estimate.local_age_s(now) <= FRESH_POSITION_S),
            yaw_rad: estimate.yaw_rad(),
        };
        let action = self.stream.poll(now, place, &self.settings);
        self.act(now, action);
    }

    fn act(&mut self, now: NodeTime, action: StreamAction) {
        if let Some(setpoint) = action.send {
            let stamp_ms = (now.0 / 1000) as u32;
            self.outbox.push(&position_target(&setpoint, stamp_ms, self.target()));
        }
        if let Some(state) = action.changed {
            self.events.push(LinkEvent::Stream(state));
        }
    }

    fn poll_commands(&mut self, now: NodeTime) {
        self.with_commands(now, Commands::poll);
    }

    fn with_commands(&mut self, now: NodeTime, act: impl FnOnce(&mut Commands, &mut Around<'_>)) {
        let mut around = Around {
            now,
            settings: &self.settings,
            situation: self.situation(now),
            stream_has_run: self.stream.has_run(now, self.settings.offboard_lead_s),
            texts: &self.texts,
            modes: &mut self.modes,
            outlet: &mut FramesTo(&mut self.outbox, (self.system_id, AUTOPILOT_COMPONENT)),
            ended: &mut self.ended,
        };
        act(&mut self.commands, &mut around);
        self.finish_commands();
    }

    fn finish_commands(&mut self) {
        for Ended { origin, outcome } in self.ended.drain(..) {
            match origin {
                Origin::Request(request) => self.events.push(LinkEvent::Result { request, outcome }),
                Origin::Rate(id) => self.rates.on_rate_ended(id, outcome.is_ok()),
                Origin::Copy(_) | Origin::Nobody => {}
            }
        }
    }
}

/// The node's own heartbeat: a ground station's, for only to those PX4 sends status texts.
#[must_use]
pub fn own_heartbeat() -> HEARTBEAT_DATA {
    HEARTBEAT_DATA {
        custom_mode: 0,
        mavtype: MavType::MAV_TYPE_GCS,
        autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    }
}
