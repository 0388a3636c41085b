//! A payload's plugin on a simulated vehicle, in simulated time: what the tests of the plugins stand on.
//!
//! Must never do: stand in for the device. What the plugin sends goes to the simulated vehicle as bytes, and what that answers comes
//! back.

use mavlink::Message;
use mavlink::dialects::common::MavMessage;
use nalgebra::Vector3;
use skein_domain::exchange::{CommandProgress, Create, Effect, Event, OwnState};
use skein_domain::payload::MavlinkMessage;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{CommandId, Geodetic, Incarnation, NodeTime, PositionNed, Refusal, SystemId, VehicleId};
use skein_plugin_sdk::{Effects, Payload};
use skein_sim::vehicle::{LinkKind, Outbox, SimVehicle, VehicleIdentity};
use skein_sim::{NoiseSettings, PayloadPlan, SimSettings, VehicleTruth, WindSettings};

/// Step of the simulation in seconds.
const STEP_S: f64 = 0.004;
/// Node time at which the simulation begins, in seconds.
const BEGIN_S: f64 = 100.0;
/// The vehicle's system id.
pub const SYSTEM_ID: u8 = 1;
/// What the node calls itself.
pub const OWN: (u8, u8) = (245, 190);

/// A plugin on a simulated vehicle.
#[derive(Debug)]
pub struct Rig<P: Payload> {
    /// The vehicle.
    pub vehicle: SimVehicle,
    /// The plugin.
    pub plugin: P,
    /// Every effect there was, with its time in seconds.
    pub effects: Vec<(f64, Effect)>,
    /// What the plugin sends does not arrive.
    pub deaf: bool,
    /// What the vehicle sends does not arrive.
    pub mute: bool,
    /// The launch place in the swarm frame.
    pub home: PositionNed,
    create: Create,
    origin: Geodetic,
    time_s: f64,
    tick_s: f64,
    next_tick_s: f64,
    next_command: u64,
    waiting: Vec<Event>,
    /// Everything the present instance was told, for a replay.
    told: Vec<RigCall>,
    since: usize,
    out: Outbox,
}

#[derive(Debug, Clone)]
enum RigCall {
    Events(NodeTime, Vec<Event>),
    Command(NodeTime, CommandId, String),
}

/// A vehicle in calm air that knows exactly where it is.
#[must_use]
pub fn quiet(payloads: PayloadPlan) -> SimSettings {
    SimSettings {
        wind: WindSettings::CALM,
        noise: NoiseSettings::NONE,
        payloads,
        ..SimSettings::default()
    }
}

impl<P: Payload> Rig<P> {
    /// A plugin with this configuration on a vehicle that stands at `position` and looks to `yaw_rad`.
    #[must_use]
    pub fn new(settings: &SimSettings, config_json: &str, position: PositionNed, yaw_rad: f64) -> Self {
        let identity = VehicleIdentity {
            system_id: SYSTEM_ID,
            position,
            yaw_rad,
            number: 0,
            ground_link: true,
            started_s: 0.0,
            airframe: skein_sim::Airframe::default(),
            battery: None,
            utc_at_zero_us: 0,
        };
        let create = Create {
            vehicle: VehicleId(u16::from(SYSTEM_ID)),
            incarnation: Incarnation(1),
            config_json: config_json.to_owned(),
            snapshot: None,
            now: NodeTime::from_seconds(BEGIN_S),
            payload: Some("payload".to_owned()),
            system_id: Some(SystemId(SYSTEM_ID)),
        };
        Self {
            vehicle: SimVehicle::new(identity, settings),
            plugin: instance(&create),
            effects: Vec::new(),
            deaf: false,
            mute: false,
            home: position,
            create,
            origin: settings.origin,
            time_s: 0.0,
            tick_s: 1.0 / f64::from(P::MANIFEST.tick_rate_hz),
            next_tick_s: 0.0,
            next_command: 1,
            waiting: Vec::new(),
            told: Vec::new(),
            since: 0,
            out: Outbox::default(),
        }
    }

