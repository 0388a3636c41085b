//! Plays any bytes as the life of one vehicle over DDS: what discovery shows, samples, requests, setpoints, time. Panics if the check or the
//! link does what it must never do.

use skein_domain::link::StreamState;
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{AccelerationNed, AutopilotCommand, FlightMode, LocalPositionNed, NodeTime, RequestId, VelocityNed};
use skein_link_dds::admission::{Admission, Verdict};
use skein_link_dds::cdr::Encoding;
use skein_link_dds::definitions::{Command, DEFINITIONS, Definition, Need, Release, Topic};
use skein_link_dds::messages::Kind;
use skein_link_dds::naming::{Direction, Namespace, TopicName, type_name};
use skein_link_dds::session::VehicleSession;
use skein_link_dds::session::setpoint::Outgoing;
use skein_px4::LinkSettings;

/// The vehicle's number.
const SYSTEM_ID: u8 = 7;

/// Not the one of the other link: what is kept of earlier runs has its numbers read in another way.
struct Input<'a>(&'a [u8]);

impl<'a> Input<'a> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn small(&mut self) -> usize {
        usize::from(self.byte().unwrap_or(0))
    }

    fn bytes(&mut self, len: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(len.min(self.0.len()));
        self.0 = rest;
        taken
    }

    fn number(&mut self) -> f64 {
        let mut bytes = [0; 8];
        let taken = self.bytes(4);
        // The octets that matter most: the rest of the number is zero.
        bytes[8 - taken.len()..].copy_from_slice(taken);
        f64::from_le_bytes(bytes)
    }
}

/// One vehicle: the check first, the link once it is admitted.
struct Life {
    now: NodeTime,
    release: Release,
    admission: Admission,
    session: Option<VehicleSession>,
    requests: u32,
}

/// Plays the bytes.
pub fn drive(data: &[u8]) {
    let mut input = Input(data);
    let mut life = begin(&mut input);
    while let Some(op) = input.byte() {
        life.now = life.now.plus_seconds(f64::from(op >> 3) * 0.01);
        let before = life.session.as_ref().map(VehicleSession::stream_state);
        life.step(op & 7, &mut input);
        life.check(before);
    }
}

/// A vehicle of some release; every other time one that is admitted already.
fn begin(input: &mut Input<'_>) -> Life {
    let first = input.small();
    let release = Release::ALL[(first >> 1) % Release::ALL.len()];
    let now = NodeTime::from_seconds(10.0);
    let mut life = Life {
        now,
        release,
        admission: Admission::default(),
        session: None,
        requests: 0,
    };
    if first & 1 == 0 {
        for topic in Topic::ALL {
            let name = name(topic.base(), definition(topic, release).version, Direction::Out);
            assert_eq!(
                life.admission.on_endpoint(&name, &type_name(topic.message()), b""),
                Ok(true)
            );
        }
        for command in Command::ALL {
            let name = name(command.base(), 0, Direction::In);
            assert_eq!(
                life.admission.on_endpoint(&name, &type_name(command.message()), b""),
                Ok(true)
            );
        }
        for i in 0..3 {
            for topic in Topic::ALL.into_iter().filter(|topic| topic.need() == Need::Seen) {
                let definition = definition(topic, release);
                life.hear(
                    definition,
                    Encoding::LittleEndian,
                    &good(definition, 5_000_000 + i * 20_000),
                );
            }
        }
        assert!(life.session.is_some(), "a good vehicle of {release} is admitted");
    }
    life
}

fn name(base: &str, version: u32, direction: Direction) -> TopicName {
    TopicName {
        namespace: Namespace::default(),
        direction,
        base: base.to_owned(),
        version,
    }
}

fn definition(topic: Topic, release: Release) -> &'static Definition {
    let found = DEFINITIONS
        .iter()
        .find(|d| d.topic == topic && d.releases.contains(&release));
    found.expect("each release has each topic")
}

/// A sample that can be true.
fn good(definition: &Definition, stamp_us: u64) -> Vec<u8> {
    let mut out = Vec::new();
    for field in definition.fields {
        let size = field.kind.size_bytes();
        out.resize(out.len().div_ceil(size) * size, 0);
        let value: f64 = match field.name {
            "timestamp" | "timestamp_sample" => stamp_us as f64,
            "system_id" => f64::from(SYSTEM_ID),
            "arming_state" | "xy_valid" | "z_valid" | "v_xy_valid" | "v_z_valid" | "xy_global" | "z_global" | "q"
            | "valid_hpos" | "valid_alt" | "lat_lon_valid" | "alt_valid" | "connected" => 1.0,
            "nav_state" => 14.0,
            _ => 0.0,
        };
        for i in 0..field.elements.unwrap_or(1) {
            let value = if i == 0 { value } else { 0.0 };
            match field.kind {
                Kind::F32 => out.extend((value as f32).to_le_bytes()),
                Kind::F64 => out.extend(value.to_le_bytes()),
                _ => out.extend(&(value as u64).to_le_bytes()[..size]),
            }
        }
    }
    out
}

