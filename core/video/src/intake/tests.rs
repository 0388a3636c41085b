//! Tests of what is taken of a camera.

use super::*;
use crate::h264::START_CODE;

const SPS: &[u8] = &[
    0x67, 0x64, 0x00, 0x1f, 0xac, 0xd9, 0x40, 0x50, 0x05, 0xbb, 0x01, 0x10, 0x00, 0x00, 0x03, 0x00, 0x10, 0x00, 0x00,
    0x03, 0x03, 0xc0, 0xf1, 0x83, 0x19, 0x60,
];
const PPS: &[u8] = &[0x68, 0xeb, 0xe3];
const IDR: &[u8] = &[0x65, 0x88, 0x84];
const OTHER: &[u8] = &[0x41, 0x9a, 0x02];

fn units(units: &[&[u8]]) -> Vec<u8> {
    units.iter().flat_map(|unit| [&START_CODE[..], unit].concat()).collect()
}

#[test]
fn parameter_sets_told_once_stand_before_every_key_picture() {
    let mut intake = Intake::default();
    let now = NodeTime(1);
    assert_eq!(intake.take(0, now, &units(&[IDR])), Err(FrameFault::NoParameterSet));
    let first = intake.take(1, now, &units(&[SPS, PPS, IDR])).expect("taken");
    assert_eq!(first.bytes.as_ref(), units(&[SPS, PPS, IDR]));
    let second = intake.take(2, now, &units(&[OTHER])).expect("taken");
    assert!(!second.key && second.bytes.as_ref() == units(&[OTHER]));
    let third = intake.take(3, now, &units(&[IDR])).expect("taken");
    assert!(third.key && third.bytes.as_ref() == units(&[SPS, PPS, IDR]));
}

#[test]
fn pictures_that_are_too_large_are_not_taken() {
    let mut bytes = units(&[SPS, PPS, IDR]);
    bytes.resize(MOST_BYTES + 1, 7);
    let refused = Intake::default().take(0, NodeTime(0), &bytes);
    assert!(matches!(refused, Err(FrameFault::TooLarge { .. })));
}
