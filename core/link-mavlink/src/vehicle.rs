//! The link to one vehicle without sockets or clock: frames, requests, setpoints and ticks in; frames and events out.
//!
//! Must never do: read a clock, block, or send anything but into its [`Outbox`]. The same calls in the same order give the same
//! result: recorded flights are replayed through it.

pub mod boot;
pub mod cameras;
pub mod clock_sync;
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
use cameras::Cameras;
use clock_sync::ClockSync;
use mavlink::dialects::common::{HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavState, MavType};
use messages::FramesTo;
pub(crate) use messages::command_long;
use parameters::Parameters;
use rates::{RateKeeper, Tuning};
use route::RouteUpload;
use skein_domain::link::{LinkEvent, Silence, StreamState};
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{AutopilotCommand, LinkHealth, NodeTime, Refusal, RequestId, Telemetry, VehicleId};
use skein_px4::LinkSettings;
use skein_px4::commands::Origin;
use skein_px4::local_origin::LocalOrigin;
use skein_px4::offboard::{Moment, OffboardControl};
use skein_px4::plan::Situation;
use skein_px4::setpoints::HoldPlace;
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
    offboard: OffboardControl,
    traffic: Traffic,
    boot: BootWatch,
    clock: ClockSync,
    origin: LocalOrigin,
    rates: RateKeeper,
    parameters: Parameters,
    estimate: Estimate,
    heartbeat: Option<Heartbeat>,
    connected: bool,
    silence: Silence,
    next_heartbeat: NodeTime,
    /// Another autopilot with its system id is heard at its own place: what is sent reaches both.
    duplicate: bool,
    interleaved: Option<NodeTime>,
    route: RouteUpload,
    cameras: Cameras,
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
            cameras: Cameras::new(system_id, settings.own_system_id),
            rates: RateKeeper::new(settings.rates, system_id, now),
            settings,
            system_id,
            identity,
            offboard: OffboardControl::default(),
            traffic: Traffic::default(),
            boot: BootWatch::default(),
            clock: ClockSync::default(),
            origin: LocalOrigin::default(),
            parameters,
            estimate: Estimate::default(),
            heartbeat: None,
            connected: true,
            silence: Silence::new(now),
            next_heartbeat: now,
            duplicate: false,
            interleaved: None,
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
        self.offboard.events.take()
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
            self.offboard.events.push(LinkEvent::Regained);
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

    /// The cameras that this node speaks for.
    pub fn cameras(&mut self) -> &mut Cameras {
        &mut self.cameras
    }

    /// Does what has become due; gives when to come again.
    pub fn on_tick(&mut self, now: NodeTime) -> NodeTime {
        self.control(now, OffboardControl::poll_emergency);
        self.check_lost(now);
        while let Some(text) = self.offboard.texts.poll(now) {
            self.on_text(Some(text));
        }
        self.control(now, OffboardControl::poll);
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
            if !self.offboard.is_tuning()
                && let Some(tuning) = self.rates.poll(now)
            {
                let (origin, plan) = match tuning {
                    Tuning::Rate(id, plan) => (Origin::Rate(id), plan),
                    Tuning::Copy(id, plan) => (Origin::Copy(id), plan),
                };
                self.control(now, |offboard, moment| offboard.start(moment, origin, plan));
            }
        }
        if self.settings.heartbeat_hz > 0.0 && now >= self.next_heartbeat {
            self.next_heartbeat = now.plus_seconds(1.0 / self.settings.heartbeat_hz);
            self.outbox.push(&own_heartbeat());
        }
        // Behind what flies the vehicle, and never to two of them.
        if self.connected && !self.duplicate {
            self.cameras.poll(now, &mut self.outbox);
        }
        self.due(now)
    }

    fn due(&self, now: NodeTime) -> NodeTime {
        let mut due = now.plus_seconds(TICK_MAX_S).min(self.next_heartbeat);
        let lost = self.silence.since().plus_seconds(self.settings.lost_after_s);
        let tuning = (!self.offboard.is_tuning()).then(|| self.rates.due());
        let cameras = self.cameras.due().filter(|_| !self.duplicate);
        let when_connected = [
            Some(lost),
            tuning,
            Some(self.clock.due()),
            self.parameters.due(),
            cameras,
        ];
        let always = [self.offboard.due(&self.settings), self.route.due()];
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
        self.offboard.events.push(LinkEvent::Lost);
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
        let refusal = self.refusal(now, command.brings_to_rest());
        self.control(now, |offboard, moment| {
            offboard.request(moment, request, command, refusal)
        });
    }

    /// Stops the motors at once, whoever else hears it.
    pub fn stop_motors(&mut self, now: NodeTime, request: RequestId) {
        self.control(now, |offboard, moment| offboard.stop_motors(moment, request));
    }

    /// Takes a setpoint that is valid until `expires`, and sends it.
    pub fn stream(&mut self, now: NodeTime, setpoint: LocalSetpoint, expires: NodeTime) {
        // One that runs goes on: without it the vehicle that it flies is left to its failsafe.
        if self.duplicate && !self.offboard.is_streaming() {
            return;
        }
        self.control(now, |offboard, moment| offboard.stream(moment, setpoint, expires));
    }

    /// Setpoints may be sent again although the autopilot's failsafe took the vehicle out of OFFBOARD.
    pub fn resume_stream(&mut self) {
        self.offboard.resume_stream();
    }

    /// Ends the stream on purpose.
    pub fn stop_stream(&mut self, now: NodeTime) {
        self.control(now, OffboardControl::stop_stream);
    }

    /// What the stream is doing.
    #[must_use]
    pub fn stream_state(&self) -> StreamState {
        self.offboard.stream_state()
    }

    /// Another autopilot with its system id is heard at its own place, or none any more. On the ground nothing is begun then; one that flies
    /// is flown on, and can be brought to rest.
    pub fn set_duplicate(&mut self, now: NodeTime, duplicate: bool) {
        if duplicate && !self.duplicate {
            let refusal = self.duplicate_refusal();
            self.parameters.break_off(&refusal.to_string(), false);
            self.break_off_route(&refusal);
            if !self.is_armed() {
                self.control(now, |offboard, moment| offboard.give_up(moment, &refusal));
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
            setpoint_rate_hz: self.offboard.setpoint_rate_hz(now),
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

    /// Lets what controls it act on what is known of it now.
    fn control(&mut self, now: NodeTime, act: impl FnOnce(&mut OffboardControl, &mut Moment<'_>)) {
        let (estimate, target) = (&self.estimate, self.target());
        let telemetry = estimate.telemetry();
        let is_fresh = |age_s: f64| age_s <= FRESH_POSITION_S;
        let mut moment = Moment {
            now,
            settings: &self.settings,
            situation: Situation {
                mode: telemetry.mode,
                armed: telemetry.armed,
                landed: telemetry.landed,
                streaming: false,
                place: telemetry.global.filter(|_| is_fresh(estimate.global_age_s(now))),
                home: telemetry.home,
            },
            hold: HoldPlace {
                position: telemetry.local.filter(|_| is_fresh(estimate.local_age_s(now))),
                yaw_rad: estimate.yaw_rad(),
            },
            wire: &mut FramesTo {
                outbox: &mut self.outbox,
                target,
                stamp_ms: (now.0 / 1000) as u32,
            },
        };
        act(&mut self.offboard, &mut moment);
        self.heed_rates();
    }

    fn heed_rates(&mut self) {
        for (id, granted) in self.offboard.take_rates() {
            self.rates.on_rate_ended(id, granted);
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
