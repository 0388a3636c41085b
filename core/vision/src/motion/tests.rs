//! Tests of what moves: far things before ground and sky, under a camera that turns, in noise; and what is no motion.

use super::*;
use proptest::prelude::*;

const WIDTH: usize = 160;
const HEIGHT: usize = 120;

/// A landscape that looks different everywhere, at a place.
fn ground(x: i32, y: i32) -> u8 {
    let cell = |x: i32, y: i32| {
        let mixed = (x.wrapping_mul(374_761_393) ^ y.wrapping_mul(668_265_263)).wrapping_mul(1_274_126_177);
        f64::from((mixed >> 16) & 0xff)
    };
    // Patches of six pixels, smooth between them.
    let (column, row) = (x.div_euclid(6), y.div_euclid(6));
    let (right, down) = (f64::from(x.rem_euclid(6)) / 6.0, f64::from(y.rem_euclid(6)) / 6.0);
    let upper = cell(column, row) * (1.0 - right) + cell(column + 1, row) * right;
    let lower = cell(column, row + 1) * (1.0 - right) + cell(column + 1, row + 1) * right;
    (60.0 + 0.5 * (upper * (1.0 - down) + lower * down)) as u8
}

/// The landscape from a camera that looks there, with noise, and something dark of three pixels.
fn picture(look: (i32, i32), thing: Option<(i32, i32)>, seed: i32) -> Gray {
    let mut pixels = Vec::with_capacity(WIDTH * HEIGHT);
    for y in 0..HEIGHT as i32 {
        for x in 0..WIDTH as i32 {
            let noise = (x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ seed.wrapping_mul(83_492_791))
                .rem_euclid(5)
                - 2;
            let is_thing = thing.is_some_and(|at| (x - at.0).abs() <= 1 && (y - at.1).abs() <= 1);
            let value = if is_thing {
                10
            } else {
                i32::from(ground(x + look.0, y + look.1))
            };
            pixels.push((value + noise).clamp(0, 255) as u8);
        }
    }
    Gray::new(WIDTH, HEIGHT, pixels)
}

#[test]
fn a_thing_of_three_pixels_is_found_while_the_camera_turns() {
    let mut detector = MotionDetector::default();
    for step in 0..12 {
        let at = (40 + 4 * step, 60);
        let motion = detector.take(picture((3 * step, -2 * step), Some(at), step), (0.0, 0.0));
        if step >= 1 {
            let (x, y) = motion.shift_px.expect("it can be told");
            assert!((x + 3.0).abs() < 0.5 && (y - 2.0).abs() < 0.5, "{x} {y}");
        }
        if step >= 2 {
            assert_eq!(motion.moving.len(), 1, "{:?}", motion.moving);
            let bounds = motion.moving[0].bounds;
            assert!((bounds.center_x_px - f64::from(at.0) - 0.5).abs() <= 1.5, "{bounds:?}");
            assert!((bounds.center_y_px - f64::from(at.1) - 0.5).abs() <= 1.5, "{bounds:?}");
        }
    }
}

#[test]
fn a_camera_that_turns_far_is_followed_where_that_is_expected() {
    let far = |expected: bool| {
        let mut detector = MotionDetector::default();
        let pictures = (0..6).map(|step| {
            let expected_px = if expected { (-42.0, 21.0) } else { (0.0, 0.0) };
            detector.take(picture((40 * step, -20 * step), None, step), expected_px)
        });
        pictures.skip(1).filter(|motion| motion.shift_px.is_some()).count()
    };
    assert_eq!((far(true), far(false)), (5, 0));
}

#[test]
fn what_stands_still_is_no_motion() {
    let mut detector = MotionDetector::default();
    for step in 0..8 {
        let motion = detector.take(picture((5 * step, step), None, step), (0.0, 0.0));
        assert!(motion.moving.is_empty(), "{:?}", motion.moving);
    }
}

#[test]
fn another_scene_or_size_or_light_is_no_motion() {
    let mut detector = MotionDetector::default();
    for step in 0..3 {
        detector.take(picture((0, 0), None, step), (0.0, 0.0));
    }
    let elsewhere = detector.take(picture((9000, 7000), None, 3), (0.0, 0.0));
    assert!(elsewhere.moving.is_empty());
    let mut bright = picture((9000, 7000), None, 4);
    bright
        .pixels
        .iter_mut()
        .for_each(|pixel| *pixel = pixel.saturating_add(60));
    assert!(detector.take(bright, (0.0, 0.0)).moving.is_empty());
    let small = Gray::new(40, 30, vec![7; 1200]);
    assert_eq!(detector.take(small.clone(), (0.0, 0.0)), Motion::default());
    // A camera that is frozen or black.
    for _ in 0..3 {
        let motion = detector.take(small.clone(), (0.0, 0.0));
        assert_eq!((motion.shift_px, motion.moving.len()), (Some((0.0, 0.0)), 0));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn pictures_of_any_size_and_content_are_taken(
        sizes in prop::collection::vec((0_usize..70, 0_usize..70), 1..6), seed in any::<i32>(),
    ) {
        let mut detector = MotionDetector::default();
        for (width, height) in sizes {
            let pixels = (0..width * height).map(|at| ((at as i32).wrapping_mul(seed) >> 7) as u8).collect();
            let motion = detector.take(Gray::new(width, height, pixels), (0.0, 0.0));
            for moving in motion.moving {
                prop_assert!(moving.bounds.is_sound() && moving.contrast.is_finite());
            }
        }
    }
}