    /// Now, on the node's clock.
    #[must_use]
    pub fn now(&self) -> NodeTime {
        NodeTime::from_seconds(BEGIN_S + self.time_s)
    }

    /// Lets time pass.
    pub fn run(&mut self, seconds: f64) {
        let end_s = self.time_s + seconds;
        while self.time_s < end_s - 1e-9 {
            self.step();
        }
    }

    /// Lets time pass until something is so; false if that takes longer than `limit_s`.
    pub fn run_until(&mut self, limit_s: f64, mut is_so: impl FnMut(&Self) -> bool) -> bool {
        let end_s = self.time_s + limit_s;
        while self.time_s < end_s {
            self.step();
            if is_so(self) {
                return true;
            }
        }
        false
    }

    fn step(&mut self) {
        self.vehicle.step(STEP_S, &Vector3::zeros(), &mut self.out);
        self.time_s += STEP_S;
        self.collect();
        if self.time_s >= self.next_tick_s {
            self.next_tick_s += self.tick_s;
            let mut events = vec![Event::Own(self.own())];
            events.append(&mut self.waiting);
            events.push(Event::Tick);
            self.tell(events);
        }
    }

    /// What the plugin is told of the vehicle.
    #[must_use]
    pub fn own(&self) -> OwnState {
        let VehicleTruth {
            position,
            velocity,
            yaw_rad,
            geodetic,
            armed,
            mode,
            ..
        } = self.vehicle.truth();
        OwnState {
            kinematics: Some(VehicleKinematics {
                position,
                velocity,
                yaw_rad,
                measured: self.now(),
            }),
            mode,
            armed,
            home: Some(self.home),
            link_connected: !self.mute,
            roll_rad: Some(0.0),
            pitch_rad: Some(0.0),
            global: Some(geodetic),
            frame_origin: Some(self.origin),
            ..OwnState::default()
        }
    }

    /// Tells the plugin of events, and carries out what it wants.
    pub fn tell(&mut self, events: Vec<Event>) {
        let mut effects = Effects::default();
        self.plugin.handle(self.now(), &events, &mut effects);
        self.told.push(RigCall::Events(self.now(), events));
        self.carry_out(effects);
    }

    /// Gives the plugin a command.
    pub fn command(&mut self, command_json: &str) -> CommandId {
        let id = CommandId(self.next_command);
        self.next_command += 1;
        let mut effects = Effects::default();
        let command = serde_json::from_str(command_json).expect("a command of its vocabulary");
        self.plugin.command(self.now(), id, command, &mut effects);
        self.told
            .push(RigCall::Command(self.now(), id, command_json.to_owned()));
        self.carry_out(effects);
        id
    }

    fn carry_out(&mut self, mut effects: Effects) {
        for effect in effects.take() {
            assert!(
                P::MANIFEST.effects.contains(&effect.kind()),
                "{effect:?} is not in the manifest"
            );
            if let Effect::Mavlink(message) = &effect
                && !self.deaf
            {
                let bytes = frame(OWN, message);
                self.vehicle.receive(LinkKind::Onboard, &bytes, &mut self.out);
            }
            self.effects.push((self.time_s, effect));
        }
        self.collect();
    }

    /// Sends a message to the vehicle as somebody else does.
    pub fn send_as(&mut self, sender: (u8, u8), message: &MavlinkMessage) {
        let bytes = frame(sender, message);
        self.vehicle.receive(LinkKind::GroundStation, &bytes, &mut self.out);
        self.collect();
    }

    fn collect(&mut self) {
        let heard = self
            .out
            .frames()
            .filter(|(link, _)| *link == LinkKind::Onboard && !self.mute);
        let wanted = heard.filter_map(|(_, bytes)| unframe(bytes));
        let wanted = wanted.filter(|message| P::MANIFEST.mavlink_messages.contains(&message.message_id));
        self.waiting.extend(wanted.map(Event::Mavlink));
        self.out.clear();
    }

