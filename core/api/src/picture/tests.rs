//! Frames become pictures that decode to the same pixels.

use super::*;

#[test]
fn pixels_survive_with_padded_rows() {
    let header = FrameHeader {
        width_px: 2,
        height_px: 2,
        stride_bytes: 8,
        format: PixelFormat::Rgb8,
        ..FrameHeader::default()
    };
    let bytes = [1, 2, 3, 4, 5, 6, 0, 0, 7, 8, 9, 10, 11, 12, 0, 0];
    let picture = encode(&header, &bytes);
    let mut reader = png::Decoder::new(std::io::Cursor::new(picture)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    assert_eq!(pixels, [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
}

#[test]
fn a_header_that_promises_more_than_there_is_gives_no_picture() {
    let header = FrameHeader {
        width_px: 100,
        height_px: 100,
        format: PixelFormat::Gray8,
        ..FrameHeader::default()
    };
    assert!(encode(&header, &[1, 2, 3]).is_empty());
}
