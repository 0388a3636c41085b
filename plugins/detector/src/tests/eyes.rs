//! Pictures to findings, and what is wrong with pictures.

use super::*;
use crate::report::PictureFault;

#[test]
fn what_the_model_finds_is_told_after_a_few_pictures_with_name_and_classes() {
    let mut eye = eye("constant");
    for index in 0..5 {
        let (header, bytes) = frame(index, 100);
        let look = eye.look(&header, &bytes);
        assert_eq!((look.fault, look.picture_fault), (None, None));
        assert_eq!((look.found.camera.as_str(), look.found.time), ("front", header.time));
        assert_eq!((look.found.width_px, look.found.height_px), (64, 48));
        if index < 2 {
            assert_eq!(look.found.findings, Vec::new());
            continue;
        }
        let [one] = look.found.findings.as_slice() else {
            panic!("{:?}", look.found)
        };
        assert_eq!((one.class.as_str(), one.id.as_str()), ("drone", "1"));
        assert!(
            (one.center_x_px - 16.0).abs() < 0.1 && (one.width_px - 8.0).abs() < 0.1,
            "{one:?}"
        );
        assert!(one.score > 0.8 && one.is_sound() && one.classes["bird"] < 0.1);
        assert_eq!(look.last_id, 1);
    }
}

#[test]
fn what_is_too_unsure_for_a_drone_is_told_as_unknown() {
    let settings = Settings {
        drone_score: Some(0.95),
        ..settings("constant")
    };
    let mut eye = Eye::new(&settings, model("constant").expect("is a model"), 0).expect("sees");
    let looks = (0..5).map(|index| {
        let (header, bytes) = frame(index, 100);
        eye.look(&header, &bytes)
    });
    let look = looks.last().expect("five");
    let [one] = look.found.findings.as_slice() else {
        panic!("{:?}", look.found)
    };
    assert_eq!(one.class, "unknown");
    assert!(one.score > 0.8 && one.classes["unknown"] == one.score && !one.classes.contains_key("drone"));
}

#[test]
fn what_stands_still_is_a_drone_to_other_models_alone() {
    // The same findings at the same place, looked at as another model's and as our own's, which the classifier helps.
    let is_drone = |settings: &Settings| -> Vec<bool> {
        let mut eye = Eye::new(settings, model("constant").expect("is a model"), 0).expect("sees");
        let looks = (0..30).map(|index| {
            let (header, bytes) = frame(index, 100);
            let found = eye.look(&header, &bytes).found;
            found.findings.iter().any(|one| one.classes.contains_key("drone"))
        });
        looks.collect()
    };
    let (own, other) = (is_drone(&Settings::default()), is_drone(&settings("constant")));
    assert_eq!((own[10], own[29]), (true, false));
    assert_eq!((other[10], other[29]), (true, true));
}

#[test]
fn numbers_that_are_none_are_a_fault_and_what_was_followed_is_not_invented() {
    let mut eye = eye("no-numbers");
    for index in 0..4 {
        let (header, bytes) = frame(index, 10);
        let look = eye.look(&header, &bytes);
        assert_eq!((look.fault, look.found.findings.len()), (None, usize::from(index >= 2)));
    }
    let (header, bytes) = frame(4, 200);
    let look = eye.look(&header, &bytes);
    assert_eq!(look.fault, Some(ModelFault::NotNumbers));
    assert_eq!(look.found.findings, Vec::new(), "nothing was found in this picture");
    let (header, bytes) = frame(5, 10);
    assert_eq!(eye.look(&header, &bytes).fault, None);
}

#[test]
fn a_black_or_frozen_camera_is_told_of() {
    let mut eye = eye("constant");
    let (header, _) = frame(0, 0);
    let black = vec![0; WIDTH * HEIGHT];
    assert_eq!(eye.look(&header, &black).picture_fault, Some(PictureFault::Black));
    let (_, same) = frame(1, 90);
    let faults: Vec<_> = (1..90)
        .map(|index| eye.look(&frame(index, 0).0, &same).picture_fault)
        .collect();
    assert_eq!(
        faults.iter().position(|fault| *fault == Some(PictureFault::Frozen)),
        Some(60)
    );
    let (header, other) = frame(91, 90);
    assert_eq!(eye.look(&header, &other).picture_fault, None);
}

#[test]
fn what_cannot_be_read_is_told_and_the_next_picture_is_looked_at() {
    let mut eye = eye("constant");
    let (header, bytes) = frame(0, 90);
    let look = eye.look(&header, &bytes[..100]);
    assert_eq!(look.picture_fault, Some(PictureFault::Unreadable));
    assert_eq!(look.found.findings, Vec::new());
    let (header, bytes) = frame(1, 90);
    assert_eq!(eye.look(&header, &bytes).picture_fault, None);
}
