//! A gimbal that speaks SIYI's protocol.
//!
//! Its angles count in tenths of a degree, yaw from the vehicle's nose and to the left; its rates in hundredths of full deflection, yaw to
//! the right. It has no hold on north: while one is asked for, the angle from the nose is sent anew as the vehicle turns.

mod frame;

use crate::attitude::{Attitude, Limits, Yaw};
use crate::orders::{Moment, Status, Turn};
use frame::{Frame, Parser, command};
use minicbor::{Decode, Encode};
use skein_domain::NodeTime;
use skein_domain::frames::wrap_angle_rad;
use skein_domain::payload::GimbalOwner;
use skein_plugin_sdk::Effects;
use std::f64::consts::PI;

/// Pause between two questions about what the device is and how it is set, in seconds. It keeps the connection alive too.
const QUESTION_PAUSE_S: f64 = 1.0;
/// The attitude is asked for when none came for this long, in seconds: old firmware does not stream it.
const ATTITUDE_PAUSE_S: f64 = 0.25;
/// The stream is asked for again after this time without it, in seconds.
const STREAM_PAUSE_S: f64 = 2.0;
/// Attitude, ten times a second.
const STREAM_ATTITUDE_10_HZ: [u8; 2] = [1, 4];
const MODE_LOCK: u8 = 0;
const MODE_FPV: u8 = 2;
const FUNCTION_FOLLOW_MODE: u8 = 4;
const UPSIDE_DOWN: u8 = 2;

/// Travel of the models by the first two characters of their hardware id: name, pitch and yaw from the manuals, in degrees.
const MODELS: [(&[u8; 2], &str, [f64; 4]); 6] = [
    (b"75", "A2 mini", [-90.0, 25.0, 0.0, 0.0]),
    (b"73", "A8 mini", [-90.0, 25.0, -135.0, 135.0]),
    (b"6B", "ZR10", [-90.0, 25.0, -135.0, 135.0]),
    (b"78", "ZR30", [-90.0, 25.0, -270.0, 270.0]),
    (b"83", "ZT6", [-90.0, 25.0, -270.0, 270.0]),
    (b"7A", "ZT30", [-90.0, 25.0, -270.0, 270.0]),
];

/// The client of a SIYI gimbal.
#[derive(Debug, Clone, PartialEq, Default, Encode, Decode)]
pub(crate) struct Siyi {
    #[n(0)]
    sequence: u16,
    #[n(1)]
    heard: Option<NodeTime>,
    #[n(2)]
    attitude: Option<Attitude>,
    /// First characters of its hardware id.
    #[n(3)]
    hardware: Option<[u8; 2]>,
    #[n(4)]
    firmware: String,
    #[n(5)]
    motion_mode: Option<u8>,
    #[n(6)]
    upside_down: bool,
    #[n(7)]
    last_question: Option<NodeTime>,
    #[n(8)]
    last_attitude_question: Option<NodeTime>,
    #[n(9)]
    last_stream_question: Option<NodeTime>,
    /// Turns at rates: they must be ended before angles are obeyed.
    #[n(10)]
    turning: bool,
    #[n(11)]
    last_mode_question: Option<NodeTime>,
    /// Bytes of a frame that is not complete. Not in the snapshot: the next frame is found without them.
    #[cbor(skip)]
    parser: Parser,
}

impl Siyi {
    pub(crate) fn status(&self, at: &Moment) -> Status {
        let model = self.model();
        let name = match (model, self.hardware) {
            (Some((_, name, _)), _) => format!("SIYI {name}"),
            (None, Some(id)) => format!("SIYI {}", String::from_utf8_lossy(&id)),
            (None, None) => String::new(),
        };
        Status {
            connected: at.within(self.heard, at.settings.lost_after_s),
            owner: GimbalOwner::Unknown,
            attitude: self.attitude,
            at_end_stop: false,
            by_servos: false,
            limits: model.map(|(_, _, travel)| limits(*travel)),
            model: format!("{name} {}", self.firmware).trim().to_owned(),
            fault: String::new(),
        }
    }

