//! Tests of encoding and decoding, of damaged pictures too.

use super::*;
use crate::h264::contents;
use crate::intake::Intake;
use proptest::prelude::*;
use skein_domain::payload::{FrameHeader, PixelFormat};

/// A picture with a bright square that moves.
fn picture(step: usize) -> Planes {
    let (width, height) = (96, 64);
    let mut grey = vec![40; width * height];
    for row in 16..32 {
        for column in 0..16 {
            grey[row * width + (step * 4) % 64 + column] = 220;
        }
    }
    let header = FrameHeader {
        width_px: 96,
        height_px: 64,
        format: PixelFormat::Gray8,
        ..FrameHeader::default()
    };
    Planes::of_frame(&header, &grey).expect("pixels")
}

fn encoded(count: u64, key_at: Option<u64>) -> Vec<Encoded> {
    let mut encoder = H264Encoder::new((96, 64), 30.0).expect("an encoder");
    let of = |step: u64| {
        let taken = NodeTime(step * 33_333);
        encoder.encode(taken, &picture(step as usize), key_at == Some(step))
    };
    (0..count)
        .map(of)
        .map(|made| made.expect("encoded").expect("a picture"))
        .collect()
}

#[test]
fn what_is_encoded_is_decoded_again() {
    let mut decoder = H264Decoder::new().expect("a decoder");
    for (step, made) in encoded(20, None).iter().enumerate() {
        let planes = decoder.decode(&made.bytes).expect("decoded").expect("a picture");
        assert_eq!(planes.size_px(), (96, 64));
        let original = picture(step);
        let error = planes.rows(20).0.iter().zip(original.rows(20).0);
        let worst = error.map(|(a, b)| a.abs_diff(*b)).max();
        assert!(worst < Some(80), "step {step}: {worst:?}");
    }
}

#[test]
fn key_pictures_come_by_time_and_when_asked_for() {
    let keys = |made: &[Encoded]| -> Vec<usize> {
        let keys = made.iter().enumerate().filter(|(_, one)| one.key);
        keys.map(|(step, _)| step).collect()
    };
    assert_eq!(keys(&encoded(70, None)), [0, 61]);
    assert_eq!(keys(&encoded(40, Some(7))), [0, 7]);
}

#[test]
fn a_decoder_can_begin_with_each_key_picture() {
    for made in encoded(10, Some(5)).iter().filter(|made| made.key) {
        let found = contents(&made.bytes).expect("a picture");
        let format = found.format.expect("a format");
        assert!(found.idr && (format.width_px, format.height_px) == (96, 64));
        assert!(format.codec().starts_with("avc1.42"), "{}", format.codec());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Damaged pictures are refused or decoded to something; the next key picture sets it right.
    #[test]
    fn damage_ends_with_the_next_key_picture(at in any::<prop::sample::Index>(), with in any::<u8>(), cut in any::<prop::sample::Index>()) {
        let made = encoded(4, Some(3));
        let mut decoder = H264Decoder::new().expect("a decoder");
        let mut intake = Intake::default();
        for one in &made[..3] {
            let mut bytes = one.bytes.clone();
            let place = at.index(bytes.len());
            bytes[place] ^= with;
            bytes.truncate(cut.index(bytes.len()) + 1);
            let _ = intake.take(1, NodeTime(0), &bytes);
            let _ = decoder.decode(&bytes);
        }
        let taken = intake.take(2, NodeTime(0), &made[3].bytes).expect("a whole picture");
        prop_assert!(taken.key && taken.width_px == 96);
        prop_assert!(matches!(decoder.decode(&made[3].bytes), Ok(Some(_))));
    }
}
