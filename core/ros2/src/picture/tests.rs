//! A picture is a JPEG of its own size, and a header that lies makes none.

use super::*;
use proptest::prelude::*;

fn header(width_px: u32, height_px: u32, format: PixelFormat) -> FrameHeader {
    FrameHeader {
        width_px,
        height_px,
        format,
        stride_bytes: 0,
        ..FrameHeader::default()
    }
}

#[test]
fn pixels_become_a_jpeg_of_the_same_size() {
    let picture = jpeg(&header(16, 8, PixelFormat::Rgb8), &[90; 16 * 8 * 3]).expect("a picture");
    let read = image::load_from_memory(&picture).expect("readable");
    assert_eq!((read.width(), read.height()), (16, 8));
    assert_eq!(jpeg(&header(16, 8, PixelFormat::Rgb8), &[90; 16 * 7 * 3]), None);
    assert_eq!(jpeg(&header(16, 8, PixelFormat::Jpeg), &[1, 2]), Some(vec![1, 2]));
}

#[test]
fn a_pinhole_from_the_field_of_view() {
    let mut of = header(200, 100, PixelFormat::Gray8);
    assert_eq!(info(Header::default(), &of).k.0, [0.0; 9]);
    of.pose = Some(CameraPose {
        field_of_view_rad: std::f64::consts::FRAC_PI_2,
        ..CameraPose::default()
    });
    let seen = info(Header::default(), &of);
    assert!(
        (seen.k.0[0] - 100.0).abs() < 1e-9 && seen.k.0[2] == 100.0 && seen.k.0[5] == 50.0,
        "{seen:?}"
    );
}

proptest! {
    #[test]
    fn headers_that_lie_make_no_panic(width in 0u32..5000, height in 0u32..5000, stride in any::<u32>(), bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        let of = FrameHeader { stride_bytes: stride, ..header(width, height, PixelFormat::Gray8) };
        let _ = jpeg(&of, &bytes);
        let _ = info(Header::default(), &of);
    }
}