    fn model(&self) -> Option<&'static (&'static [u8; 2], &'static str, [f64; 4])> {
        self.hardware
            .and_then(|id| MODELS.iter().find(|(known, ..)| **known == id))
    }

    pub(crate) fn hear(&mut self, at: &Moment, bytes: &[u8]) {
        for frame in self.parser.feed(bytes) {
            self.heard = Some(at.now);
            self.take(at, &frame);
        }
    }

    fn take(&mut self, at: &Moment, frame: &Frame) {
        match (frame.command, frame.data.as_slice()) {
            (command::ATTITUDE, data) if data.len() >= 6 => self.take_attitude(at, data),
            (command::ANGLES, data) if data.len() >= 6 => self.take_attitude(at, data),
            (command::HARDWARE, &[first, second, ..]) => self.hardware = Some([first, second]),
            (command::FIRMWARE, &[_, _, _, _, patch, minor, major, ..]) => {
                self.firmware = format!("{major}.{minor}.{patch}");
            }
            (command::CONFIGURATION, &[_, _, _, _, mode, mounting, ..]) => {
                self.motion_mode = Some(mode);
                self.upside_down = mounting == UPSIDE_DOWN;
            }
            _ => {}
        }
    }

    fn take_attitude(&mut self, at: &Moment, data: &[u8]) {
        let mut angles = data.chunks_exact(2).map(|pair| match *pair {
            [low, high] => (f64::from(i16::from_le_bytes([low, high])) * 0.1).to_radians(),
            _ => 0.0,
        });
        let (Some(left), Some(pitch), Some(roll)) = (angles.next(), angles.next(), angles.next()) else {
            return;
        };
        // Mounted upside down it reports level as half a turn.
        let (yaw, pitch, roll) = if self.upside_down {
            (left, -wrap_angle_rad(pitch + PI), wrap_angle_rad(roll + PI))
        } else {
            (-left, pitch, roll)
        };
        self.attitude = Some(Attitude {
            heard: at.now,
            roll_rad: roll,
            pitch_rad: pitch,
            yaw: Yaw::Vehicle(wrap_angle_rad(yaw)),
        });
    }

    pub(crate) fn work(&mut self, at: &Moment, effects: &mut Effects) {
        if !at.within(self.last_question, QUESTION_PAUSE_S) {
            self.last_question = Some(at.now);
            if self.hardware.is_none() {
                self.send(command::HARDWARE, &[], effects);
            }
            if self.firmware.is_empty() {
                self.send(command::FIRMWARE, &[], effects);
            }
            self.send(command::CONFIGURATION, &[], effects);
        }
        let attitude = self.attitude.map(|attitude| attitude.heard);
        if !at.within(attitude, STREAM_PAUSE_S) && !at.within(self.last_stream_question, STREAM_PAUSE_S) {
            self.last_stream_question = Some(at.now);
            self.send(command::STREAM, &STREAM_ATTITUDE_10_HZ, effects);
        }
        if !at.within(attitude, ATTITUDE_PAUSE_S) && !at.within(self.last_attitude_question, ATTITUDE_PAUSE_S) {
            self.last_attitude_question = Some(at.now);
            self.send(command::ATTITUDE, &[], effects);
        }
    }

    pub(crate) fn turn(&mut self, at: &Moment, turn: Turn, effects: &mut Effects) {
        if matches!(self.motion_mode, Some(MODE_LOCK | MODE_FPV))
            && !at.within(self.last_mode_question, QUESTION_PAUSE_S)
        {
            // Only in follow mode do its angles mean what ours mean: level to the horizon, yaw from the nose.
            self.last_mode_question = Some(at.now);
            self.send(command::FUNCTION, &[FUNCTION_FOLLOW_MODE], effects);
        }
        match turn {
            Turn::At(rates) => {
                let deflection =
                    |rate: f64| (100.0 * rate / at.settings.rate_max_rad_s).round().clamp(-100.0, 100.0) as i8;
                let (yaw, pitch) = (deflection(rates.yaw_rad_s), deflection(rates.pitch_rad_s));
                self.turning = yaw != 0 || pitch != 0;
                self.send(
                    command::RATES,
                    &[yaw.to_le_bytes(), pitch.to_le_bytes()].concat(),
                    effects,
                );
            }
            Turn::Once(direction) | Turn::To(direction) => {
                if std::mem::take(&mut self.turning) {
                    self.send(command::RATES, &[0, 0], effects);
                }
                let Some(from_nose) = direction.yaw.off_nose(at.vehicle_yaw_rad) else {
                    return;
                };
                let left = if self.upside_down { from_nose } else { -from_nose };
                if left == 0.0 && direction.pitch_rad == 0.0 {
                    self.send(command::CENTRE, &[1], effects);
                    return;
                }
                let tenths = |angle: f64| ((angle.to_degrees() * 10.0).round() as i16).to_le_bytes();
                self.send(
                    command::ANGLES,
                    &[tenths(left), tenths(direction.pitch_rad)].concat(),
                    effects,
                );
            }
        }
    }

    fn send(&mut self, command: u8, data: &[u8], effects: &mut Effects) {
        effects.transmit(frame::encode(self.sequence, command, data));
        self.sequence = self.sequence.wrapping_add(1);
    }
}

fn limits([pitch_min, pitch_max, yaw_min, yaw_max]: [f64; 4]) -> Limits {
    let turns_all_round = yaw_max - yaw_min >= 360.0;
    Limits {
        pitch_min_rad: pitch_min.to_radians(),
        pitch_max_rad: pitch_max.to_radians(),
        yaw_min_rad: (!turns_all_round).then_some(yaw_min.to_radians()),
        yaw_max_rad: (!turns_all_round).then_some(yaw_max.to_radians()),
    }
}

#[cfg(test)]
mod tests;