impl Life {
    fn step(&mut self, op: u8, input: &mut Input<'_>) {
        match op {
            0 => self.discover(input),
            1 => {
                let definition = &DEFINITIONS[input.small() % DEFINITIONS.len()];
                let encoding = Encoding::of(u16::from(input.byte().unwrap_or(0)) % 4);
                let len = input.small() * 2;
                self.hear(definition, encoding, input.bytes(len));
            }
            2 | 3 => self.mutated(input),
            4 => self.ask(input),
            5 => self.offer(input),
            6 => {
                let now = self.now;
                if let Some(session) = &mut self.session {
                    assert!(
                        session.on_tick(now).seconds_since(now) <= 1.0,
                        "the next tick is too far"
                    );
                }
            }
            _ => self.service(input),
        }
    }

    fn discover(&mut self, input: &mut Input<'_>) {
        let (which, flags) = (input.small(), input.byte().unwrap_or(0));
        let user = input.bytes(usize::from(flags >> 3));
        let topic = Topic::ALL[which % Topic::ALL.len()];
        let command = Command::ALL[which % Command::ALL.len()];
        let (base, message, direction) = if flags & 1 == 0 {
            (topic.base(), topic.message(), Direction::Out)
        } else {
            (command.base(), command.message(), Direction::In)
        };
        let kind = if flags & 2 == 0 {
            type_name(message)
        } else {
            String::from_utf8_lossy(user).into_owned()
        };
        let version = if flags & 4 == 0 {
            definition(topic, self.release).version
        } else {
            u32::from(flags >> 3)
        };
        // Mismatches are part of it; they have words.
        if let Err(mismatch) = self.admission.on_endpoint(&name(base, version, direction), &kind, user) {
            assert!(!mismatch.to_string().is_empty());
        }
        self.judge();
    }

    /// A good sample of which some octets are others.
    fn mutated(&mut self, input: &mut Input<'_>) {
        let definition = definition(Topic::ALL[input.small() % Topic::ALL.len()], self.release);
        let ahead_s = [0.0, 0.0, 0.0, 0.5, -3.0, 1.7e9, 100.0, 0.0][input.small() % 8];
        let mut bytes = good(definition, self.now.plus_seconds(ahead_s).0);
        for _ in 0..input.small() % 12 {
            let (at, value) = (input.small() + input.small(), input.byte().unwrap_or(0));
            let at = at % bytes.len();
            bytes[at] = value;
        }
        self.hear(definition, Encoding::LittleEndian, &bytes);
    }

    fn hear(&mut self, definition: &Definition, encoding: Encoding, bytes: &[u8]) {
        let name = name(definition.topic.base(), definition.version, Direction::Out);
        let sample = self.admission.on_sample(&name, encoding, bytes);
        if let (Some(sample), Some(session)) = (&sample, &mut self.session) {
            session.on_sample(self.now, sample);
        }
        self.judge();
    }

    fn judge(&mut self) {
        match self.admission.verdict() {
            Verdict::Admitted { system_id, .. } => {
                let new = || VehicleSession::new(&LinkSettings::default(), system_id, self.now);
                self.session.get_or_insert_with(new);
            }
            Verdict::Refused(mismatch) => {
                assert!(self.session.is_none(), "{mismatch}: one that flies is not refused");
                assert!(!mismatch.to_string().is_empty());
            }
            Verdict::Open => assert!(self.session.is_none(), "one that flies is not asked again"),
        }
    }

    fn ask(&mut self, input: &mut Input<'_>) {
        let which = input.byte().unwrap_or(0);
        let command = match which % 8 {
            0 => AutopilotCommand::Arm,
            1 => AutopilotCommand::Disarm,
            2 => AutopilotCommand::TakeOff {
                height_m: input.number(),
            },
            3 => AutopilotCommand::Land,
            4 => AutopilotCommand::ReturnToLaunch,
            5 => AutopilotCommand::EnterOffboard,
            6 => AutopilotCommand::EmergencyStop,
            _ => AutopilotCommand::SetMode {
                mode: FlightMode::ALL[usize::from(which >> 3) % FlightMode::ALL.len()],
            },
        };
        self.requests += 1;
        if let Some(session) = &mut self.session {
            session.request(self.now, RequestId(self.requests), command);
        }
    }

