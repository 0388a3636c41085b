//! Frames as they may come.

use crate::picture::Picture;
use proptest::prelude::*;
use skein_domain::payload::{FrameHeader, PixelFormat};

fn header(format: PixelFormat, width_px: u32, height_px: u32, stride_bytes: u32) -> FrameHeader {
    FrameHeader {
        format,
        width_px,
        height_px,
        stride_bytes,
        ..FrameHeader::default()
    }
}

#[test]
fn rows_with_gaps_and_grey_ones_are_read() {
    let rgb = Picture::read(&header(PixelFormat::Rgb8, 1, 2, 4), &[1, 2, 3, 0, 4, 5, 6]).expect("fits");
    assert_eq!(rgb.rgb, [1, 2, 3, 4, 5, 6]);
    let grey = Picture::read(&header(PixelFormat::Gray8, 2, 1, 0), &[7, 9]).expect("fits");
    assert_eq!(grey.rgb, [7, 7, 7, 9, 9, 9]);
    assert!(Picture::read(&header(PixelFormat::Rgb8, 2, 2, 0), &[0; 11]).is_none());
    assert!(Picture::read(&header(PixelFormat::Jpeg, 2, 2, 0), b"no picture").is_none());
}

proptest! {
    #[test]
    fn no_header_is_believed(width in 0..80_u32, height in 0..80_u32, stride in 0..300_u32, len in 0..4000_usize, large in any::<bool>()) {
        let size = if large { (u32::MAX - width, u32::MAX - height) } else { (width, height) };
        for format in [PixelFormat::Gray8, PixelFormat::Rgb8, PixelFormat::Jpeg, PixelFormat::H264] {
            if let Some(picture) = Picture::read(&header(format, size.0, size.1, stride), &vec![5; len]) {
                prop_assert_eq!(picture.rgb.len(), 3 * picture.width * picture.height);
            }
        }
    }
}
