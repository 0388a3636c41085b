//! Tests of the clock in a picture, read by its description.

use super::*;

/// Reads a strip by the description above, not by the code below it.
fn read(rgb: &[u8], width_px: usize) -> Option<u32> {
    let cell = width_px / 80;
    let white = |index: usize| {
        let (x, y) = (cell + index * cell + cell / 2, cell + cell / 2);
        rgb[(y * width_px + x) * 3] > 127
    };
    let number =
        |from: usize, count: usize| (from..from + count).fold(0_u32, |sum, bit| sum << 1 | u32::from(white(bit)));
    let clock = number(2, 32);
    let sum: u32 = clock
        .to_be_bytes()
        .iter()
        .map(|byte| u32::from(byte >> 4) + u32::from(byte & 15))
        .sum();
    (white(0) && !white(1) && number(34, 4) == sum % 16).then_some(clock)
}

#[test]
fn the_clock_is_read_back_at_any_size() {
    for (width, height) in [(80, 60), (320, 240), (640, 480), (1919, 1080)] {
        for now_ms in [0, 1, 123_456_789, u64::from(u32::MAX), u64::from(u32::MAX) + 5] {
            let mut rgb = vec![77; width * height * 3];
            draw(NodeTime(now_ms * 1_000 + 999), width as u32, &mut rgb);
            assert_eq!(
                read(&rgb, width),
                Some(now_ms as u32),
                "{width} x {height}, {now_ms} ms"
            );
        }
    }
}

#[test]
fn a_picture_that_is_too_small_stays_as_it_is() {
    for (width, height) in [(79, 60), (640, 3), (0, 0)] {
        let mut rgb = vec![77; width * height * 3];
        draw(NodeTime(5_000), width as u32, &mut rgb);
        assert!(rgb.iter().all(|byte| *byte == 77));
    }
}
