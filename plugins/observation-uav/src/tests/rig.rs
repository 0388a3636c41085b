//! A vehicle in the air under the model, with a gimbal, and something to look at.

use crate::{ObservationUav, Settings};
use nalgebra::Vector3;
use skein_plugin_sdk::domain::exchange::{CommandProgress, Create, Effect, Event, OwnState, PayloadReport, PeerState};
use skein_plugin_sdk::domain::payload::{
    CameraState, GimbalCommand, GimbalMode, GimbalState, PayloadKind, RadioState, Target, Track,
};
use skein_plugin_sdk::domain::telemetry::VehicleKinematics;
use skein_plugin_sdk::domain::{
    AutopilotCommand, CommandId, FlightMode, FlightState, Geodetic, Incarnation, LandedState, NodeTime, PositionNed,
    Refusal, RequestId, Setpoint, SwarmFrame, VehicleCommand, VehicleId,
};
use skein_plugin_sdk::{Effects, UavModel};

pub const PERIOD_S: f64 = 0.02;
pub const ORIGIN: Geodetic = Geodetic {
    latitude_deg: 47.4,
    longitude_deg: 8.5,
    altitude_amsl_m: 488.0,
};
pub const THE_TRACK: Target = Target::Track { track: 5 };
pub const THE_VEHICLE: Target = Target::Vehicle { vehicle: VehicleId(2) };

/// A gimbal on the vehicle's belly: turns at a limited rate to the place it was told.
#[derive(Debug, Clone)]
pub struct Gimbal {
    pub state: GimbalState,
    pub refuses: Option<Refusal>,
    /// It cannot turn its yaw from the vehicle's nose.
    pub fixed_yaw: bool,
    /// When it was told something, and what.
    pub told: Vec<(f64, GimbalCommand)>,
}

impl Default for Gimbal {
    fn default() -> Self {
        let state = GimbalState {
            connected: true,
            yaw_north_rad: Some(0.0),
            ..GimbalState::default()
        };
        Self {
            state,
            refuses: None,
            fixed_yaw: false,
            told: Vec::new(),
        }
    }
}

/// What is observed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mover {
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
}

pub struct Rig {
    pub model: ObservationUav,
    pub now: NodeTime,
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub yaw_rad: f64,
    pub mode: FlightMode,
    pub setpoint: Option<Setpoint>,
    pub gimbal: Option<Gimbal>,
    pub camera: Option<CameraState>,
    pub radio: Option<RadioState>,
    pub track: Option<Mover>,
    /// How well the track is known.
    pub track_error_m: Option<f64>,
    /// How the vehicle leans for each metre per second that it flies forward, in radians.
    pub lean_rad_s_m: Option<f64>,
    pub peer: Option<Mover>,
    pub inbox: Vec<Event>,
    pub log: Vec<(f64, Effect)>,
    pub state: FlightState,
    pub origin: Option<Geodetic>,
    answers: Vec<Event>,
    next_command: u64,
}

pub fn create(settings: Settings, snapshot: Option<Vec<u8>>, now: NodeTime) -> ObservationUav {
    let create = Create {
        vehicle: VehicleId(7),
        incarnation: Incarnation(1),
        config_json: "{}".to_owned(),
        snapshot,
        now,
        payload: None,
        system_id: None,
    };
    ObservationUav::create(create, settings).expect("is created")
}

impl Rig {
    /// In the air, 20 m up, holding.
    pub fn new(settings: Settings) -> Self {
        let now = NodeTime(5_000_000);
        let mut rig = Self {
            model: create(settings, None, now),
            now,
            position: Vector3::new(0.0, 0.0, -20.0),
            velocity: Vector3::zeros(),
            yaw_rad: 0.0,
            mode: FlightMode::Offboard,
            setpoint: None,
            gimbal: Some(Gimbal::default()),
            camera: None,
            radio: None,
            track: None,
            track_error_m: None,
            lean_rad_s_m: None,
            peer: None,
            inbox: Vec::new(),
            log: Vec::new(),
            state: FlightState::Idle,
            origin: Some(ORIGIN),
            answers: Vec::new(),
            next_command: 1,
        };
        rig.run(0.5);
        assert_eq!(rig.state, FlightState::Holding);
        rig
    }

