//! One simulated PX4 vehicle without sockets or clock: datagrams, topics and time steps in, frames and topics out. The same seed and the same
//! inputs give the same flight.
//!
//! Must never do: I/O, read a clock, draw randomness from anywhere but its seed.

mod battery;
mod body;
mod channel;
mod commander;
mod commands;
mod estimator;
mod faults;
mod gnss;
mod guidance;
mod lift;
mod limits;
mod logs;
mod mission;
mod mode;
mod navigation;
mod offboard;
mod parameters;
mod payloads;
pub mod plant;
mod position_control;
mod receive;
mod telemetry;
mod topics;
mod truth;

pub use crate::parameter_value::ParameterValue;
pub use channel::{LinkKind, Outbox};

use crate::airframe::Airframe;
use crate::faces::Face;
use crate::settings::SimSettings;
use crate::wire::{CommandRequest, Sender};
use battery::{Battery, BatteryLevel};
use body::{Body, Drive, GRAVITY_M_S2};
use channel::Channel;
use commander::{Asker, Commander, Notice, Situation};
use estimator::Estimator;
use faults::Faults;
use guidance::Guidance;
use lift::{Lift, LiftInput, Stage};
use limits::{Limits, limits_from};
use mavlink::dialects::common::MavSeverity;
use mission::Mission;
use nalgebra::Vector3;
use offboard::OffboardInput;
use parameters::Parameters;
use payloads::Payloads;
use position_control::{PositionControl, Target};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skein_domain::{FlightMode, Geodetic, LandedState, LocalFrame, PositionNed, SwarmFrame};
use skein_sim_payloads::wander::Wander;
use std::collections::VecDeque;
use topics::Topics;

/// After its start a vehicle knows its origin, its global position and its home after these times in seconds.
const ORIGIN_KNOWN_S: f64 = 0.2;
const GLOBAL_KNOWN_S: f64 = 1.1;
const HOME_KNOWN_S: f64 = 2.0;
/// A reboot that was asked for happens this much later, in seconds.
const REBOOT_DELAY_S: f64 = 0.5;

/// What distinguishes one vehicle from the others of a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VehicleIdentity {
    /// MAVLink system id.
    pub system_id: u8,
    /// Where it stands about the simulation's origin; the ground there is at its height.
    pub position: PositionNed,
    /// Yaw in radians.
    pub yaw_rad: f64,
    /// Distinguishes vehicles that are otherwise equal; part of the seed.
    pub number: u64,
    /// Whether it has a ground-station link beside the onboard one.
    pub ground_link: bool,
    /// Simulation time at which it is switched on, in seconds.
    pub started_s: f64,
    /// What kind of vehicle it is.
    pub airframe: Airframe,
    /// Charge of its battery, 0..=1; that of the settings if left out.
    pub battery: Option<f64>,
    /// Universal time at simulation time zero, in microseconds since 1970.
    pub utc_at_zero_us: u64,
}

/// Where a command came from.
#[derive(Debug, Clone, Copy)]
enum Source {
    Link(LinkKind, Sender),
    Topics { system: u8, component: u16 },
}

/// A command on its way through the autopilot.
#[derive(Debug, Clone, Copy)]
struct PendingCommand {
    due_s: f64,
    source: Source,
    request: CommandRequest,
}

/// One vehicle.
#[derive(Debug, Clone)]
pub struct SimVehicle {
    identity: VehicleIdentity,
    settings: SimSettings,
    swarm: SwarmFrame,
    start: LocalFrame,
    time_s: f64,
    booted_s: f64,
    reboot_at_s: Option<f64>,
    stalled_s: f64,
    body: Body,
    estimator: Estimator,
    gusts: Wander,
    control: PositionControl,
    guidance: Guidance,
    offboard: OffboardInput,
    commander: Commander,
    lift: Lift,
    battery: Battery,
    parameters: Parameters,
    limits: Limits,
    channels: Vec<Channel>,
    topics: Option<Topics>,
    pending: VecDeque<PendingCommand>,
    notices: Vec<Notice>,
    home: Option<Vector3<f64>>,
    origin_told: bool,
    parameters_told: bool,
    mode_entered: FlightMode,
    yaw_hold_rad: f64,
    target: Target,
    force: Vector3<f64>,
    payloads: Payloads,
    faults: Faults,
    mission: Mission,
    /// Wind as the estimator has it, in metres per second.
    wind_seen: Vector3<f64>,
    rng: ChaCha8Rng,
}

