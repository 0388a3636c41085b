//! Tests of what is found in access units.

use super::*;
use proptest::prelude::*;

/// Sequence parameter set of a 1280x720 stream, high profile, level 3.1, as x264 writes it.
const SPS_HIGH: &[u8] = &[
    0x67, 0x64, 0x00, 0x1f, 0xac, 0xd9, 0x40, 0x50, 0x05, 0xbb, 0x01, 0x10, 0x00, 0x00, 0x03, 0x00, 0x10, 0x00, 0x00,
    0x03, 0x03, 0xc0, 0xf1, 0x83, 0x19, 0x60,
];

fn unit(bytes: &[u8]) -> Vec<u8> {
    [&START_CODE[..], bytes].concat()
}

#[test]
fn a_parameter_set_tells_the_format() {
    let bytes = [unit(SPS_HIGH), unit(&[0x68, 0xeb, 0xe3]), unit(&[0x65, 0x88, 0x84])].concat();
    let found = contents(&bytes).expect("a picture");
    assert!(found.idr && found.slices);
    let format = found.format.expect("a format");
    assert_eq!((format.width_px, format.height_px), (1280, 720));
    assert_eq!(format.codec(), "avc1.64001f");
    assert_eq!(
        found.parameter_sets,
        [unit(SPS_HIGH), unit(&[0x68, 0xeb, 0xe3])].concat()
    );
}

#[test]
fn what_is_no_picture_is_refused() {
    assert_eq!(contents(&[]), Err(H264Error::Empty));
    assert_eq!(contents(&[1, 2, 3]), Err(H264Error::NoSlice));
    assert_eq!(contents(&unit(&[0x68, 0xeb])), Err(H264Error::NoSlice));
    let cut = contents(&unit(&SPS_HIGH[..6]));
    assert!(matches!(cut, Err(H264Error::BadParameterSet(_))), "{cut:?}");
}

#[test]
fn short_start_codes_are_start_codes() {
    let found = contents(&[0, 0, 1, 0x41, 0x9a, 0x02]).expect("a picture");
    assert!(found.slices && !found.idr && found.format.is_none());
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = contents(&bytes);
        let _ = contents(&unit(&bytes));
        let _ = contents(&[unit(&[0x67]), bytes].concat());
    }
}