    pub fn with_track(north_m: f64, east_m: f64) -> Self {
        let mut rig = Self::new(Settings::default());
        rig.track = Some(Mover {
            position: Vector3::new(north_m, east_m, 0.0),
            velocity: Vector3::zeros(),
        });
        rig.tick();
        rig
    }

    pub fn observe(&mut self, target: Target, stand_off_m: Option<f64>, height_m: Option<f64>) -> CommandId {
        self.command(VehicleCommand::Observe {
            target,
            stand_off_m,
            height_m,
            bearing_rad: None,
        })
    }

    pub fn command(&mut self, command: VehicleCommand) -> CommandId {
        let id = CommandId(self.next_command);
        self.next_command += 1;
        self.inbox.push(Event::Command {
            id,
            command,
            not_before: NodeTime(0),
        });
        id
    }

    /// How fast it flies along its nose.
    fn forward_m_s(&self) -> f64 {
        let (sin, cos) = self.yaw_rad.sin_cos();
        self.velocity.x * cos + self.velocity.y * sin
    }

    fn own(&self) -> OwnState {
        OwnState {
            kinematics: Some(VehicleKinematics {
                position: self.position.into(),
                velocity: self.velocity.into(),
                yaw_rad: self.yaw_rad,
                measured: self.now,
            }),
            mode: self.mode,
            armed: true,
            landed: LandedState::InAir,
            home: Some(PositionNed::new(0.0, 0.0, 0.0)),
            link_connected: true,
            frame_origin: self.origin,
            pitch_rad: self.lean_rad_s_m.map(|lean| -lean * self.forward_m_s()),
            ..OwnState::default()
        }
    }

    fn events(&mut self) -> Vec<Event> {
        let mut events = vec![Event::Own(self.own())];
        let peer = self.peer.map(|peer| PeerState {
            id: VehicleId(2),
            kinematics: VehicleKinematics {
                position: peer.position.into(),
                velocity: peer.velocity.into(),
                yaw_rad: 0.0,
                measured: self.now,
            },
            airborne: true,
        });
        events.push(Event::Peers(peer.into_iter().collect()));
        let track = self.track.map(|track| Track {
            track: 5,
            position: track.position.into(),
            velocity: track.velocity.into(),
            time: self.now,
            error_m: self.track_error_m,
        });
        events.push(Event::Tracks(track.into_iter().collect()));
        let json = |state: serde_json::Result<String>| state.ok();
        let gimbal = self
            .gimbal
            .as_ref()
            .map(|gimbal| json(serde_json::to_string(&gimbal.state)));
        let camera = self.camera.as_ref().map(|camera| json(serde_json::to_string(camera)));
        let radio = self.radio.as_ref().map(|radio| json(serde_json::to_string(radio)));
        let reports = [
            ("gimbal", PayloadKind::Gimbal, gimbal),
            ("eye", PayloadKind::Camera, camera),
            ("wifi", PayloadKind::Radio, radio),
        ];
        for (name, kind, state) in reports {
            events.extend(state.map(|state_json| {
                Event::Payload(PayloadReport {
                    name: name.to_owned(),
                    kind,
                    state_json,
                })
            }));
        }
        events.append(&mut self.answers);
        events.append(&mut self.inbox);
        events.push(Event::Tick);
        events
    }

