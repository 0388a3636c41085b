//! A tiny autopilot with a point mass: enough of PX4's habits to fly the model through its states.

use nalgebra::Vector3;
use skein_domain::exchange::{Event, OwnState};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    AutopilotCommand, Battery, FlightMode, LandedState, NodeTime, PositionNed, Refusal, RequestId, Setpoint,
};

/// Period of the control loop in seconds.
pub const PERIOD_S: f64 = 0.02;
/// Periods until a request is answered.
const LATENCY: u32 = 2;
/// Seconds without a setpoint after which OFFBOARD is lost.
const OFFBOARD_LOSS_S: f64 = 1.0;

/// How the autopilot answers a kind of request.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// Does it.
    Obeys,
    /// Refuses so many times, then does it.
    RefusesAtFirst(u32, Refusal),
    /// Always refuses.
    Refuses(Refusal),
    /// Says yes and does nothing.
    Ignores,
    /// Does not answer.
    Silent,
}

/// The autopilot and its vehicle.
#[derive(Debug, Clone)]
pub struct Autopilot {
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub yaw_rad: f64,
    pub mode: FlightMode,
    pub armed: bool,
    pub ready: Option<bool>,
    pub home: PositionNed,
    pub has_position: bool,
    /// What was heard last, of a vehicle that is not heard any more.
    pub last_heard: Option<VehicleKinematics>,
    pub link_connected: bool,
    pub arm: Answer,
    pub disarm: Answer,
    pub take_off: Answer,
    pub land: Answer,
    pub offboard: Answer,
    pub hold: Answer,
    pub events: Vec<Event>,
    /// Requests in the order they came.
    pub requests: Vec<AutopilotCommand>,
    pub pending: Vec<(u32, RequestId, AutopilotCommand)>,
    pub setpoint: Option<Setpoint>,
    pub silent_s: f64,
    pub take_off_to_m: f64,
    pub on_ground_s: f64,
    pub from_offboard: bool,
}

impl Default for Autopilot {
    fn default() -> Self {
        let place = PositionNed::new(10.0, -20.0, -1.5);
        Self {
            position: place.vector(),
            velocity: Vector3::zeros(),
            yaw_rad: 0.4,
            mode: FlightMode::Hold,
            armed: false,
            ready: Some(true),
            home: place,
            has_position: true,
            last_heard: None,
            link_connected: true,
            arm: Answer::Obeys,
            disarm: Answer::Obeys,
            take_off: Answer::Obeys,
            land: Answer::Obeys,
            offboard: Answer::Obeys,
            hold: Answer::Obeys,
            events: Vec::new(),
            requests: Vec::new(),
            pending: Vec::new(),
            setpoint: None,
            silent_s: 0.0,
            take_off_to_m: 0.0,
            on_ground_s: 0.0,
            from_offboard: false,
        }
    }
}

impl Autopilot {
    pub fn own_state(&self, now: NodeTime) -> OwnState {
        let kinematics = VehicleKinematics {
            position: self.position.into(),
            velocity: self.velocity.into(),
            yaw_rad: self.yaw_rad,
            measured: now,
        };
        OwnState {
            kinematics: self.has_position.then_some(self.last_heard.unwrap_or(kinematics)),
            mode: self.mode,
            armed: self.armed,
            landed: self.landed(),
            ready_to_arm: self.ready,
            home: Some(self.home),
            battery: Battery::default(),
            link_connected: self.link_connected,
            ..OwnState::default()
        }
    }

    pub fn height_m(&self) -> f64 {
        self.home.down_m - self.position.z
    }

    pub fn on_ground(&self) -> bool {
        self.height_m() < 0.05
    }

    fn landed(&self) -> LandedState {
        match (self.on_ground(), self.mode) {
            (true, _) => LandedState::OnGround,
            (false, FlightMode::TakeOff) => LandedState::TakingOff,
            (false, FlightMode::Land) => LandedState::Landing,
            (false, _) => LandedState::InAir,
        }
    }

    /// A pilot, or the failsafe, changes the mode.
    pub fn change_mode(&mut self, to: FlightMode, commanded: bool) {
        let from = std::mem::replace(&mut self.mode, to);
        if from != to {
            self.events.push(Event::ModeChanged { from, to, commanded });
        }
    }

    pub fn request(&mut self, request: RequestId, command: AutopilotCommand) {
        self.requests.push(command);
        self.pending.push((LATENCY, request, command));
    }

    pub fn stream(&mut self, setpoint: Setpoint) {
        self.setpoint = Some(setpoint);
        self.silent_s = 0.0;
    }

    pub fn stop_stream(&mut self) {
        self.setpoint = None;
    }

