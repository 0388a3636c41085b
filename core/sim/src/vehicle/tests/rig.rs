//! A vehicle on the bench: speaks to it as a companion computer does, and remembers what it answered.

use crate::settings::{NoiseSettings, SimSettings, WindSettings};
use crate::truth::VehicleTruth;
use crate::vehicle::{LinkKind, Outbox, SimVehicle, VehicleIdentity};
use mavlink::dialects::common::*;
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MavlinkVersion, Message, MessageData};
use nalgebra::Vector3;
use skein_domain::{FlightMode, PositionNed};

pub const STEP_S: f64 = 0.004;

/// A vehicle, the time, and all it has sent.
pub struct Rig {
    pub vehicle: SimVehicle,
    pub time_s: f64,
    pub received: Vec<(f64, LinkKind, MavMessage)>,
    /// Acknowledgements of commands that the dialect does not know.
    pub nameless_answers: usize,
    pub stream: Option<SET_POSITION_TARGET_LOCAL_NED_DATA>,
    pub stream_period_s: f64,
    next_stream_s: f64,
    next_heartbeat_s: f64,
    pub ground_station: bool,
    wind: Vector3<f64>,
    out: Outbox,
}

/// Calm air and a perfect estimate.
pub fn quiet() -> SimSettings {
    SimSettings {
        wind: WindSettings::CALM,
        noise: NoiseSettings::NONE,
        ..SimSettings::default()
    }
}

pub fn identity() -> VehicleIdentity {
    VehicleIdentity {
        system_id: 1,
        position: PositionNed::new(20.0, -30.0, -7.0),
        yaw_rad: 0.0,
        number: 0,
        ground_link: true,
        started_s: 0.0,
        airframe: crate::Airframe::default(),
        battery: None,
        utc_at_zero_us: 0,
    }
}

impl Rig {
    pub fn new(settings: &SimSettings) -> Self {
        Self::of(settings.airframe, settings)
    }

    /// A vehicle of a kind.
    pub fn of(airframe: crate::Airframe, settings: &SimSettings) -> Self {
        let identity = VehicleIdentity { airframe, ..identity() };
        Self {
            vehicle: SimVehicle::new(identity, settings),
            time_s: 0.0,
            received: Vec::new(),
            nameless_answers: 0,
            stream: None,
            stream_period_s: 0.05,
            next_stream_s: 0.0,
            next_heartbeat_s: 0.0,
            ground_station: true,
            wind: Vector3::new(settings.wind.mean_north_m_s, settings.wind.mean_east_m_s, 0.0),
            out: Outbox::default(),
        }
    }

    /// Ready to be armed.
    pub fn ready(settings: &SimSettings) -> Self {
        let mut rig = Self::new(settings);
        rig.run(5.0);
        rig
    }

    /// In the air at a height, holding.
    pub fn flying(settings: &SimSettings, height_m: f64) -> Self {
        let mut rig = Self::ready(settings);
        rig.take_off(height_m);
        let up = rig.run_until(60.0, |t| t.mode == FlightMode::Hold && t.height_m > height_m - 0.2);
        assert!(up.is_some(), "did not take off: {:?}", rig.truth());
        rig
    }