impl SimVehicle {
    /// Switches a vehicle on where it stands.
    #[must_use]
    pub fn new(identity: VehicleIdentity, settings: &SimSettings) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        rng.set_stream(identity.number + 1);
        let swarm = SwarmFrame::new(settings.origin);
        let start = LocalFrame {
            origin: swarm.geodetic(&identity.position),
        };
        let body = Body::new(identity.airframe.response(), identity.yaw_rad);
        let estimator = Estimator::new(&settings.noise, settings.second_gnss, &body, &mut rng);
        let gust = 0.3 * settings.wind.gust_m_s;
        let gusts = Wander::new(
            Vector3::new(gust, gust, 0.2 * gust),
            settings.wind.gust_time_s,
            &mut rng,
        );
        let parameters = Parameters::new(identity.system_id, identity.airframe, &settings.parameters);
        let mut vehicle = Self {
            swarm,
            start,
            time_s: identity.started_s,
            booted_s: identity.started_s,
            reboot_at_s: None,
            stalled_s: 0.0,
            gusts,
            control: PositionControl::new(),
            guidance: Guidance::new(&estimator.now),
            offboard: OffboardInput::new(),
            commander: Commander::new(0.0),
            lift: Lift::new(),
            battery: Battery::new(&settings.battery),
            limits: limits_from(&parameters),
            parameters,
            channels: Vec::new(),
            topics: None,
            pending: VecDeque::new(),
            notices: Vec::new(),
            home: None,
            origin_told: false,
            parameters_told: false,
            mode_entered: FlightMode::Unknown,
            yaw_hold_rad: body.yaw_rad,
            target: Target::NONE,
            force: Vector3::zeros(),
            payloads: Payloads::new(&settings.payloads, settings.seed, identity.number, &identity.position),
            faults: Faults::default(),
            mission: Mission::default(),
            wind_seen: Vector3::zeros(),
            rng,
            body,
            estimator,
            identity,
            settings: settings.clone(),
        };
        if let Some(charge) = identity.battery {
            vehicle.battery.set_charge(charge);
        }
        vehicle.commander = Commander::new(vehicle.draw_ready_s());
        vehicle.open_channels();
        vehicle
    }

    /// Its system id.
    #[must_use]
    pub fn system_id(&self) -> u8 {
        self.identity.system_id
    }

    /// What distinguishes it from all others of its simulation.
    #[must_use]
    pub fn number(&self) -> u64 {
        self.identity.number
    }

    fn draw_ready_s(&mut self) -> f64 {
        use rand::RngExt;
        self.booted_s + self.settings.ready_after_s + self.rng.random_range(-0.15..0.15)
    }

    fn open_channels(&mut self) {
        use rand::RngExt;
        let (now_us, of_payloads) = (self.time_us(), payloads::streams(&self.settings.payloads));
        let mut channel = |kind| {
            let phase = self.rng.random_range(0.0..1.0);
            Channel::new(kind, self.identity.system_id, phase, now_us, &of_payloads)
        };
        // Drawn without MAVLink too: how it is reached makes no other flight.
        let mut channels = vec![channel(LinkKind::Onboard)];
        if self.identity.ground_link {
            channels.push(channel(LinkKind::GroundStation));
        }
        let faces = self.settings.faces;
        if !faces.has(Face::Mavlink) {
            channels.clear();
        }
        self.channels = channels;
        self.topics = faces.has(Face::Dds).then(|| Topics::new(self.identity.number, now_us));
    }

    /// The autopilot starts anew, wherever the vehicle is: a new local origin, default rates, disarmed.
    pub fn reboot(&mut self) {
        self.booted_s = self.time_s;
        self.faults.clock_step_s = 0.0;
        self.wind_seen = Vector3::zeros();
        self.reboot_at_s = None;
        self.estimator.restart(&self.body);
        self.control.reset();
        self.guidance = Guidance::new(&self.estimator.now);
        self.offboard.restart();
        self.lift = Lift::new();
        self.mission.restart();
        self.pending.clear();
        self.notices.clear();
        self.home = None;
        self.origin_told = false;
        self.parameters_told = false;
        self.mode_entered = FlightMode::Unknown;
        if let Some(gimbal) = &mut self.payloads.gimbal {
            gimbal.restart_manager();
        }
        let ready_s = self.draw_ready_s();
        self.commander.restart(self.time_s, ready_s);
        self.open_channels();
    }

    /// The pilot switches to a mode by radio control, which from then on counts as present.
    pub fn pilot_mode(&mut self, mode: FlightMode) {
        self.commander.rc = true;
        let _ = self.commander.request(mode, Asker::Pilot, self.time_s);
    }

    /// Tells it for how long in all the machine has not let the simulation run until now, in seconds, so that gaps can be told apart.
    pub fn note_stalls(&mut self, stalled_s: f64) {
        self.stalled_s = stalled_s;
    }

    /// From now on [`crate::VehicleTruth::offboard_gap_recent_s`] counts anew.
    pub fn forget_recent_gap(&mut self) {
        self.offboard.forget_recent_gap();
    }

    /// Lets `dt_s` pass in the given wind (metres per second along north, east, down); frames and topics to be
    /// sent are added to `out`.
    pub fn step(&mut self, dt_s: f64, wind_m_s: &Vector3<f64>, out: &mut Outbox) {
        self.time_s += dt_s;
        let (before, published_before) = (out.mark(), out.published.len());
        if self.reboot_at_s.is_some_and(|at| self.time_s >= at) {
            self.reboot();
        }
        self.run_commands(out);
        self.decide();
        self.step_mission(out);
        self.steer(dt_s);
        let wind = wind_m_s + self.gusts.step(dt_s, &mut self.rng);
        let drive = self.drive();
        self.body.step(&drive, &wind, dt_s);
        self.estimator.step(&self.body, dt_s, &mut self.rng);
        self.see_wind(&wind, dt_s);
        self.watch_battery(dt_s);
        self.watch_home();
        self.step_payloads(dt_s);
        self.report(out);
        self.publish_topics(out);
        if self.faults.silent || self.faults.mavlink_cut {
            out.back_to(before);
        }
        if self.faults.silent || self.faults.topics_cut {
            out.published.truncate(published_before);
        }
    }

    /// The estimator learns the wind from the drag, slowly and in flight only.
    fn see_wind(&mut self, wind: &Vector3<f64>, dt_s: f64) {
        const LEARNING_S: f64 = 8.0;
        if !self.lift.is_landed() {
            let level = Vector3::new(wind.x, wind.y, 0.0);
            self.wind_seen += (level - self.wind_seen) * (dt_s / (LEARNING_S + dt_s));
        }
    }

    /// Modes, failsafes, take-off and landing.
    fn decide(&mut self) {
        self.commander.step(&Situation {
            now_s: self.time_s,
            setpoint_age_s: self.offboard.age_s(self.time_s),
            setpoint_timeout_s: self.limits.setpoint_timeout_s,
            loss_action: self.limits.loss_action,
            position_valid: self.estimator.satellites.is_valid(),
        });
        self.enter_mode();
        let was_armed = self.commander.is_armed();
        let mode = self.commander.mode();
        let in_air = matches!(self.lift.stage(), Stage::Flying { .. });
        if mode == FlightMode::TakeOff && in_air && self.guidance.take_off_done(&self.estimator.now) {
            let _ = self.commander.request(FlightMode::Hold, Asker::TakeOffEnd, self.time_s);
            self.enter_mode();
        }
        let input = LiftInput {
            now_s: self.time_s,
            on_ground: self.body.on_ground,
            wants_up: self.wants_up(),
            wants_down: self.guidance.is_landing() || self.control.velocity_target.z > 0.25,
            spool_up_s: self.limits.spool_up_s,
            disarm_after_landing_s: self.limits.disarm_after_landing_s,
            disarm_idle_s: self.limits.disarm_idle_s,
        };
        if self.lift.step(&input, &mut self.commander) {
            self.control.reset();
            self.guidance.lift_off(&self.estimator.now);
        }
        if was_armed && !self.commander.is_armed() {
            self.home = Some(self.estimator.now.position);
            self.enter_mode();
        }
        if self.commander.is_armed() && self.commander.mode() == FlightMode::Offboard {
            self.offboard.count_gap(self.time_s, self.stalled_s);
        }
        self.notices.append(&mut self.commander.take_notices());
    }

    /// Starts the guidance of a mode that has just been entered.
    fn enter_mode(&mut self) {
        let mode = self.commander.mode();
        if mode == self.mode_entered {
            return;
        }
        self.mode_entered = mode;
        if mode == FlightMode::TakeOff && self.guidance.take_off_down_m().is_none() {
            let home = self.home_or_here();
            self.guidance.set_take_off(home.z - self.limits.take_off_height_m);
        }
        let home = self.home_or_here();
        self.guidance
            .enter(mode, &self.estimator.now, &home, &self.limits.guidance);
        if mode == FlightMode::Return && !self.lift.is_landed() {
            let above = self.limits.guidance.return_height_m;
            let amsl = self.geodetic_of(&home).altitude_amsl_m + above;
            let text = format!("RTL: start return at {amsl:.0} m ({above:.0} m above destination)");
            self.commander.say(MavSeverity::MAV_SEVERITY_INFO, text);
        }
        if mode == FlightMode::Land && self.commander.is_armed() {
            self.commander
                .say(MavSeverity::MAV_SEVERITY_INFO, "Landing at current position");
        }
    }

    fn home_or_here(&self) -> Vector3<f64> {
        self.home.unwrap_or(self.estimator.now.position)
    }

    fn wants_up(&self) -> bool {
        let now = &self.estimator.now;
        match self.commander.mode() {
            FlightMode::TakeOff => self
                .guidance
                .take_off_down_m()
                .is_some_and(|down_m| down_m < now.position.z - 0.3),
            FlightMode::Offboard => self.offboard.leads_up(now),
            _ => false,
        }
    }

    /// Makes the thrust vector.
    fn steer(&mut self, dt_s: f64) {
        match self.lift.stage() {
            Stage::Off | Stage::Idle { .. } => {
                self.force = Vector3::zeros();
                self.target = Target::NONE;
                self.yaw_hold_rad = self.body.yaw_rad;
                self.control.reset();
            }
            Stage::RunUp { since_s } => {
                // Not yet enough to lift off.
                let share = ((self.time_s - since_s) / 3.0).clamp(0.0, 0.95);
                self.force = Vector3::new(0.0, 0.0, -GRAVITY_M_S2 * share);
            }
            Stage::Flying { .. } => {
                if self.commander.mode() == FlightMode::Termination {
                    self.force = Vector3::zeros();
                    return;
                }
                let target = self.make_target(dt_s);
                self.target = self.stuck(target);
                let mut limits = self.limits.control;
                limits.up_m_s = self.lift.climb_limit_m_s(self.time_s, limits.up_m_s);
                self.force = self.control.step(&self.estimator.now, &self.target, &limits, dt_s);
            }
        }
    }

    fn make_target(&mut self, dt_s: f64) -> Target {
        let mut target = if self.commander.mode() == FlightMode::Offboard {
            self.offboard.target
        } else {
            let climb = self.limits.guidance.take_off_m_s;
            let climb = self.lift.climb_limit_m_s(self.time_s, climb);
            let home = self.home_or_here();
            self.guidance
                .step(&self.estimator.now, &home, &self.limits.guidance, climb, dt_s)
        };
        if target.yaw_rad.is_finite() {
            self.yaw_hold_rad = target.yaw_rad;
        } else if target.yaw_rate_rad_s.is_finite() {
            self.yaw_hold_rad = self.body.yaw_rad;
        }
        if !target.yaw_rate_rad_s.is_finite() {
            target.yaw_rate_rad_s = 0.0;
        }
        target
    }

    fn drive(&self) -> Drive {
        if self.force.z == 0.0 {
            return Drive::off(self.body.yaw_rad);
        }
        let offboard = self.commander.mode() == FlightMode::Offboard;
        Drive {
            force: self.force,
            yaw_rad: self.yaw_hold_rad,
            yaw_rate_rad_s: if self.target.yaw_rate_rad_s.is_finite() {
                self.target.yaw_rate_rad_s
            } else {
                0.0
            },
            yaw_rate_max_rad_s: if offboard {
                200_f64.to_radians()
            } else {
                self.limits.yaw_auto_rad_s
            },
        }
    }

    fn watch_battery(&mut self, dt_s: f64) {
        let text = match self.battery.step(self.commander.is_armed(), dt_s) {
            Some(BatteryLevel::Low) => "Low battery level",
            Some(BatteryLevel::Critical) => "Critical battery level",
            Some(BatteryLevel::Emergency) => "Emergency battery level",
            Some(BatteryLevel::Good) | None => return,
        };
        self.notices.push(Notice {
            severity: MavSeverity::MAV_SEVERITY_CRITICAL,
            text: text.to_owned(),
        });
    }

    fn watch_home(&mut self) {
        if self.home.is_none() && self.up_time_s() >= HOME_KNOWN_S {
            self.home = Some(self.estimator.now.position);
        }
    }

    /// Sends what is due.
    fn report(&mut self, out: &mut Outbox) {
        let mut channels = std::mem::take(&mut self.channels);
        let now_us = self.time_us();
        for channel in &mut channels {
            channel.due(now_us, |channel, stream| {
                self.send_of(channel, stream, 0, out);
            });
            self.send_parameter_list(channel, out);
            self.send_log(channel, out);
        }
        self.report_pictures(&mut channels, out);
        if !self.origin_told && self.up_time_s() >= 1.0 {
            self.origin_told = true;
            channels.iter_mut().for_each(|channel| {
                self.send_message(channel, 49, out);
            });
        }
        if !self.parameters_told && self.up_time_s() >= 0.5 {
            self.parameters_told = true;
            for channel in &mut channels {
                self.parameters
                    .announced()
                    .for_each(|index| self.send_parameter(channel, index, out));
            }
        }
        for notice in self.notices.drain(..) {
            channels
                .iter_mut()
                .filter(|channel| channel.has_ground_station(self.time_s))
                .for_each(|channel| telemetry::send_text(channel, &notice, out));
        }
        self.channels = channels;
    }

    fn time_us(&self) -> u64 {
        (self.time_s * 1e6) as u64
    }

    /// Seconds since the autopilot was started.
    fn up_time_s(&self) -> f64 {
        self.time_s - self.booted_s
    }

    /// The same as the autopilot's own clock has it.
    fn clock_s(&self) -> f64 {
        (self.up_time_s() + self.faults.clock_step_s).max(0.0)
    }

    /// The frame the vehicle itself uses: about its estimator's origin.
    fn own_frame(&self) -> LocalFrame {
        LocalFrame {
            origin: self.start.geodetic(&self.estimator.origin().into()),
        }
    }

    /// A position in the vehicle's own frame as a place on Earth.
    fn geodetic_of(&self, own: &Vector3<f64>) -> Geodetic {
        self.start.geodetic(&(own + self.estimator.origin()).into())
    }

    fn landed_state(&self) -> LandedState {
        if self.lift.is_landed() {
            return LandedState::OnGround;
        }
        match self.commander.mode() {
            FlightMode::TakeOff => LandedState::TakingOff,
            FlightMode::Land => LandedState::Landing,
            _ => LandedState::InAir,
        }
    }
}

#[cfg(test)]
mod tests;
