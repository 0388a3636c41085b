//! Tests of rate and loss.

use super::*;
use crate::frame::Coding;

fn frame(sequence: u64) -> EncodedFrame {
    EncodedFrame {
        coding: Coding::H264,
        sequence,
        taken: NodeTime(0),
        width_px: 640,
        height_px: 480,
        key: false,
        bytes: vec![0; 1_000].into(),
    }
}

#[test]
fn rate_and_loss_are_of_the_last_seconds() {
    let mut meter = Meter::default();
    let mut now = NodeTime(0);
    // thirty a second, of which every fifth is lost
    for sequence in (0..300).filter(|sequence| sequence % 5 != 4) {
        now = NodeTime(sequence * 33_333);
        meter.count(now, &frame(sequence));
    }
    let measured = meter.measured(now);
    assert!((measured.rate_hz - 24.0).abs() < 1.0, "{measured:?}");
    assert!((measured.bytes_per_s - 24_000.0).abs() < 1_500.0, "{measured:?}");
    assert!((measured.lost - 0.2).abs() < 0.02, "{measured:?}");
    let later = meter.measured(now.plus_seconds(3.0));
    assert_eq!(later, Measured::default());
}

#[test]
fn a_camera_that_begins_anew_has_lost_nothing() {
    let mut meter = Meter::default();
    meter.count(NodeTime(0), &frame(500_000));
    meter.count(NodeTime(33_000), &frame(1));
    meter.count(NodeTime(66_000), &frame(100_000));
    assert_eq!(meter.measured(NodeTime(66_000)).lost, 0.0);
}