    /// In OFFBOARD, streaming its present position.
    pub fn offboard(settings: &SimSettings, height_m: f64) -> Self {
        let mut rig = Self::flying(settings, height_m);
        let p = rig.own_position();
        rig.stream = Some(position(p));
        rig.run(1.0);
        assert_eq!(
            rig.command(176, [1.0, 6.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            Some(MavResult::MAV_RESULT_ACCEPTED)
        );
        rig
    }

    pub fn truth(&self) -> VehicleTruth {
        self.vehicle.truth()
    }

    /// Position in the vehicle's own frame, as it was last reported.
    pub fn own_position(&self) -> Vector3<f64> {
        let found = self.received.iter().rev().find_map(|(_, _, m)| match m {
            MavMessage::LOCAL_POSITION_NED(p) => Some(Vector3::new(p.x, p.y, p.z).cast()),
            _ => None,
        });
        found.expect("a position was reported")
    }

    pub fn run(&mut self, seconds: f64) {
        let end = self.time_s + seconds;
        while self.time_s < end - 1e-9 {
            self.step();
        }
    }

    /// Runs until the truth fulfils a condition; gives how long that took.
    pub fn run_until(&mut self, limit_s: f64, mut done: impl FnMut(&VehicleTruth) -> bool) -> Option<f64> {
        let start = self.time_s;
        while self.time_s < start + limit_s {
            self.step();
            if done(&self.truth()) {
                return Some(self.time_s - start);
            }
        }
        None
    }

    fn step(&mut self) {
        if self.ground_station && self.time_s >= self.next_heartbeat_s {
            self.next_heartbeat_s += 1.0;
            let heartbeat = HEARTBEAT_DATA {
                mavtype: MavType::MAV_TYPE_GCS,
                ..HEARTBEAT_DATA::default()
            };
            self.send(LinkKind::Onboard, &heartbeat);
        }
        if let Some(setpoint) = self.stream.clone()
            && self.time_s >= self.next_stream_s
        {
            self.next_stream_s = self.time_s + self.stream_period_s;
            self.send(LinkKind::Onboard, &setpoint);
        }
        self.vehicle.step(STEP_S, &self.wind.clone(), &mut self.out);
        self.time_s += STEP_S;
        self.collect();
    }

    fn collect(&mut self) {
        for (link, frame) in self.out.frames() {
            match decode(frame) {
                Some(message) => self.received.push((self.time_s, link, message)),
                None => {
                    // The library has no word for the number of an unknown command; anything else must decode.
                    assert_eq!(frame[7], 77, "every frame sent decodes");
                    self.nameless_answers += 1;
                }
            }
        }
        self.out.clear();
    }

    /// Sends one message as system 245, component 190.
    pub fn send<M: MessageData>(&mut self, link: LinkKind, message: &M) {
        let mut raw = MAVLinkV2MessageRaw::new();
        raw.serialize_message_data(
            MavHeader {
                system_id: 245,
                component_id: 190,
                sequence: 0,
            },
            message,
        );
        self.send_bytes(link, raw.raw_bytes());
    }

    pub fn send_bytes(&mut self, link: LinkKind, bytes: &[u8]) {
        self.vehicle.receive(link, bytes, &mut self.out);
        self.collect();
    }

    /// Sends a command to the autopilot and gives its result, if it is acknowledged within a tenth of a second.
    pub fn command(&mut self, command: u16, param: [f32; 7]) -> Option<MavResult> {
        self.command_to(1, 1, command, param)
    }

    pub fn command_to(&mut self, system: u8, component: u8, command: u16, param: [f32; 7]) -> Option<MavResult> {
        let before = self.received.len();
        let frame = command_frame(system, component, command, param);
        self.send_bytes(LinkKind::Onboard, &frame);
        self.run(0.1);
        self.received.iter().skip(before).find_map(|(_, _, m)| match m {
            MavMessage::COMMAND_ACK(ack) if ack.command as u16 == command => {
                assert_eq!(
                    (ack.target_system, ack.target_component),
                    (245, 190),
                    "addressed to the sender"
                );
                Some(ack.result)
            }
            _ => None,
        })
    }

    pub fn arm(&mut self) -> Option<MavResult> {
        self.command(400, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    pub fn set_mode(&mut self, main: u8, sub: u8) -> Option<MavResult> {
        self.command(176, [1.0, f32::from(main), f32::from(sub), 0.0, 0.0, 0.0, 0.0])
    }

    /// Altitude above mean sea level of a height over the place it stands on.
    pub fn amsl(&self, height_m: f64) -> f32 {
        let t = self.truth();
        (t.geodetic.altitude_amsl_m - t.height_m + height_m) as f32
    }

    /// Arms and takes off to a height.
    pub fn take_off(&mut self, height_m: f64) {
        assert_eq!(self.arm(), Some(MavResult::MAV_RESULT_ACCEPTED));
        let nan = f32::NAN;
        let altitude = self.amsl(height_m);
        let result = self.command(22, [0.0, 0.0, 0.0, nan, nan, nan, altitude]);
        assert_eq!(result, Some(MavResult::MAV_RESULT_ACCEPTED));
    }

    pub fn land(&mut self) {
        let nan = f32::NAN;
        let result = self.command(21, [0.0, 0.0, 0.0, nan, nan, nan, nan]);
        assert_eq!(result, Some(MavResult::MAV_RESULT_ACCEPTED));
    }

    /// All texts so far, chunks put together.
    pub fn texts(&self) -> Vec<String> {
        let mut texts: Vec<String> = Vec::new();
        for (_, link, message) in &self.received {
            if let (LinkKind::Onboard, MavMessage::STATUSTEXT(t)) = (link, message) {
                let text = t.text.to_str().expect("text").to_owned();
                match texts.last_mut() {
                    Some(last) if t.chunk_seq > 0 => last.push_str(&text),
                    _ => texts.push(text),
                }
            }
        }
        texts
    }

    pub fn heard(&self, text: &str) -> bool {
        self.texts().iter().any(|t| t.trim_end_matches('\t') == text)
    }

    pub fn last<T>(&self, pick: impl Fn(&MavMessage) -> Option<T>) -> Option<T> {
        self.received.iter().rev().find_map(|(_, _, m)| pick(m))
    }

    /// How many messages of an id came on a link in the last seconds, per second.
    pub fn rate_hz(&self, link: LinkKind, id: u32, seconds: f64) -> f64 {
        let since = self.time_s - seconds;
        let count = self
            .received
            .iter()
            .filter(|(t, l, m)| *t > since && *l == link && m.message_id() == id)
            .count();
        count as f64 / seconds
    }
}

/// A setpoint that asks for a position only, in the vehicle's own frame.
pub fn position(p: Vector3<f64>) -> SET_POSITION_TARGET_LOCAL_NED_DATA {
    SET_POSITION_TARGET_LOCAL_NED_DATA {
        x: p.x as f32,
        y: p.y as f32,
        z: p.z as f32,
        target_system: 1,
        target_component: 1,
        coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
        type_mask: PositionTargetTypemask::from_bits_retain(0b1001_1111_1000),
        ..SET_POSITION_TARGET_LOCAL_NED_DATA::default()
    }
}

/// COMMAND_LONG with any command number, known to the dialect or not.
pub fn command_frame(system: u8, component: u8, command: u16, param: [f32; 7]) -> Vec<u8> {
    let mut payload: Vec<u8> = param.iter().flat_map(|p| p.to_le_bytes()).collect();
    payload.extend(command.to_le_bytes());
    payload.extend([system, component, 0]);
    frame(76, &payload)
}

/// A MAVLink 2 frame around a payload.
pub fn frame(id: u32, payload: &[u8]) -> Vec<u8> {
    let [a, b, c, _] = id.to_le_bytes();
    let mut bytes = vec![0xFD, payload.len() as u8, 0, 0, 7, 245, 190, a, b, c];
    bytes.extend(payload);
    let crc = mavlink::calculate_crc(&bytes[1..], MavMessage::extra_crc(id));
    bytes.extend(crc.to_le_bytes());
    bytes
}

/// What a whole frame says.
pub fn decode(bytes: &[u8]) -> Option<MavMessage> {
    let id = u32::from_le_bytes([bytes[7], bytes[8], bytes[9], 0]);
    let payload = &bytes[10..bytes.len() - 2];
    assert_eq!(usize::from(bytes[1]), payload.len());
    let crc = mavlink::calculate_crc(&bytes[1..bytes.len() - 2], MavMessage::extra_crc(id));
    assert_eq!(crc.to_le_bytes(), bytes[bytes.len() - 2..]);
    MavMessage::parse(MavlinkVersion::V2, id, payload).ok()
}