    /// One period.
    pub fn tick(&mut self) -> Vec<Effect> {
        self.now = self.now.plus_seconds(PERIOD_S);
        self.step();
        let events = self.events();
        let mut effects = Effects::default();
        self.model.handle(self.now, &events, &mut effects);
        let effects = effects.take();
        for effect in &effects {
            self.log.push((self.now.as_seconds(), effect.clone()));
            match effect {
                Effect::Setpoint(setpoint) => self.setpoint = Some(*setpoint),
                Effect::StopStream => self.setpoint = None,
                Effect::State { state, .. } => self.state = *state,
                Effect::Autopilot { request, command } => self.obey(*request, *command),
                Effect::PayloadCommand {
                    request,
                    payload,
                    command_json,
                } => {
                    self.payload(*request, payload, command_json);
                }
                _ => {}
            }
        }
        effects
    }

    fn obey(&mut self, request: RequestId, command: AutopilotCommand) {
        let from = self.mode;
        self.mode = match command {
            AutopilotCommand::Land => FlightMode::Land,
            AutopilotCommand::ReturnToLaunch => FlightMode::Return,
            AutopilotCommand::EnterOffboard => FlightMode::Offboard,
            _ => self.mode,
        };
        self.answers.push(Event::AutopilotResult { request, refusal: None });
        if from != self.mode {
            self.answers.push(Event::ModeChanged {
                from,
                to: self.mode,
                commanded: true,
            });
        }
    }

    fn payload(&mut self, request: RequestId, payload: &str, command_json: &str) {
        let mut refusal = None;
        match payload {
            "gimbal" => {
                let command = serde_json::from_str(command_json).expect("a gimbal understands it");
                let gimbal = self.gimbal.as_mut().expect("is there");
                gimbal.told.push((self.now.as_seconds(), command));
                refusal.clone_from(&gimbal.refuses);
                if refusal.is_none() {
                    let (mode, place) = match command {
                        GimbalCommand::PointAt { place } => (GimbalMode::PointAt, Some(place)),
                        _ => (GimbalMode::Idle, None),
                    };
                    (gimbal.state.mode, gimbal.state.place) = (mode, place);
                }
            }
            "eye" => drop(
                serde_json::from_str::<skein_plugin_sdk::domain::payload::CameraCommand>(command_json)
                    .expect("a camera understands it"),
            ),
            other => panic!("no payload {other}"),
        }
        self.answers.push(Event::PayloadResult { request, refusal });
    }

    /// The world goes on by a period.
    fn step(&mut self) {
        for mover in [&mut self.track, &mut self.peer].into_iter().flatten() {
            mover.position += mover.velocity * PERIOD_S;
        }
        if let (FlightMode::Offboard, Some(setpoint)) = (self.mode, self.setpoint) {
            let velocity = setpoint.velocity.map_or(Vector3::zeros(), |v| v.vector());
            let pull = setpoint
                .position
                .map_or(Vector3::zeros(), |p| p.vector() - self.position);
            let wanted = velocity + pull.cap_magnitude(3.0);
            self.velocity += (wanted - self.velocity).cap_magnitude(6.0 * PERIOD_S);
            self.position += self.velocity * PERIOD_S;
            self.yaw_rad = setpoint.yaw_rad.unwrap_or(self.yaw_rad);
        }
        self.turn_gimbal();
    }

    fn turn_gimbal(&mut self) {
        let Some(gimbal) = &mut self.gimbal else { return };
        let most = 1.5 * PERIOD_S;
        let frame = SwarmFrame::new(ORIGIN);
        let (mut pitch, mut yaw) = (0.0, self.yaw_rad);
        if let Some(place) = gimbal.state.place {
            let off = frame.position(&place).vector() - self.position;
            (pitch, yaw) = ((-off.z).atan2(off.xy().norm()), off.y.atan2(off.x));
        }
        if gimbal.fixed_yaw {
            yaw = self.yaw_rad;
        }
        let wrap = skein_plugin_sdk::domain::frames::wrap_angle_rad;
        let now = gimbal.state.yaw_north_rad.unwrap_or(0.0);
        let turned = if gimbal.fixed_yaw {
            yaw
        } else {
            wrap(now + wrap(yaw - now).clamp(-most, most))
        };
        gimbal.state.yaw_north_rad = Some(turned);
        gimbal.state.pitch_rad += (pitch - gimbal.state.pitch_rad).clamp(-most, most);
    }