    fn offer(&mut self, input: &mut Input<'_>) {
        let (parts, valid_s) = (input.byte().unwrap_or(0), input.small() as f64 * 0.01);
        let mut triple = || [input.number(), input.number(), input.number()];
        let position = (parts & 1 != 0).then(&mut triple);
        let velocity = (parts & 2 != 0).then(&mut triple);
        let acceleration = (parts & 4 != 0).then(&mut triple);
        let [yaw, yaw_rate, _] = triple();
        let setpoint = LocalSetpoint {
            position: position.map(|[n, e, d]| LocalPositionNed::new(n, e, d)),
            velocity: velocity.map(|[n, e, d]| VelocityNed::new(n, e, d)),
            acceleration: acceleration.map(|[n, e, d]| AccelerationNed::new(n, e, d)),
            yaw_rad: (parts & 8 != 0).then_some(yaw),
            yaw_rate_rad_s: (parts & 16 != 0).then_some(yaw_rate),
        };
        if let Some(session) = &mut self.session {
            session.stream(self.now, setpoint, self.now.plus_seconds(valid_s));
        }
    }

    fn service(&mut self, input: &mut Input<'_>) {
        let (now, which) = (self.now, input.byte().unwrap_or(0));
        let Some(session) = &mut self.session else { return };
        match which % 4 {
            0 => session.stop_stream(now),
            1 => session.set_duplicate(now, true),
            2 => session.set_duplicate(now, false),
            _ => session.not_supported(RequestId(0), "a route"),
        }
    }

    /// What must hold after everything.
    fn check(&mut self, before: Option<StreamState>) {
        let Some(session) = &mut self.session else { return };
        let active = |state| matches!(state, StreamState::Fresh | StreamState::HoldingExpired);
        let streamed = active(session.stream_state()) || before.is_some_and(active);
        for outgoing in session.take_outgoing() {
            match outgoing {
                Outgoing::Setpoint(mode, setpoint) => {
                    assert!(streamed, "a setpoint left a stream that is stopped");
                    assert!(mode.position || mode.velocity || mode.acceleration);
                    let parts = [
                        (mode.position, setpoint.position),
                        (mode.velocity, setpoint.velocity),
                        (mode.acceleration, setpoint.acceleration),
                        (false, setpoint.jerk),
                        (false, [setpoint.yaw, setpoint.yawspeed, f32::NAN]),
                    ];
                    for (given, part) in parts {
                        assert!(
                            part.iter().all(|x| x.is_finite() || (!given && x.is_nan())),
                            "{setpoint:?}"
                        );
                    }
                }
                Outgoing::Command(command) => {
                    assert!(command.from_external && command.target_component == 1);
                    let numbers = [
                        command.param1,
                        command.param2,
                        command.param3,
                        command.param4,
                        command.param7,
                    ];
                    assert!(!numbers.iter().any(|x| x.is_infinite()), "{command:?}");
                    assert!(
                        !command.param5.is_infinite() && !command.param6.is_infinite(),
                        "{command:?}"
                    );
                }
            }
        }
        self.check_telemetry();
    }

    fn check_telemetry(&mut self) {
        let now = self.now;
        let Some(session) = &mut self.session else { return };
        let (telemetry, health) = session.read(now);
        assert!(telemetry.local.is_none_or(|local| local.is_finite()));
        assert!(telemetry.velocity.is_none_or(|velocity| velocity.is_finite()));
        let places = [telemetry.global, telemetry.home, telemetry.gnss_place];
        assert!(places.iter().flatten().all(|place| place.is_valid()), "{places:?}");
        assert!(telemetry.local_frame.is_none_or(|frame| frame.origin.is_valid()));
        let (battery, used) = (telemetry.battery, telemetry.battery_use);
        let estimator = telemetry.estimator;
        let known = [
            Some(telemetry.roll_rad),
            Some(telemetry.pitch_rad),
            Some(telemetry.yaw_rad),
            Some(health.receive_rate_hz),
            Some(health.setpoint_rate_hz),
            health.round_trip_s,
            health.clock_offset_s.map(|offset| offset as f32),
            battery.remaining,
            battery.voltage_v,
            battery.current_a,
            used.consumed_ah,
            used.consumed_wh,
            used.remaining_s,
            telemetry.gnss.horizontal_accuracy_m,
            estimator.and_then(|estimator| estimator.horizontal_accuracy_m),
            estimator.and_then(|estimator| estimator.vertical_accuracy_m),
        ];
        assert!(
            known.iter().flatten().all(|number| number.is_finite()),
            "{telemetry:?} {health:?}"
        );
        assert!(telemetry.position_time <= now);
        if now.0.is_multiple_of(7) {
            drop(session.take_events());
        }
    }
}
