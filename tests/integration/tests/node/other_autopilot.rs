//! Another autopilot than PX4: a link that implements the port, and nothing else, is adopted, armed, flown to a place and landed. It is what
//! the page "Another autopilot" of the documentation describes.

use parking_lot::Mutex;
use skein_domain::link::{LinkEvent, MessageTap, RoutePoint, StreamState, VehicleLink};
use skein_domain::payload::MavlinkMessage;
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{
    AutopilotCommand, Battery, CommandId, FlightMode, FlightState, Geodetic, Gnss, GnssFix, HeardTimes, LandedState,
    LinkHealth, LocalFrame, LocalPositionNed, NodeTime, ParameterEvent, ParameterList, ParameterValue, PositionNed,
    ReadingAction, Refusal, RequestId, SystemId, Telemetry, VehicleCommand, VehicleId, VelocityNed,
};
use skein_runtime::Targets;
use skein_testkit::Swarm;
use skein_view::FleetSnapshot;
use std::sync::{Arc, Weak};
use std::time::Duration;

const HOME: Geodetic = Geodetic {
    latitude_deg: 47.39,
    longitude_deg: 8.54,
    altitude_amsl_m: 480.0,
};
/// The stream must have run for so long before the autopilot is asked to obey it, in seconds.
const LEAD_S: f64 = 0.5;
/// An expired setpoint is followed by a hold for so long, in seconds; then the stream ends on purpose.
const HOLD_FOR_S: f64 = 2.0;
const CLIMB_M_S: f64 = 2.0;

/// An autopilot that does at once what it is told, with the link to it. It goes on whenever it is read.
struct Copter(Mutex<State>);

#[derive(Default)]
struct State {
    now: NodeTime,
    position: LocalPositionNed,
    velocity: VelocityNed,
    yaw_rad: f64,
    mode: FlightMode,
    armed: bool,
    /// Height that an automatic take-off climbs to, in metres.
    climbs_to_m: f64,
    stream: Option<Stream>,
    /// Asked for, and granted when the stream has run for long enough.
    offboard: Option<RequestId>,
    events: Vec<LinkEvent>,
}

struct Stream {
    setpoint: LocalSetpoint,
    expires: NodeTime,
    since: NodeTime,
    state: StreamState,
}

impl State {
    fn set_mode(&mut self, to: FlightMode, commanded: bool) {
        let from = std::mem::replace(&mut self.mode, to);
        if from != to {
            self.events.push(LinkEvent::ModeChanged { from, to, commanded });
        }
    }

    fn set_armed(&mut self, armed: bool) {
        if std::mem::replace(&mut self.armed, armed) != armed {
            self.events.push(LinkEvent::ArmedChanged { armed });
        }
    }

    fn answer(&mut self, request: RequestId, outcome: Result<(), Refusal>) {
        self.events.push(LinkEvent::Result { request, outcome });
    }

    fn is_on_ground(&self) -> bool {
        self.position.down_m >= 0.0
    }

    /// The rules that every link holds: OFFBOARD only with the stream already running; an expired setpoint becomes a hold, and then the
    /// stream is given up.
    fn tend_stream(&mut self, now: NodeTime) {
        let Some(stream) = &mut self.stream else { return };
        let expired_s = now.seconds_since(stream.expires);
        let state = match expired_s {
            fresh if fresh <= 0.0 => StreamState::Fresh,
            holding if holding <= HOLD_FOR_S => StreamState::HoldingExpired,
            _ => StreamState::GivenUp,
        };
        let runs = now.seconds_since(stream.since) >= LEAD_S && state == StreamState::Fresh;
        if std::mem::replace(&mut stream.state, state) != state {
            self.events.push(LinkEvent::Stream(state));
        }
        if state == StreamState::GivenUp {
            self.stream = None;
            // its own failsafe
            self.set_mode(FlightMode::Hold, false);
        } else if runs && let Some(request) = self.offboard.take() {
            self.set_mode(FlightMode::Offboard, true);
            self.answer(request, Ok(()));
        }
    }

