//! One link core and one simulated vehicle with a line between them, in simulated time: as fast as it computes, and the same
//! every time.

use nalgebra::Vector3;
use skein_domain::link::{LinkEvent, RoutePoint, StreamState};
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{
    AutopilotCommand, FlightMode, LinkHealth, LocalPositionNed, NodeTime, Refusal, RequestId, Telemetry, VelocityNed,
};
use skein_link_mavlink::EndpointCounters;
use skein_link_mavlink::decode::{decode, heartbeat};
use skein_link_mavlink::frame::each_in_datagram;
use skein_link_mavlink::vehicle::{AUTOPILOT_COMPONENT, VehicleCore};
use skein_px4::LinkSettings;
use skein_sim::vehicle::{LinkKind, Outbox, SimVehicle, VehicleIdentity};
use skein_sim::{NoiseSettings, SimSettings, VehicleTruth, WindSettings};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

const STEP_S: f64 = 0.004;
/// Period of the vehicle actor.
const PERIOD_S: f64 = 0.02;

/// What the vehicle actor would be streaming.
pub type Steering = Box<dyn Fn(f64) -> LocalSetpoint>;

/// Whether a datagram is let through, by its running number.
pub type Filter = Box<dyn FnMut(u32, &[u8]) -> bool>;

pub struct Rig {
    pub core: Option<VehicleCore>,
    pub vehicle: SimVehicle,
    pub now_s: f64,
    /// Node time runs from here, the vehicle's from its boot: the clocks differ.
    pub events: Vec<(f64, LinkEvent)>,
    /// Frames per message id since last cleared.
    pub received: BTreeMap<u32, u32>,
    /// Messages sent by the link: time, id.
    pub sent: Vec<(f64, u32, Vec<u8>)>,
    /// Towards the vehicle, and from it.
    pub passes_up: Filter,
    pub passes_down: Filter,
    pub delay_s: f64,
    pub steering: Option<Steering>,
    /// Wind in metres per second.
    pub wind: Vector3<f64>,
    /// Messages that payloads want.
    pub wanted: Vec<u32>,
    settings: Arc<LinkSettings>,
    up: VecDeque<(f64, Vec<u8>)>,
    down: VecDeque<(f64, Vec<u8>)>,
    counts: (u32, u32),
    due_s: f64,
    next_period_s: f64,
    next_request: u32,
}

impl Rig {
    pub fn new() -> Self {
        Self::with(LinkSettings::default(), SimSettings::default())
    }

    pub fn with(settings: LinkSettings, sim: SimSettings) -> Self {
        let sim = SimSettings {
            noise: NoiseSettings::NONE,
            wind: WindSettings::CALM,
            ..sim
        };
        let identity = VehicleIdentity {
            system_id: 1,
            position: skein_domain::PositionNed::new(20.0, -30.0, 0.0),
            yaw_rad: 0.7,
            number: 0,
            ground_link: false,
            started_s: 0.0,
            airframe: skein_sim::Airframe::default(),
            battery: None,
            utc_at_zero_us: 0,
        };
        Self {
            core: None,
            vehicle: SimVehicle::new(identity, &sim),
            now_s: 50.0,
            events: Vec::new(),
            received: BTreeMap::new(),
            sent: Vec::new(),
            passes_up: Box::new(|_, _| true),
            passes_down: Box::new(|_, _| true),
            delay_s: 0.002,
            steering: None,
            wind: Vector3::zeros(),
            wanted: Vec::new(),
            settings: Arc::new(settings),
            up: VecDeque::new(),
            down: VecDeque::new(),
            counts: (0, 0),
            due_s: 0.0,
            next_period_s: 0.0,
            next_request: 0,
        }
    }

    pub fn now(&self) -> NodeTime {
        NodeTime::from_seconds(self.now_s)
    }

    pub fn core(&mut self) -> &mut VehicleCore {
        self.core.as_mut().expect("the vehicle has been heard")
    }

    pub fn read(&mut self) -> (Telemetry, LinkHealth) {
        let now = self.now();
        self.core().read(now)
    }