    pub fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds / PERIOD_S).round() as u32 {
            self.tick();
        }
    }

    pub fn run_until(&mut self, what: &str, limit_s: f64, mut fulfilled: impl FnMut(&Self) -> bool) {
        for _ in 0..(limit_s / PERIOD_S) as u32 {
            if fulfilled(self) {
                return;
            }
            self.tick();
        }
        panic!("not {what} within {limit_s} s: {} {:?}", self.state, self.report());
    }

    pub fn progress(&self, id: CommandId) -> Vec<CommandProgress> {
        let of = |effect: &Effect| match effect {
            Effect::CommandProgress { id: of, progress } if *of == id => Some(progress.clone()),
            _ => None,
        };
        self.log.iter().filter_map(|(_, effect)| of(effect)).collect()
    }

    pub fn is_done(&self, id: CommandId) -> bool {
        self.progress(id).contains(&CommandProgress::Done)
    }

    pub fn refusal(&self, id: CommandId) -> Option<Refusal> {
        self.progress(id).into_iter().find_map(|progress| match progress {
            CommandProgress::Refused { refusal } => Some(refusal),
            _ => None,
        })
    }

    /// The state last reported.
    pub fn report(&self) -> serde_json::Value {
        let json = self.log.iter().rev().find_map(|(_, effect)| match effect {
            Effect::Report { state_json } => Some(state_json.clone()),
            _ => None,
        });
        serde_json::from_str(&json.expect("has reported")).expect("is JSON")
    }

    pub fn notices(&self) -> Vec<String> {
        let text = |effect: &Effect| match effect {
            Effect::Notice { text, .. } => Some(text.clone()),
            _ => None,
        };
        self.log.iter().filter_map(|(_, effect)| text(effect)).collect()
    }

    /// What was asked of payloads: the time, which one, and the command's word.
    pub fn asked(&self, of: &str) -> Vec<String> {
        let word = |effect: &Effect| match effect {
            Effect::PayloadCommand {
                payload, command_json, ..
            } if payload == of => {
                let command: serde_json::Value = serde_json::from_str(command_json).expect("is JSON");
                Some(command["command"].as_str().expect("has a word").to_owned())
            }
            _ => None,
        };
        self.log.iter().filter_map(|(_, effect)| word(effect)).collect()
    }

    pub fn distance_m(&self, mover: Mover) -> f64 {
        (mover.position - self.position).xy().norm()
    }

    /// Fails if setpoints jump since a moment, in place or in velocity.
    pub fn assert_smooth_since(&self, since_s: f64) {
        let setpoints: Vec<(f64, Setpoint)> = self
            .log
            .iter()
            .filter_map(|(time, effect)| match effect {
                Effect::Setpoint(setpoint) if *time >= since_s => Some((*time, *setpoint)),
                _ => None,
            })
            .collect();
        assert!(setpoints.len() > 10);
        let velocity = |setpoint: &Setpoint| setpoint.velocity.unwrap_or_default().vector();
        for pair in setpoints.windows(2) {
            let [(t0, s0), (t1, s1)] = pair else { continue };
            let (p0, p1) = (s0.position.expect("has one"), s1.position.expect("has one"));
            let (v0, v1) = (velocity(s0), velocity(s1));
            let jump_m = (p1.vector() - p0.vector() - (v0 + v1) / 2.0 * (t1 - t0)).norm();
            assert!(jump_m < 0.02, "jump of {jump_m:.3} m at {t1:.2} s: {s0:?} {s1:?}");
            assert!(
                (v1 - v0).norm() < 0.1,
                "velocity changes by {:.2} at {t1:.2} s",
                (v1 - v0).norm()
            );
            assert!(t1 - t0 < 0.03, "no setpoint for {:.2} s at {t1:.2}", t1 - t0);
        }
    }
}