    fn wanted_velocity(&self, dt_s: f64) -> VelocityNed {
        match self.mode {
            FlightMode::TakeOff => VelocityNed::new(0.0, 0.0, -CLIMB_M_S),
            FlightMode::Land | FlightMode::Return => VelocityNed::new(0.0, 0.0, CLIMB_M_S),
            FlightMode::Offboard => match &self.stream {
                Some(stream) if stream.state == StreamState::Fresh => match stream.setpoint.position {
                    // straight there, within the period
                    Some(place) => ((place.vector() - self.position.vector()) / dt_s).into(),
                    None => stream.setpoint.velocity.unwrap_or_default(),
                },
                _ => VelocityNed::default(),
            },
            _ => VelocityNed::default(),
        }
    }

    fn go_on(&mut self, now: NodeTime) {
        let dt_s = now.seconds_since(self.now).clamp(0.0, 0.1);
        self.now = now;
        self.tend_stream(now);
        if !self.armed || dt_s == 0.0 {
            return;
        }
        self.velocity = self.wanted_velocity(dt_s);
        self.position = LocalPositionNed::from(self.position.vector() + self.velocity.vector() * dt_s);
        self.yaw_rad = self
            .stream
            .as_ref()
            .and_then(|s| s.setpoint.yaw_rad)
            .unwrap_or(self.yaw_rad);
        if self.mode == FlightMode::TakeOff && -self.position.down_m >= self.climbs_to_m {
            self.set_mode(FlightMode::Hold, true);
        }
        if matches!(self.mode, FlightMode::Land | FlightMode::Return) && self.is_on_ground() {
            (self.position.down_m, self.velocity) = (0.0, VelocityNed::default());
            self.set_armed(false);
        }
    }

    fn telemetry(&self, now: NodeTime) -> Telemetry {
        let frame = LocalFrame { origin: HOME };
        let place = frame.geodetic(&self.position);
        Telemetry {
            mode: self.mode,
            armed: self.armed,
            simulated: true,
            landed: if self.is_on_ground() {
                LandedState::OnGround
            } else {
                LandedState::InAir
            },
            ready_to_arm: Some(true),
            global: Some(place),
            local: Some(self.position),
            local_frame: Some(frame),
            velocity: Some(self.velocity),
            position_time: now,
            yaw_rad: self.yaw_rad as f32,
            home: Some(HOME),
            battery: Battery {
                remaining: Some(0.9),
                ..Battery::default()
            },
            gnss: Gnss {
                fix: GnssFix::ThreeD,
                satellites: 14,
                horizontal_accuracy_m: Some(0.5),
            },
            gnss_place: Some(place),
            gnss_healthy: Some(true),
            heard: HeardTimes {
                local: now,
                global: now,
                attitude: now,
                gnss: now,
                battery: now,
                system_status: now,
                ..HeardTimes::default()
            },
            ..Telemetry::default()
        }
    }
}

impl VehicleLink for Copter {
    fn system_id(&self) -> SystemId {
        SystemId(42)
    }

    fn read(&self, now: NodeTime) -> (Telemetry, LinkHealth) {
        let mut state = self.0.lock();
        state.go_on(now);
        let health = LinkHealth {
            connected: true,
            last_heard: now,
            round_trip_s: Some(0.01),
            clock_offset_s: Some(0.0),
            receive_rate_hz: 50.0,
            setpoint_rate_hz: if state.stream.is_some() { 50.0 } else { 0.0 },
            ..LinkHealth::default()
        };
        (state.telemetry(now), health)
    }

    fn take_events(&self) -> Vec<LinkEvent> {
        std::mem::take(&mut self.0.lock().events)
    }

    fn request(&self, _: NodeTime, request: RequestId, command: AutopilotCommand) {
        let mut state = self.0.lock();
        match command {
            AutopilotCommand::Arm => state.set_armed(true),
            AutopilotCommand::Disarm if !state.is_on_ground() => {
                let detail = "it is in the air".to_owned();
                return state.answer(request, Err(Refusal::NotPermitted { detail }));
            }
            AutopilotCommand::Disarm | AutopilotCommand::EmergencyStop => state.set_armed(false),
            AutopilotCommand::TakeOff { height_m } => {
                state.climbs_to_m = height_m;
                state.set_mode(FlightMode::TakeOff, true);
            }
            AutopilotCommand::Land => state.set_mode(FlightMode::Land, true),
            AutopilotCommand::ReturnToLaunch => state.set_mode(FlightMode::Return, true),
            AutopilotCommand::SetMode { mode } => state.set_mode(mode, true),
            // answered when the stream has run for long enough
            AutopilotCommand::EnterOffboard => return state.offboard = Some(request),
        }
        state.answer(request, Ok(()));
    }

