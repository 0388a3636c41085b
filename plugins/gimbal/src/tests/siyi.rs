//! The plugin with a SIYI gimbal, whose side of the protocol is spoken here byte by byte.

use crate::{Gimbal, Settings};
use crc::{CRC_16_XMODEM, Crc};
use skein_domain::exchange::{CommandProgress, Create, Effect, Event, OwnState};
use skein_domain::payload::{GimbalCommand, GimbalMode, GimbalState, GimbalYawFrame};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{CommandId, Incarnation, NodeTime, Refusal, VehicleId};
use skein_plugin_sdk::{Effects, Payload};

const TICK_S: f64 = 0.05;
/// Turns so far in a tick, in tenths of a degree.
const STEP: i16 = 30;

/// An A8 mini.
#[derive(Debug, Default)]
struct Device {
    yaw_left: i16,
    pitch: i16,
    wanted: (i16, i16),
    rates: (i8, i8),
    streams: bool,
}

impl Device {
    /// Takes a frame; gives its answer.
    fn take(&mut self, bytes: &[u8]) -> Option<Vec<u8>> {
        let number = |at: usize| i16::from_le_bytes([bytes[8 + at], bytes[9 + at]]);
        match bytes[7] {
            0x01 => Some(answer(0x01, &[3, 2, 0, 0, 5, 1, 0, 0])),
            0x02 => Some(answer(0x02, b"7300000001\0\0")),
            0x07 => {
                self.rates = (bytes[8].cast_signed(), bytes[9].cast_signed());
                Some(answer(0x07, &[1]))
            }
            0x08 => {
                self.wanted = (0, 0);
                Some(answer(0x08, &[1]))
            }
            0x0a => Some(answer(0x0a, &[0, 0, 0, 0, 1, 1, 0])),
            0x0d => Some(self.attitude()),
            0x0e => {
                self.wanted = (number(0), number(2));
                None
            }
            0x25 => {
                self.streams = true;
                Some(answer(0x25, &[1]))
            }
            other => panic!("command {other:#x}"),
        }
    }

    fn attitude(&self) -> Vec<u8> {
        let values = [self.yaw_left, self.pitch, 0, 0, 0, 0];
        answer(
            0x0d,
            &values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>(),
        )
    }

    fn step(&mut self) {
        if self.rates == (0, 0) {
            self.yaw_left += (self.wanted.0 - self.yaw_left).clamp(-STEP, STEP);
            self.pitch += (self.wanted.1 - self.pitch).clamp(-STEP, STEP);
        } else {
            self.yaw_left -= i16::from(self.rates.0) / 4;
            self.pitch = (self.pitch + i16::from(self.rates.1) / 4).clamp(-900, 250);
            self.wanted = (self.yaw_left, self.pitch);
        }
    }
}

fn answer(command: u8, data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0x55, 0x66, 2, data.len() as u8, 0, 0, 0, command];
    bytes.extend(data);
    let checksum = Crc::<u16>::new(&CRC_16_XMODEM).checksum(&bytes);
    bytes.extend(checksum.to_le_bytes());
    bytes
}

struct Bench {
    gimbal: Gimbal,
    device: Device,
    time_s: f64,
    vehicle_yaw_rad: f64,
    unplugged: bool,
    effects: Vec<Effect>,
    commands: u64,
}

impl Bench {
    fn new() -> Self {
        let create = Create {
            vehicle: VehicleId(1),
            incarnation: Incarnation(1),
            config_json: r#"{"backend": "siyi"}"#.to_owned(),
            snapshot: None,
            now: NodeTime::from_seconds(5.0),
            payload: Some("gimbal".to_owned()),
            system_id: None,
        };
        let settings: Settings = serde_json::from_str(&create.config_json).unwrap();
        let mut bench = Self {
            gimbal: Gimbal::create(create, settings).unwrap(),
            device: Device::default(),
            time_s: 5.0,
            vehicle_yaw_rad: 0.0,
            unplugged: false,
            effects: Vec::new(),
            commands: 0,
        };
        bench.run(1.0);
        bench
    }

    fn run(&mut self, seconds: f64) {
        for tick in 0..(seconds / TICK_S).round() as u32 {
            self.time_s += TICK_S;
            self.device.step();
            let own = OwnState {
                kinematics: Some(VehicleKinematics {
                    yaw_rad: self.vehicle_yaw_rad,
                    ..VehicleKinematics::default()
                }),
                ..OwnState::default()
            };
            let mut events = vec![Event::Own(own)];
            if self.device.streams && tick % 2 == 0 && !self.unplugged {
                events.push(Event::Received {
                    bytes: self.device.attitude(),
                });
            }
            events.push(Event::Tick);
            self.tell(&events);
        }
    }

    fn tell(&mut self, events: &[Event]) {
        let mut effects = Effects::default();
        self.gimbal
            .handle(NodeTime::from_seconds(self.time_s), events, &mut effects);
        self.carry_out(effects);
    }

