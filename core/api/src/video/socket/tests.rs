//! Tests of the header before each picture.

use super::*;
use skein_video::EncodedFrame;
use std::sync::Arc;

#[test]
fn the_header_has_its_fields_at_their_places() {
    let frame = EncodedFrame {
        coding: Coding::H264,
        sequence: 0x0102_0304,
        taken: NodeTime(1_500_000),
        width_px: 640,
        height_px: 480,
        key: true,
        bytes: vec![9, 8, 7].into(),
    };
    let given = Given {
        frame: Arc::new(frame),
        after_gap: true,
    };
    let message = picture(&given, 5, NodeTime(1_520_000));
    assert_eq!(message.len(), HEADER_BYTES + 3);
    assert_eq!(message[..4], [1, 1, 0b11, 0]);
    assert_eq!(message[4..8], [0x80, 0x02, 0xe0, 0x01]);
    assert_eq!(message[8..12], [4, 3, 2, 1]);
    assert_eq!(message[12..16], 20_000_u32.to_le_bytes());
    assert_eq!(message[16..24], 1_500_000_f64.to_le_bytes());
    assert_eq!(message[24..32], [5, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(message[32..], [9, 8, 7]);
}