    /// One period.
    pub fn step(&mut self) {
        let due: Vec<_> = self
            .pending
            .extract_if(.., |p| {
                p.0 -= 1;
                p.0 == 0
            })
            .collect();
        for (_, request, command) in due {
            self.answer(request, command);
        }
        self.silent_s += PERIOD_S;
        if self.mode == FlightMode::Offboard && self.armed && self.silent_s > OFFBOARD_LOSS_S {
            self.change_mode(FlightMode::Return, false);
        }
        if self.armed {
            self.fly();
        } else {
            self.velocity = Vector3::zeros();
        }
    }

    fn answer(&mut self, request: RequestId, command: AutopilotCommand) {
        let how = match command {
            AutopilotCommand::Arm => &mut self.arm,
            AutopilotCommand::Disarm => &mut self.disarm,
            AutopilotCommand::TakeOff { .. } => &mut self.take_off,
            AutopilotCommand::Land => &mut self.land,
            AutopilotCommand::EnterOffboard => &mut self.offboard,
            AutopilotCommand::SetMode { mode: FlightMode::Hold } => &mut self.hold,
            AutopilotCommand::ReturnToLaunch | AutopilotCommand::SetMode { .. } | AutopilotCommand::EmergencyStop => {
                &mut Answer::Obeys
            }
        };
        let refusal = match how {
            Answer::Silent => return,
            Answer::Refuses(refusal) => Some(refusal.clone()),
            Answer::RefusesAtFirst(left, refusal) if *left > 0 => {
                *left -= 1;
                Some(refusal.clone())
            }
            Answer::Obeys | Answer::RefusesAtFirst(..) => {
                self.obey(command);
                None
            }
            Answer::Ignores => None,
        };
        self.events.push(Event::AutopilotResult { request, refusal });
    }

    fn obey(&mut self, command: AutopilotCommand) {
        match command {
            AutopilotCommand::Arm => self.armed = true,
            AutopilotCommand::Disarm | AutopilotCommand::EmergencyStop => self.armed = false,
            AutopilotCommand::TakeOff { height_m } => {
                self.take_off_to_m = height_m;
                self.change_mode(FlightMode::TakeOff, true);
            }
            AutopilotCommand::Land => {
                self.from_offboard = self.mode == FlightMode::Offboard;
                self.change_mode(FlightMode::Land, true);
            }
            AutopilotCommand::ReturnToLaunch => self.change_mode(FlightMode::Return, true),
            AutopilotCommand::SetMode { mode } => self.change_mode(mode, true),
            AutopilotCommand::EnterOffboard => self.change_mode(FlightMode::Offboard, true),
        }
    }

    fn fly(&mut self) {
        let wanted = match self.mode {
            FlightMode::TakeOff => {
                // It ends its climb a quarter of a metre below the asked height.
                if self.height_m() >= self.take_off_to_m - 0.25 {
                    self.change_mode(FlightMode::Hold, true);
                }
                Vector3::new(0.0, 0.0, -1.5)
            }
            FlightMode::Land => Vector3::new(0.0, 0.0, 0.7),
            FlightMode::Return => {
                let to_home = (self.home.vector() - self.position).xy();
                if to_home.norm() < 0.3 {
                    Vector3::new(0.0, 0.0, 0.7)
                } else {
                    let horizontal = to_home.normalize() * to_home.norm().min(3.0);
                    Vector3::new(horizontal.x, horizontal.y, 0.0)
                }
            }
            FlightMode::Offboard => self.setpoint.map_or(Vector3::zeros(), |setpoint| {
                let velocity = setpoint.velocity.map_or(Vector3::zeros(), |v| v.vector());
                let pull = setpoint
                    .position
                    .map_or(Vector3::zeros(), |p| (p.vector() - self.position) * 2.0);
                if let Some(yaw) = setpoint.yaw_rad {
                    self.yaw_rad = yaw;
                }
                velocity + pull.cap_magnitude(4.0)
            }),
            _ => Vector3::zeros(),
        };
        let change = (wanted - self.velocity).cap_magnitude(8.0 * PERIOD_S);
        self.velocity += change;
        self.position += self.velocity * PERIOD_S;
        if self.height_m() <= 0.0 && self.velocity.z >= 0.0 {
            self.position.z = self.home.down_m;
            self.velocity = Vector3::zeros();
        }
        self.disarm_on_ground();
    }

    fn disarm_on_ground(&mut self) {
        let landing = matches!(self.mode, FlightMode::Land | FlightMode::Return);
        self.on_ground_s = if self.on_ground() && landing {
            self.on_ground_s + PERIOD_S
        } else {
            0.0
        };
        if self.on_ground_s > 1.0 {
            self.armed = false;
            if std::mem::take(&mut self.from_offboard) {
                // As PX4 does: after a landing out of OFFBOARD the mode shows OFFBOARD again.
                self.change_mode(FlightMode::Offboard, false);
            }
        }
    }
}