    /// How a command ended, if it did. It must not have ended twice.
    #[must_use]
    pub fn ended(&self, id: CommandId) -> Option<Result<(), Refusal>> {
        let mut ends = self.effects.iter().filter_map(|(_, effect)| match effect {
            Effect::CommandProgress { id: of, progress } if *of == id => match progress {
                CommandProgress::Executing => None,
                CommandProgress::Done => Some(Ok(())),
                CommandProgress::Refused { refusal } => Some(Err(refusal.clone())),
            },
            _ => None,
        });
        let end = ends.next();
        assert!(ends.next().is_none(), "command {id} ended twice");
        end
    }

    /// Lets time pass until a command ends.
    pub fn end_of(&mut self, id: CommandId, limit_s: f64) -> Option<Result<(), Refusal>> {
        self.run_until(limit_s, |rig| rig.ended(id).is_some());
        self.ended(id)
    }

    /// The state as last reported, as JSON.
    #[must_use]
    pub fn state(&self) -> serde_json::Value {
        let mut reports = self.effects.iter().rev().filter_map(|(_, effect)| match effect {
            Effect::Report { state_json } => serde_json::from_str(state_json).ok(),
            _ => None,
        });
        reports.next().unwrap_or_default()
    }

    /// Ends the instance and makes another from its snapshot, which must give the same snapshot again.
    pub fn restart(&mut self) {
        let snapshot = self.plugin.snapshot();
        self.create.incarnation = self.create.incarnation.next();
        self.create.snapshot = Some(snapshot.clone());
        self.create.now = self.now();
        self.plugin = instance(&self.create);
        assert_eq!(
            self.plugin.snapshot(),
            snapshot,
            "a restored instance gives another snapshot"
        );
        self.told.clear();
        self.since = self.effects.len();
    }

    /// Tells another instance the same: it must want the same.
    pub fn replay(&self) {
        let mut other: P = instance(&self.create);
        let mut effects = Effects::default();
        for told in &self.told {
            match told {
                RigCall::Events(now, events) => other.handle(*now, events, &mut effects),
                RigCall::Command(now, id, json) => {
                    let command = serde_json::from_str(json).expect("a command of its vocabulary");
                    other.command(*now, *id, command, &mut effects);
                }
            }
        }
        let since = self.effects.get(self.since..).unwrap_or_default();
        assert!(
            since.iter().map(|(_, effect)| effect).eq(effects.as_slice()),
            "a replay went otherwise"
        );
        assert_eq!(other.snapshot(), self.plugin.snapshot(), "a replay ended otherwise");
    }
}

fn instance<P: Payload>(create: &Create) -> P {
    let config = serde_json::from_str(&create.config_json).expect("a configuration of its schema");
    P::create(create.clone(), config).expect("an instance")
}

/// A MAVLink 2 frame around a message.
fn frame((system_id, component_id): (u8, u8), message: &MavlinkMessage) -> Vec<u8> {
    let [a, b, c, _] = message.message_id.to_le_bytes();
    let len = u8::try_from(message.payload.len()).expect("a payload of at most 255 bytes");
    let mut bytes = vec![0xfd, len, 0, 0, 0, system_id, component_id, a, b, c];
    bytes.extend(&message.payload);
    let body = bytes.get(1..).unwrap_or_default();
    let checksum = mavlink::calculate_crc(body, MavMessage::extra_crc(message.message_id));
    bytes.extend(checksum.to_le_bytes());
    bytes
}

/// The message in a MAVLink 2 frame.
fn unframe(bytes: &[u8]) -> Option<MavlinkMessage> {
    let &[_, len, _, _, _, system_id, component_id, a, b, c] = bytes.first_chunk()?;
    Some(MavlinkMessage {
        system_id,
        component_id,
        message_id: u32::from_le_bytes([a, b, c, 0]),
        payload: bytes.get(10..10 + usize::from(len))?.to_vec(),
    })
}