    pub fn truth(&self) -> VehicleTruth {
        self.vehicle.truth()
    }

    /// Lets time pass.
    pub fn run(&mut self, seconds: f64) {
        let end_s = self.now_s + seconds;
        while self.now_s < end_s {
            self.step();
        }
    }

    /// Lets time pass until something is the case; panics after `limit_s`.
    #[track_caller]
    pub fn run_until(&mut self, what: &str, limit_s: f64, mut met: impl FnMut(&mut Self) -> bool) {
        let end_s = self.now_s + limit_s;
        while !met(self) {
            assert!(
                self.now_s < end_s,
                "{what}: not within {limit_s} s; {:?} {:?}",
                self.truth(),
                self.events
            );
            self.step();
        }
    }

    fn step(&mut self) {
        self.now_s += STEP_S;
        let mut out = Outbox::default();
        while self.up.front().is_some_and(|(at, _)| *at <= self.now_s) {
            let (_, bytes) = self.up.pop_front().unwrap();
            self.vehicle.receive(LinkKind::Onboard, &bytes, &mut out);
        }
        self.vehicle.step(STEP_S, &self.wind.clone(), &mut out);
        for (_, frame) in out.frames() {
            self.counts.1 += 1;
            if (self.passes_down)(self.counts.1, frame) {
                self.down.push_back((self.now_s + self.delay_s, frame.to_vec()));
            }
        }
        let now = self.now();
        while self.down.front().is_some_and(|(at, _)| *at <= self.now_s) {
            let (_, bytes) = self.down.pop_front().unwrap();
            self.receive(now, &bytes);
        }
        self.act(now);
    }

    fn receive(&mut self, now: NodeTime, bytes: &[u8]) {
        let (core, settings, received) = (&mut self.core, &self.settings, &mut self.received);
        let wanted = &self.wanted;
        each_in_datagram(bytes, &mut EndpointCounters::default(), |_, frame| {
            *received.entry(frame.header.message_id).or_default() += 1;
            if core.is_none() {
                let by_autopilot = frame.header.component_id == AUTOPILOT_COMPONENT;
                let Some(first) = heartbeat(frame).filter(|_| by_autopilot) else {
                    return;
                };
                *core = Some(VehicleCore::new(Arc::clone(settings), 1, &first, now));
            }
            let Some(core) = core else { return };
            let read = decode(frame)
                .filter(|_| frame.header.component_id == AUTOPILOT_COMPONENT)
                .map(|read| read.unwrap());
            if wanted.contains(&frame.header.message_id) {
                core.on_wanted_frame(now, &frame.header, read);
            } else {
                core.on_frame(now, &frame.header, read);
            }
        });
    }

    fn act(&mut self, now: NodeTime) {
        let Some(core) = &mut self.core else { return };
        if self.now_s >= self.next_period_s {
            self.next_period_s = self.now_s + PERIOD_S - 0.5 * STEP_S;
            if let Some(steering) = &self.steering {
                core.stream(now, steering(self.now_s), now.plus_seconds(0.2));
            }
        }
        if self.now_s >= self.due_s {
            self.due_s = core.on_tick(now).as_seconds().max(self.now_s + 0.01);
        }
        self.flush();
    }

    /// Takes what the link has to say after it was asked for something.
    pub fn flush(&mut self) {
        let (now_s, now) = (self.now_s, self.now());
        let Some(core) = &mut self.core else { return };
        self.events
            .extend(core.take_events().into_iter().map(|event| (now_s, event)));
        let (up, sent, passes, count) = (&mut self.up, &mut self.sent, &mut self.passes_up, &mut self.counts.0);
        let arrives_s = now.as_seconds() + self.delay_s;
        core.outbox().drain(|bytes| {
            each_in_datagram(bytes, &mut EndpointCounters::default(), |_, frame| {
                sent.push((now_s, frame.header.message_id, frame.payload.to_vec()));
            });
            *count += 1;
            if passes(*count, bytes) {
                up.push_back((arrives_s, bytes.to_vec()));
            }
        });
    }

