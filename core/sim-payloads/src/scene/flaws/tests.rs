//! Flaws against what they are told to be.

use super::*;
use proptest::prelude::*;
use skein_domain::PositionNed;

fn grey(level: u8) -> Vec<u8> {
    vec![level; 3 * 20_000]
}

fn mean_and_deviation(rgb: &[u8]) -> (f64, f64) {
    let count = rgb.len() as f64;
    let mean = rgb.iter().map(|value| f64::from(*value)).sum::<f64>() / count;
    let square = rgb.iter().map(|value| (f64::from(*value) - mean).powi(2)).sum::<f64>() / count;
    (mean, square.sqrt())
}

fn pose() -> CameraPose {
    CameraPose {
        position: PositionNed::new(1.0, 2.0, 3.0),
        roll_rad: 0.1,
        pitch_rad: -0.2,
        yaw_rad: 2.0,
        field_of_view_rad: 1.0,
    }
}

proptest! {
    #[test]
    fn noise_has_its_deviation_and_no_other_mean(noise_levels in 1.5..12.0_f64, seed in any::<u64>(), time_s in 0.0..1e5_f64) {
        let flaws = Flaws { seed, noise_levels, ..Flaws::default() };
        let mut rgb = grey(120);
        flaws.expose(time_s, &mut rgb);
        let (mean, deviation) = mean_and_deviation(&rgb);
        // Rounding to whole levels adds a twelfth to the variance.
        let expected = (noise_levels * noise_levels + 1.0 / 12.0).sqrt();
        prop_assert!((mean - 120.0).abs() < 0.04 * noise_levels && (deviation / expected - 1.0).abs() < 0.03, "{mean} {deviation}");
        // The same of the same; another moment and another camera give other noise.
        let again = |flaws: Flaws, time_s: f64| { let mut rgb = grey(120); flaws.expose(time_s, &mut rgb); rgb };
        prop_assert_eq!(&again(flaws, time_s), &rgb);
        prop_assert_ne!(&again(flaws, time_s + 0.01), &rgb);
        prop_assert_ne!(&again(Flaws { seed: seed ^ 1, ..flaws }, time_s), &rgb);
        prop_assert!(rgb.as_chunks::<3>().0.iter().all(|[red, green, blue]| red == green && green == blue));
    }

    #[test]
    fn every_angle_stays_within_what_was_told_and_does_not_jump(
        sway_rad in 0.0..0.5_f64, pose_error_rad in 0.0..0.2_f64, seed in any::<u64>(), time_s in 0.0..1e5_f64,
    ) {
        let flaws = Flaws { seed, sway_rad, pose_error_rad, ..Flaws::default() };
        let angles = |pose: &CameraPose| [pose.roll_rad, pose.pitch_rad, pose.yaw_rad];
        let (swayed, believed) = (flaws.swayed(&pose(), time_s), flaws.believed(&pose(), time_s));
        prop_assert!((swayed.roll_rad - 0.1).abs() <= sway_rad + 1e-12);
        prop_assert_eq!(CameraPose { roll_rad: 0.1, ..swayed }, pose());
        for (told, is) in angles(&believed).into_iter().zip(angles(&pose())) {
            prop_assert!((told - is).abs() <= pose_error_rad + 1e-12);
        }
        let (later, later_believed) = (flaws.swayed(&pose(), time_s + 0.01), flaws.believed(&pose(), time_s + 0.01));
        prop_assert!((later.roll_rad - swayed.roll_rad).abs() <= 0.035 * sway_rad + 1e-9);
        for (before, after) in angles(&believed).into_iter().zip(angles(&later_believed)) {
            prop_assert!((after - before).abs() <= 0.01 * pose_error_rad + 1e-9);
        }
    }
}

#[test]
fn a_minute_shows_what_is_wrong() {
    let flaws = Flaws {
        seed: 4,
        exposure_change: 0.3,
        sway_rad: 0.2,
        pose_error_rad: 0.02,
        ..Flaws::default()
    };
    let spread = |value: &dyn Fn(f64) -> f64| {
        let values: Vec<f64> = (0..1000).map(|tick| value(f64::from(tick) * 0.1)).collect();
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max) - values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let brightness = |time_s: f64| {
        let mut rgb = vec![100; 3];
        flaws.expose(time_s, &mut rgb);
        f64::from(rgb[0])
    };
    assert!(spread(&brightness) > 30.0 && spread(&brightness) <= 60.0);
    assert!(spread(&|time_s| flaws.swayed(&pose(), time_s).roll_rad) > 0.3);
    for angle in [
        |pose: CameraPose| pose.roll_rad,
        |pose: CameraPose| pose.pitch_rad,
        |pose: CameraPose| pose.yaw_rad,
    ] {
        assert!(spread(&|time_s| angle(flaws.believed(&pose(), time_s))) > 0.02);
    }
}

#[test]
fn without_flaws_nothing_changes() {
    let mut rgb: Vec<u8> = (0..=254).collect();
    Flaws::default().expose(5.0, &mut rgb);
    assert_eq!(rgb, (0..=254).collect::<Vec<u8>>());
    assert_eq!(Flaws::default().swayed(&pose(), 5.0), pose());
    assert_eq!(Flaws::default().believed(&pose(), 5.0), pose());
}
