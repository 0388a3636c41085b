//! Tests of pixels of any size.

use super::*;
use proptest::prelude::*;

fn header(width_px: u32, height_px: u32, stride_bytes: u32, format: PixelFormat) -> FrameHeader {
    FrameHeader {
        width_px,
        height_px,
        stride_bytes,
        format,
        ..FrameHeader::default()
    }
}

#[test]
fn rows_with_room_behind_them_are_read_as_rows() {
    let mut bytes = Vec::new();
    for _ in 0..4 {
        bytes.extend([255; 6 * 3]);
        bytes.extend([0; 5]);
    }
    let planes = Planes::of_frame(&header(6, 4, 23, PixelFormat::Rgb8), &bytes).expect("a picture");
    assert_eq!(planes.size_px(), (6, 4));
    assert!(planes.y.iter().all(|y| *y > 230), "{:?}", planes.y);
}

#[test]
fn odd_sides_lose_their_last_row_and_column() {
    let planes = Planes::of_frame(&header(7, 5, 0, PixelFormat::Gray8), &[200; 35]).expect("a picture");
    assert_eq!(planes.size_px(), (6, 4));
    assert_eq!(planes.y, vec![16 + (200 * 219 / 255) as u8; 24]);
}

#[test]
fn what_is_no_picture_is_refused() {
    let few = Planes::of_frame(&header(8, 8, 0, PixelFormat::Rgb8), &[0; 191]);
    assert_eq!(few, Err(PlanesError::TooShort));
    let none = Planes::of_frame(&header(0, 8, 0, PixelFormat::Gray8), &[]);
    assert!(matches!(none, Err(PlanesError::Size { .. })));
    let encoded = Planes::of_frame(&header(8, 8, 0, PixelFormat::H264), &[0; 64]);
    assert_eq!(encoded, Err(PlanesError::Encoded));
    let damaged = Planes::of_frame(&header(8, 8, 0, PixelFormat::Jpeg), &[0xff, 0xd8, 0xff, 0]);
    assert!(matches!(damaged, Err(PlanesError::Damaged(_))));
}

#[test]
fn a_smaller_picture_has_the_same_shape_and_brightness() {
    let planes = Planes::of_frame(&header(640, 480, 0, PixelFormat::Gray8), &vec![120; 640 * 480]).expect("a picture");
    let small = planes.fitted(320, 320);
    assert_eq!(small.size_px(), (320, 240));
    assert!(small.y.iter().all(|y| *y == planes.y[0]));
    assert_eq!(planes.fitted(640, 480), planes);
}

proptest! {
    #[test]
    fn any_size_is_made_to_fit(width in 2_u32..300, height in 2_u32..300, most in 2_u32..200) {
        let bytes = vec![90; (width * height) as usize];
        let planes = Planes::of_frame(&header(width, height, 0, PixelFormat::Gray8), &bytes).expect("a picture");
        let small = planes.fitted(most, most);
        let (w, h) = small.size_px();
        prop_assert!(w >= 2 && h >= 2 && w % 2 == 0 && h % 2 == 0);
        prop_assert!(w <= most.max(2) && h <= most.max(2) || small == planes);
        prop_assert_eq!(small.y.len(), (w * h) as usize);
        prop_assert_eq!(small.u.len(), (w * h / 4) as usize);
    }
}