    fn carry_out(&mut self, mut effects: Effects) {
        let mut answers = Vec::new();
        for effect in effects.take() {
            if let Effect::Transmit { bytes } = &effect
                && !self.unplugged
            {
                answers.extend(self.device.take(bytes).map(|bytes| Event::Received { bytes }));
            }
            self.effects.push(effect);
        }
        if !answers.is_empty() {
            self.tell(&answers);
        }
    }

    fn command(&mut self, command: GimbalCommand) -> CommandId {
        self.commands += 1;
        let id = CommandId(self.commands);
        let mut effects = Effects::default();
        self.gimbal
            .command(NodeTime::from_seconds(self.time_s), id, command, &mut effects);
        self.carry_out(effects);
        id
    }

    fn ended(&self, id: CommandId) -> Option<Result<(), Refusal>> {
        self.effects.iter().find_map(|effect| match effect {
            Effect::CommandProgress { id: of, progress } if *of == id => match progress {
                CommandProgress::Executing => None,
                CommandProgress::Done => Some(Ok(())),
                CommandProgress::Refused { refusal } => Some(Err(refusal.clone())),
            },
            _ => None,
        })
    }

    fn state(&self) -> GimbalState {
        let mut reports = self.effects.iter().rev().filter_map(|effect| match effect {
            Effect::Report { state_json } => serde_json::from_str(state_json).ok(),
            _ => None,
        });
        reports.next().expect("a report")
    }
}

fn angles(pitch_deg: f64, yaw_deg: f64, yaw_frame: GimbalYawFrame) -> GimbalCommand {
    GimbalCommand::Angles {
        pitch_rad: pitch_deg.to_radians(),
        yaw_rad: yaw_deg.to_radians(),
        yaw_frame,
    }
}

#[test]
fn it_is_found_and_turned() {
    let mut bench = Bench::new();
    assert_eq!(bench.state().model, "SIYI A8 mini 0.1.5");
    let id = bench.command(angles(-45.0, 30.0, GimbalYawFrame::Vehicle));
    assert_eq!(bench.ended(id), None);
    bench.run(2.0);
    assert_eq!(bench.ended(id), Some(Ok(())));
    assert_eq!((bench.device.pitch, bench.device.yaw_left), (-450, -300));
    let id = bench.command(angles(40.0, 170.0, GimbalYawFrame::Vehicle));
    bench.run(5.0);
    assert_eq!(bench.ended(id), Some(Ok(())));
    assert_eq!(
        (bench.device.pitch, bench.device.yaw_left),
        (250, -1350),
        "as far as it goes"
    );
    assert!((bench.state().wanted_pitch_rad.unwrap() - 25_f64.to_radians()).abs() < 1e-3);
    let id = bench.command(GimbalCommand::Neutral);
    bench.run(4.0);
    assert_eq!(bench.ended(id), Some(Ok(())));
    assert_eq!((bench.device.pitch, bench.device.yaw_left), (0, 0));
}

#[test]
fn north_is_held_while_the_vehicle_turns() {
    let mut bench = Bench::new();
    let id = bench.command(angles(-10.0, 20.0, GimbalYawFrame::North));
    bench.run(2.0);
    assert_eq!(bench.ended(id), Some(Ok(())));
    for _ in 0..40 {
        bench.vehicle_yaw_rad += 0.02;
        bench.run(TICK_S);
    }
    bench.run(0.5);
    let north_deg = bench.vehicle_yaw_rad.to_degrees() - f64::from(bench.device.yaw_left) * 0.1;
    assert!((north_deg - 20.0).abs() < 0.2, "{north_deg}");
}

#[test]
fn rates_end_with_the_next_angles() {
    let mut bench = Bench::new();
    let id = bench.command(GimbalCommand::Rates {
        pitch_rad_s: 0.0,
        yaw_rad_s: 0.5,
    });
    bench.run(1.0);
    assert_eq!(bench.ended(id), Some(Ok(())));
    assert_eq!(bench.device.rates, (32, 0));
    assert_eq!(bench.state().mode, GimbalMode::Rates);
    assert!(bench.state().yaw_vehicle_rad > 0.1);
    let id = bench.command(angles(0.0, 5.0, GimbalYawFrame::Vehicle));
    bench.run(2.0);
    assert_eq!(bench.ended(id), Some(Ok(())));
    assert_eq!(bench.device.rates, (0, 0));
}

#[test]
fn unplugged_it_is_lost_and_then_goes_on() {
    let mut bench = Bench::new();
    let id = bench.command(angles(-45.0, 0.0, GimbalYawFrame::Vehicle));
    bench.run(2.0);
    assert_eq!(bench.ended(id), Some(Ok(())));
    bench.unplugged = true;
    bench.run(3.0);
    assert!(!bench.state().connected);
    let id = bench.command(GimbalCommand::Neutral);
    assert!(matches!(bench.ended(id), Some(Err(Refusal::NotRunning { .. }))));
    // It was switched off meanwhile: level again, and streams nothing.
    bench.device = Device::default();
    bench.unplugged = false;
    bench.run(5.0);
    assert!(bench.state().connected);
    assert_eq!(bench.device.pitch, -450);
}
