//! Tests of the SIYI client: its frames against published ones, its parser against anything.

use super::frame::{Frame, Parser, command, encode};
use super::*;
use crate::attitude::Direction;
use crate::settings::{Backend, Settings};
use proptest::prelude::*;
use skein_domain::exchange::Effect;

fn hex(text: &str) -> Vec<u8> {
    let digits: Vec<u8> = text.bytes().filter(|c| *c != b' ').collect();
    let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
    digits.chunks(2).map(byte).collect()
}

/// The examples of the maker's SDK manual.
#[test]
fn frames_are_as_published() {
    for (command, data, published) in [
        (command::FIRMWARE, &[][..], "55 66 01 00 00 00 00 01 64 c4"),
        (command::HARDWARE, &[], "55 66 01 00 00 00 00 02 07 f4"),
        (command::RATES, &[100, 100], "55 66 01 02 00 00 00 07 64 64 3d cf"),
        (command::CENTRE, &[1], "55 66 01 01 00 00 00 08 01 d1 12"),
        (command::CONFIGURATION, &[], "55 66 01 00 00 00 00 0a 0f 75"),
        (
            command::FUNCTION,
            &[FUNCTION_FOLLOW_MODE],
            "55 66 01 01 00 00 00 0c 04 b0 8e",
        ),
        (command::ATTITUDE, &[], "55 66 01 00 00 00 00 0d e8 05"),
        (
            command::ANGLES,
            &[0x00, 0x00, 0xff, 0xa6],
            "55 66 01 04 00 00 00 0e 00 00 ff a6 3b 11",
        ),
    ] {
        let bytes = hex(published);
        assert_eq!(encode(0, command, data), bytes, "command {command:#x}");
        let frames = Parser::default().feed(&bytes);
        assert_eq!(
            frames,
            [Frame {
                command,
                data: data.to_vec()
            }]
        );
    }
}

fn at(seconds: f64, settings: &Settings) -> Moment<'_> {
    Moment {
        now: NodeTime::from_seconds(seconds),
        settings,
        vehicle_yaw_rad: Some(0.5),
        vehicle_roll_pitch_rad: None,
    }
}

fn siyi() -> Settings {
    Settings {
        backend: Backend::Siyi,
        ..Settings::default()
    }
}

fn sent(effects: &mut Effects) -> Vec<Frame> {
    let mut parser = Parser::default();
    let effects = effects.take();
    let bytes = effects.iter().filter_map(|effect| match effect {
        Effect::Transmit { bytes } => Some(bytes.as_slice()),
        _ => None,
    });
    bytes.flat_map(|bytes| parser.feed(bytes)).collect()
}