    pub fn request(&mut self, command: AutopilotCommand) -> RequestId {
        self.next_request += 1;
        let (now, request) = (self.now(), RequestId(self.next_request));
        self.core().request(now, request, command);
        self.flush();
        request
    }

    pub fn outcome(&self, request: RequestId) -> Option<Result<(), Refusal>> {
        self.events.iter().find_map(|(_, event)| match event {
            LinkEvent::Result { request: of, outcome } if *of == request => Some(outcome.clone()),
            _ => None,
        })
    }

    /// Uploads a route; the outcome comes as for a request.
    pub fn upload(&mut self, route: &[RoutePoint]) -> RequestId {
        self.next_request += 1;
        let (now, request) = (self.now(), RequestId(self.next_request));
        self.core().upload_route(now, request, route);
        self.flush();
        request
    }

    /// Asks and waits for the outcome.
    #[track_caller]
    pub fn ask(&mut self, command: AutopilotCommand) -> Result<(), Refusal> {
        let request = self.request(command);
        self.run_until(&format!("outcome of {command:?}"), 20.0, |rig| {
            rig.outcome(request).is_some()
        });
        self.outcome(request).unwrap()
    }

    pub fn is_ready(&mut self) -> bool {
        self.core.is_some() && self.read().0.ready_to_arm == Some(true)
    }

    /// Flies: armed, in the air, holding in OFFBOARD at 10 m.
    #[track_caller]
    pub fn take_off(&mut self) {
        self.run_until("ready", 20.0, Self::is_ready);
        assert_eq!(self.ask(AutopilotCommand::Arm), Ok(()));
        assert_eq!(self.ask(AutopilotCommand::TakeOff { height_m: 10.0 }), Ok(()));
        self.run_until("at height", 40.0, |rig| rig.read().0.mode == FlightMode::Hold);
        let place = self.read().0.local.unwrap();
        self.steer_to(place);
        assert_eq!(self.ask(AutopilotCommand::EnterOffboard), Ok(()));
    }

    pub fn steer_to(&mut self, place: LocalPositionNed) {
        self.steering = Some(Box::new(move |_| LocalSetpoint {
            position: Some(place),
            yaw_rad: Some(0.0),
            ..LocalSetpoint::default()
        }));
    }

    /// Ends the stream on purpose.
    pub fn stop(&mut self) {
        self.steering = None;
        let now = self.now();
        self.core().stop_stream(now);
        self.flush();
    }

    pub fn steer_north(&mut self, speed_m_s: f64) {
        let velocity = Some(VelocityNed::new(speed_m_s, 0.0, 0.0));
        self.steering = Some(Box::new(move |_| LocalSetpoint {
            velocity,
            ..LocalSetpoint::default()
        }));
    }

    pub fn modes(&self) -> Vec<(FlightMode, FlightMode, bool)> {
        let mode = |(_, event): &(f64, LinkEvent)| match event {
            LinkEvent::ModeChanged { from, to, commanded } => Some((*from, *to, *commanded)),
            _ => None,
        };
        self.events.iter().filter_map(mode).collect()
    }

    pub fn stream(&self) -> Vec<StreamState> {
        let state = |(_, event): &(f64, LinkEvent)| match event {
            LinkEvent::Stream(state) => Some(*state),
            _ => None,
        };
        self.events.iter().filter_map(state).collect()
    }

    pub fn has(&self, event: &LinkEvent) -> bool {
        self.is_told(|other| other == event)
    }

    pub fn is_told(&self, is: impl Fn(&LinkEvent) -> bool) -> bool {
        self.events.iter().any(|(_, event)| is(event))
    }

    /// Setpoints sent between two moments.
    pub fn setpoints(&self, from_s: f64, to_s: f64) -> usize {
        self.sent
            .iter()
            .filter(|(t, id, _)| *id == 84 && *t >= from_s && *t < to_s)
            .count()
    }
}
