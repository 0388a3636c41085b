//! Tests of JPEG files, read by another library.

use super::*;
use skein_domain::payload::{FrameHeader, PixelFormat};

#[test]
fn it_is_a_file_of_its_size() {
    let header = FrameHeader {
        width_px: 64,
        height_px: 48,
        format: PixelFormat::Rgb8,
        ..FrameHeader::default()
    };
    let red: Vec<u8> = [200, 30, 30].repeat(64 * 48);
    let planes = Planes::of_frame(&header, &red).expect("pixels");
    let file = jpeg(&planes, 80).expect("a file");
    let read = image::load_from_memory(&file).expect("a JPEG").to_rgb8();
    assert_eq!(read.dimensions(), (64, 48));
    let [r, g, b] = read.get_pixel(32, 24).0;
    assert!(
        r.abs_diff(200) < 12 && g.abs_diff(30) < 12 && b.abs_diff(30) < 12,
        "{r} {g} {b}"
    );
}
