//! Tests of how a picture is packed.

use super::*;

#[test]
fn a_picture_comes_out_as_it_went_in() {
    let frame = EncodedFrame {
        coding: Coding::H264,
        sequence: 70_000,
        taken: NodeTime(123_456_789),
        width_px: 1280,
        height_px: 720,
        key: true,
        bytes: vec![0, 0, 0, 1, 0x65, 9].into(),
    };
    let mut picture = VideoPicture {
        stream: 3,
        key: true,
        after_gap: false,
        body: packed(&frame),
    };
    assert_eq!(unpacked(&picture), Some(frame));
    picture.body.truncate(3);
    assert_eq!(unpacked(&picture), None);
}