fn angles(values: &[i16]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

#[test]
fn attitude_is_in_tenths_of_a_degree_and_to_the_left() {
    let settings = siyi();
    let mut siyi = Siyi::default();
    siyi.hear(
        &at(1.0, &settings),
        &encode(3, command::ATTITUDE, &angles(&[605, -200, 10, 5, -5, 0])),
    );
    let attitude = siyi.attitude.unwrap();
    assert!((attitude.pitch_rad - (-20.0_f64).to_radians()).abs() < 1e-9);
    assert!((attitude.roll_rad - 1.0_f64.to_radians()).abs() < 1e-9);
    let yaw = attitude.yaw.off_nose(None).unwrap();
    assert!((yaw + 60.5_f64.to_radians()).abs() < 1e-9, "{yaw}");
    assert!(siyi.status(&at(1.1, &settings)).connected);
    assert!(!siyi.status(&at(9.0, &settings)).connected);
}

#[test]
fn upside_down_level_is_level() {
    let settings = siyi();
    let mut siyi = Siyi::default();
    siyi.hear(
        &at(1.0, &settings),
        &encode(0, command::CONFIGURATION, &[0, 0, 0, 0, 1, UPSIDE_DOWN, 0]),
    );
    siyi.hear(
        &at(1.0, &settings),
        &encode(1, command::ATTITUDE, &angles(&[100, 1800, 1800, 0, 0, 0])),
    );
    let attitude = siyi.attitude.unwrap();
    assert!(
        attitude.pitch_rad.abs() < 1e-9 && attitude.roll_rad.abs() < 1e-9,
        "{attitude:?}"
    );
    let yaw = attitude.yaw.off_nose(None).unwrap();
    assert!((yaw - 10.0_f64.to_radians()).abs() < 1e-9, "{yaw}");
}

#[test]
fn says_what_it_is() {
    let settings = siyi();
    let mut siyi = Siyi::default();
    siyi.hear(&at(1.0, &settings), &encode(0, command::HARDWARE, b"7308210001\0\0"));
    siyi.hear(
        &at(1.0, &settings),
        &encode(1, command::FIRMWARE, &[5, 2, 0, 0x6e, 7, 3, 1, 0x73]),
    );
    let status = siyi.status(&at(1.0, &settings));
    assert_eq!(status.model, "SIYI A8 mini 1.3.7");
    let limits = status.limits.unwrap();
    assert!((limits.pitch_max_rad - 25.0_f64.to_radians()).abs() < 1e-9);
    assert!((limits.yaw_max_rad.unwrap() - 135.0_f64.to_radians()).abs() < 1e-9);
}

#[test]
fn north_is_held_by_the_angle_from_the_nose() {
    let settings = siyi();
    let (mut siyi, mut effects) = (Siyi::default(), Effects::default());
    let direction = Direction {
        pitch_rad: (-30.0_f64).to_radians(),
        yaw: Yaw::North(0.5 + 10.0_f64.to_radians()),
    };
    siyi.turn(&at(1.0, &settings), Turn::To(direction), &mut effects);
    assert_eq!(
        sent(&mut effects),
        [Frame {
            command: command::ANGLES,
            data: angles(&[-100, -300])
        }]
    );
}

#[test]
fn rates_end_before_angles() {
    let settings = siyi();
    let (mut siyi, mut effects) = (Siyi::default(), Effects::default());
    let rates = crate::aim::Rates {
        pitch_rad_s: -settings.rate_max_rad_s,
        yaw_rad_s: settings.rate_max_rad_s * 0.5,
    };
    siyi.turn(&at(1.0, &settings), Turn::At(rates), &mut effects);
    assert_eq!(
        sent(&mut effects),
        [Frame {
            command: command::RATES,
            data: vec![50, 156]
        }]
    );
    let level = Direction {
        pitch_rad: 0.0,
        yaw: Yaw::Vehicle(0.0),
    };
    siyi.turn(&at(2.0, &settings), Turn::To(level), &mut effects);
    let commands: Vec<u8> = sent(&mut effects).iter().map(|frame| frame.command).collect();
    assert_eq!(commands, [command::RATES, command::CENTRE]);
}

#[test]
fn keeps_in_touch_and_asks_for_what_is_missing() {
    let settings = siyi();
    let (mut siyi, mut effects) = (Siyi::default(), Effects::default());
    let mut asked = std::collections::BTreeMap::<u8, usize>::new();
    for tick in 0..200 {
        siyi.work(&at(f64::from(tick) * 0.05, &settings), &mut effects);
        for frame in sent(&mut effects) {
            *asked.entry(frame.command).or_default() += 1;
        }
    }
    assert!((9..=11).contains(&asked[&command::CONFIGURATION]), "{asked:?}");
    assert!((4..=6).contains(&asked[&command::STREAM]), "{asked:?}");
    assert!(asked[&command::ATTITUDE] >= 25, "{asked:?}");
}

proptest! {
    #[test]
    fn frames_are_found_in_whatever_pieces_they_come(
        contents in prop::collection::vec((any::<u8>(), prop::collection::vec(any::<u8>(), 0..40)), 1..8),
        cuts in prop::collection::vec(1_usize..20, 1..40),
        garbage in prop::collection::vec(prop::sample::select(vec![0_u8, 0x66, 0xff, 0x01]), 0..20),
    ) {
        // Without a first byte of a start in it, so that it cannot look like the beginning of a frame.
        let mut stream = garbage.clone();
        for (sequence, (command, data)) in contents.iter().enumerate() {
            stream.extend(encode(sequence as u16, *command, data));
            stream.extend(&garbage);
        }
        let mut parser = Parser::default();
        let mut found = Vec::new();
        let mut rest = stream.as_slice();
        for cut in cuts.iter().cycle() {
            if rest.is_empty() {
                break;
            }
            let (now, later) = rest.split_at((*cut).min(rest.len()));
            found.extend(parser.feed(now));
            rest = later;
        }
        let wanted: Vec<Frame> = contents.into_iter().map(|(command, data)| Frame { command, data }).collect();
        prop_assert_eq!(found, wanted);
    }

    #[test]
    fn a_frame_is_found_after_any_garbage(garbage in prop::collection::vec(any::<u8>(), 0..400), data in prop::collection::vec(any::<u8>(), 0..40)) {
        let mut parser = Parser::default();
        parser.feed(&garbage);
        // A beginning in the garbage can swallow the frame until as much as it claims has come.
        let wanted = Frame { command: 9, data };
        let bytes = encode(0, wanted.command, &wanted.data);
        let times = 300 / bytes.len() + 2;
        let found: Vec<Frame> = (0..times).flat_map(|_| parser.feed(&bytes)).collect();
        prop_assert!(found.contains(&wanted));
    }

    #[test]
    fn no_bytes_make_it_panic(pieces in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..100), 0..10)) {
        let settings = siyi();
        let mut siyi = Siyi::default();
        for bytes in pieces {
            siyi.hear(&at(1.0, &settings), &bytes);
        }
    }

    #[test]
    fn no_data_make_it_panic(command in any::<u8>(), data in prop::collection::vec(any::<u8>(), 0..40)) {
        let settings = siyi();
        let mut siyi = Siyi::default();
        siyi.hear(&at(1.0, &settings), &encode(0, command, &data));
        prop_assert!(siyi.status(&at(1.0, &settings)).connected);
    }
}
