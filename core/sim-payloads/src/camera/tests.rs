//! Pictures, recordings and zoom; and a storage that is never over full.

use super::*;
use proptest::prelude::*;

const STEP_S: f64 = 0.01;

fn small() -> CameraSettings {
    CameraSettings {
        storage_mib: 20.0,
        picture_mib: 6.0,
        ..CameraSettings::default()
    }
}

fn run(camera: &mut Camera, now_s: &mut f64, seconds: f64) -> Vec<Picture> {
    for _ in 0..(seconds / STEP_S).round() as usize {
        *now_s += STEP_S;
        camera.step(*now_s, STEP_S);
    }
    camera.take_pictures()
}

#[test]
fn so_many_pictures_at_an_interval_and_one_only_once() {
    let (mut camera, mut now_s) = (Camera::new(CameraSettings::default()), 0.0);
    assert_eq!(camera.start_pictures(now_s, 1.0, 3.0, 0.0), Outcome::Accepted);
    assert_eq!(
        camera.start_pictures(now_s, 1.0, 3.0, 0.0),
        Outcome::Rejected,
        "it is at it"
    );
    assert_eq!(run(&mut camera, &mut now_s, 1.5).len(), 2);
    assert_eq!(run(&mut camera, &mut now_s, 9.0).len(), 1);
    for _ in 0..3 {
        assert_eq!(camera.start_pictures(now_s, 0.0, 1.0, 7.0), Outcome::Accepted);
        run(&mut camera, &mut now_s, 1.0);
    }
    assert_eq!(camera.pictures, 4, "asked for thrice under one number");
    assert_eq!(camera.start_pictures(now_s, 1.0, 0.0, 0.0), Outcome::Accepted);
    assert_eq!(run(&mut camera, &mut now_s, 9.5).len(), 10);
    camera.stop_pictures();
    assert!(run(&mut camera, &mut now_s, 5.0).is_empty());
    assert_eq!(camera.start_pictures(now_s, 1.0, f64::NAN, 0.0), Outcome::Denied);
}

#[test]
fn a_full_storage_ends_pictures_and_recordings_until_it_is_formatted() {
    let (mut camera, mut now_s) = (Camera::new(small()), 0.0);
    camera.start_pictures(now_s, 1.0, 0.0, 0.0);
    let taken = run(&mut camera, &mut now_s, 10.0);
    let good: Vec<bool> = taken.iter().map(|picture| picture.taken).collect();
    assert_eq!(good, [true, true, true, false]);
    assert_eq!(camera.start_pictures(now_s, 1.0, 1.0, 0.0), Outcome::Failed);
    assert_eq!(
        camera.start_recording(now_s),
        Outcome::Accepted,
        "there is a little room"
    );
    assert_eq!(
        camera.format(1.0, true, false),
        Outcome::Rejected,
        "not while it records"
    );
    run(&mut camera, &mut now_s, 5.0);
    assert_eq!((camera.recording_s(now_s), camera.available_mib()), (None, 0.0));
    assert_eq!(camera.start_recording(now_s), Outcome::Failed);
    assert_eq!(camera.format(2.0, true, false), Outcome::Denied);
    assert_eq!(camera.format(1.0, true, false), Outcome::Accepted);
    assert_eq!((camera.available_mib(), camera.pictures), (20.0, 0));
}

#[test]
fn every_way_to_zoom_ends_at_the_field_of_view_it_should() {
    let settings = CameraSettings::default();
    let (mut camera, mut now_s) = (Camera::new(settings), 0.0);
    let mut after = |ask| {
        let outcome = camera.zoom(ask);
        run(&mut camera, &mut now_s, 3.0);
        (outcome, camera.zoom_factor(), camera.field_of_view_rad().to_degrees())
    };
    let (_, factor, degrees) = after(ZoomAsk::Range(100.0));
    assert!((factor - 6.0).abs() < 1e-9 && degrees < 14.0);
    let (_, _, degrees) = after(ZoomAsk::FieldOfView(30.0));
    assert!((degrees - 30.0).abs() < 1e-6);
    let focal_mm = 0.5 * SENSOR_WIDTH_MM / 20_f64.to_radians().tan();
    let (_, _, degrees) = after(ZoomAsk::FocalLength(focal_mm));
    assert!((degrees - 40.0).abs() < 1e-6);
    after(ZoomAsk::Range(0.0));
    let (_, factor, _) = after(ZoomAsk::Step(1.0));
    assert!((factor - 1.5).abs() < 1e-9);
    let (_, factor, _) = after(ZoomAsk::Continuous(1.0));
    assert_eq!(factor, 6.0);
    assert_eq!(after(ZoomAsk::Range(101.0)).0, Outcome::Denied);
    assert_eq!(after(ZoomAsk::FieldOfView(f64::NAN)).0, Outcome::Denied);
}

proptest! {
    #[test]
    fn the_storage_is_never_over_full_and_the_zoom_never_out_of_range(
        asked in prop::collection::vec((0_u8..7, -2.0..120.0_f64, 1_usize..80), 1..40),
    ) {
        let (mut camera, mut now_s) = (Camera::new(small()), 0.0);
        for (what, value, steps) in asked {
            let _ = match what {
                0 => camera.start_pictures(now_s, value, value, value),
                1 => camera.start_recording(now_s),
                2 => camera.stop_recording(),
                3 => camera.zoom(ZoomAsk::Step(value)),
                4 => camera.zoom(ZoomAsk::FocalLength(value)),
                5 => camera.zoom(ZoomAsk::Continuous(value)),
                _ => camera.stop_pictures(),
            };
            run(&mut camera, &mut now_s, steps as f64 * STEP_S);
            prop_assert!((0.0..=20.0).contains(&camera.used_mib()) && camera.available_mib() >= 0.0);
            prop_assert!((1.0..=6.0).contains(&camera.zoom_factor()));
        }
    }
}