    fn stop_motors(&self, _: NodeTime, request: RequestId) -> Result<(), Refusal> {
        let mut state = self.0.lock();
        state.stream = None;
        state.set_armed(false);
        state.answer(request, Ok(()));
        Ok(())
    }

    fn stream(&self, now: NodeTime, setpoint: LocalSetpoint, expires: NodeTime) {
        let mut state = self.0.lock();
        let (since, before) = state
            .stream
            .as_ref()
            .map_or((now, StreamState::Stopped), |s| (s.since, s.state));
        state.stream = Some(Stream {
            setpoint,
            expires,
            since,
            state: before,
        });
    }

    fn resume_stream(&self) {}

    fn stop_stream(&self, _: NodeTime) {
        self.0.lock().stream = None;
    }

    fn upload_route(&self, _: NodeTime, request: RequestId, _: &[RoutePoint]) {
        let detail = "it takes no routes".to_owned();
        self.0.lock().answer(request, Err(Refusal::NotPermitted { detail }));
    }

    fn tap(&self, _: Weak<dyn MessageTap>) {}

    fn send_payload(&self, _: NodeTime, _: &MavlinkMessage) -> Result<(), Refusal> {
        Err(no("payloads"))
    }

    fn parameters(&self, _: u64) -> Result<ParameterList, Refusal> {
        Err(no("parameters"))
    }

    fn read_parameters(&self, _: NodeTime, _: ReadingAction) -> Result<(), Refusal> {
        Err(no("parameters"))
    }

    fn write_parameter(&self, _: NodeTime, _: CommandId, _: &str, _: ParameterValue) {}

    fn take_parameter_events(&self) -> Vec<ParameterEvent> {
        Vec::new()
    }
}

fn no(what: &str) -> Refusal {
    Refusal::NotPermitted {
        detail: format!("there are no {what} over this link"),
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_link_of_another_autopilot_is_flown_as_any() {
    let swarm = Swarm::start(0).await;
    let node = swarm.node();
    node.offer_vehicle("copter", Arc::new(Copter(Mutex::default())))
        .expect("the fleet runs");
    let is = |state: FlightState| {
        move |fleet: &FleetSnapshot| fleet.vehicles.first().is_some_and(|v| v.flight_state == state)
    };
    let known = |fleet: &FleetSnapshot| fleet.vehicles.first().is_some_and(|v| v.kinematics.is_some());
    swarm
        .until("it is adopted, and where it is", Duration::ZERO, known)
        .await;
    let one = Targets::Vehicles(vec![VehicleId(42)]);
    let commanded = async |command| {
        let receipts = node.command(&one, command).await;
        assert!(receipts.iter().all(|receipt| receipt.refusal.is_none()), "{receipts:?}");
    };
    commanded(VehicleCommand::TakeOff { height_m: 8.0 }).await;
    swarm
        .until("it holds", Duration::from_secs(20), is(FlightState::Holding))
        .await;
    let goal = PositionNed::new(12.0, -5.0, -8.0);
    commanded(VehicleCommand::GoTo {
        position: goal,
        yaw_rad: None,
        speed_m_s: None,
    })
    .await;
    let there = |fleet: &FleetSnapshot| {
        let vehicle = &fleet.vehicles[0];
        let place = vehicle.kinematics.map(|k| k.position);
        vehicle.flight_state == FlightState::Holding && place.is_some_and(|at| at.distance_m(&goal) < 1.0)
    };
    let fleet = swarm.until("it is there", Duration::from_secs(30), there).await;
    assert_eq!(fleet.vehicles[0].mode, FlightMode::Offboard);
    commanded(VehicleCommand::Land).await;
    swarm
        .until("it has landed", Duration::from_secs(30), |fleet| {
            !fleet.vehicles[0].armed
        })
        .await;
    swarm.stop().await;
}
