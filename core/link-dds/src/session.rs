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
use skein_domain::{AutopilotCommand, LinkHealth, NodeTime, Refusal, RequestId, Telemetry, VehicleId};
use skein_px4::LinkSettings;
use skein_px4::SendRate;
use skein_px4::acknowledgement::Acknowledgement;
use skein_px4::commands::CommandOutlet;
use skein_px4::local_origin::LocalOrigin;
use skein_px4::offboard::{Moment, OffboardControl, Wire};
use skein_px4::plan::{Command, Situation};
use skein_px4::setpoints::HoldPlace;
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
    clock: WireClock,
    origin: LocalOrigin,
    /// PX4 tells no texts over these topics: there are none in it.
    offboard: OffboardControl,
    estimate: Estimate,
    status: Option<Status>,
    received: SendRate,
    connected: bool,
    silence: Silence,
    refuse_all: Option<Refusal>,
    /// Another autopilot speaks in its namespace: what is sent reaches both.
    duplicate: bool,
}

/// Commands and setpoints on their way into the outbox.
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

impl Wire for ToOutbox<'_> {
    fn setpoint(&mut self, setpoint: &LocalSetpoint) {
        self.outbox.push(setpoint::setpoint(setpoint, self.stamp_us));
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
            clock: WireClock::default(),
            origin: LocalOrigin::default(),
            offboard: OffboardControl::default(),
            estimate: Estimate::default(),
            status: None,
            received: SendRate::default(),
            connected: true,
            silence: Silence::new(now),
            refuse_all: None,
            duplicate: false,
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
        self.offboard.events.take()
    }

    /// Tells the vehicle's actor something that has no event of its own.
    pub fn notice(&mut self, severity: u8, text: String) {
        self.offboard.events.push(LinkEvent::StatusText { severity, text });
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
        self.offboard.stream_state()
    }

    /// Takes in a sample that has passed the check.
    pub fn on_sample(&mut self, now: NodeTime, sample: &Sample) {
        self.silence.heard(now);
        self.received.on_sent(now);
        if !self.connected {
            self.connected = true;
            self.offboard.events.push(LinkEvent::Regained);
        }
        match sample {
            Sample::Local(local) => {
                match self.clock.on_stamp(now, local.stamp_us) {
                    Tick::Steady => {}
                    Tick::Jumped { by_s } => self.offboard.events.push(LinkEvent::ClockJumped { by_s }),
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
                    self.control(now, OffboardControl::poll_commands);
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
        self.control(now, |offboard, moment| offboard.on_ack(moment, &ack));
    }

    fn on_status(&mut self, now: NodeTime, status: Status) {
        let armed_before = self.status.replace(status).map(|before| before.armed());
        self.estimate.on_status(now, &status);
        let round_trip_s = self.clock.round_trip_s().unwrap_or(0.0);
        self.control(now, |offboard, moment| {
            offboard.on_state(moment, armed_before, round_trip_s)
        });
    }

    /// The autopilot restarted: it has forgotten its frame and every command; so must we.
    pub fn on_reboot(&mut self, now: NodeTime) {
        self.offboard.events.push(LinkEvent::Rebooted);
        self.origin.restart();
        self.clock = WireClock::default();
        self.estimate.restart();
        let refusal = Refusal::Autopilot {
            result: "rebooted".to_owned(),
            text: String::new(),
        };
        self.offboard.end_commands(&refusal);
        // Its frame may be another now: no old position must reach it.
        self.stop_stream(now);
    }

    /// Does what has become due; gives when to come again.
    pub fn on_tick(&mut self, now: NodeTime) -> NodeTime {
        self.control(now, OffboardControl::poll_emergency);
        self.check_lost(now);
        self.control(now, OffboardControl::poll);
        let lost = self.silence.since().plus_seconds(self.settings.lost_after_s);
        let due = [self.offboard.due(&self.settings), Some(lost).filter(|_| self.connected)];
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
        self.offboard.events.push(LinkEvent::Lost);
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
        let refusal = self.refusal(now, command.brings_to_rest());
        self.control(now, |offboard, moment| {
            offboard.request(moment, request, command, refusal)
        });
    }

    /// A route, or anything else that this interface of PX4 does not have.
    pub fn not_supported(&mut self, request: RequestId, what: &str) {
        let refusal = Refusal::not_supported(format!("{what} over DDS: PX4 has no topic for it"));
        self.offboard.answer(request, Err(refusal));
    }

    /// Takes a setpoint that is valid until `expires`, and sends it.
    pub fn stream(&mut self, now: NodeTime, setpoint: LocalSetpoint, expires: NodeTime) {
        // One that runs goes on: without it the vehicle that it flies is left to its failsafe.
        if self.refuse_all.is_some() || (self.duplicate && !self.offboard.is_streaming()) {
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

    /// Refuses everything from now on: its topics are another vehicle's.
    pub fn refuse_all(&mut self, now: NodeTime, refusal: Refusal) {
        self.end(now, &refusal);
        self.refuse_all = Some(refusal);
    }

    fn end(&mut self, now: NodeTime, refusal: &Refusal) {
        self.control(now, |offboard, moment| offboard.give_up(moment, refusal));
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
            setpoint_rate_hz: self.offboard.setpoint_rate_hz(now),
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
            self.offboard.answer(request, Err(refusal.clone()));
            return Err(refusal);
        }
        self.control(now, |offboard, moment| offboard.stop_motors(moment, request));
        Ok(())
    }

    /// Lets what controls it act on what is known of it now.
    fn control(&mut self, now: NodeTime, act: impl FnOnce(&mut OffboardControl, &mut Moment<'_>)) {
        let telemetry = self.estimate.telemetry();
        let is_fresh = |heard: NodeTime| now.seconds_since(heard) <= FRESH_POSITION_S;
        let mut moment = Moment {
            now,
            settings: &self.settings,
            situation: Situation {
                mode: telemetry.mode,
                armed: telemetry.armed,
                landed: telemetry.landed,
                streaming: false,
                place: telemetry.global.filter(|_| is_fresh(telemetry.heard.global)),
                home: telemetry.home,
            },
            hold: HoldPlace {
                position: telemetry.local.filter(|_| is_fresh(telemetry.heard.local)),
                yaw_rad: self.estimate.yaw_rad(),
            },
            wire: &mut ToOutbox {
                stamp_us: self.clock.stamp_us(now),
                target_system: self.system_id,
                sender: Sender {
                    system_id: self.settings.own_system_id,
                    component_id: self.settings.own_component_id,
                },
                outbox: &mut self.outbox,
            },
        };
        act(&mut self.offboard, &mut moment);
    }
}

#[cfg(test)]
mod tests;
