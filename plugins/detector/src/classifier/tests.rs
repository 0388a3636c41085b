//! The same figures as the training script has, from the same pictures; and what becomes of a track's class.

use super::*;
use serde_json::Value;

const NEWEST: u32 = 30;

/// As `tests/make.py` draws it.
fn picture(number: u32) -> Gray {
    let (number, mut pixels) = (number as i32, Vec::new());
    for y in 0..96_i32 {
        for x in 0..128_i32 {
            let high = 2 + number / 4 % 3;
            let thing = (x - (30 + number)).abs() <= 7 && (y - 40).abs() <= high;
            let grey = if thing {
                60 + (x + y) % 5
            } else {
                150 + (x * 7 + y * 13 + number * 5) % 9
            };
            pixels.push(grey as u8);
        }
    }
    Gray::new(128, 96, pixels)
}

fn bounds(number: u32) -> Bounds {
    Bounds {
        center_x_px: 30.5 + f64::from(number),
        center_y_px: 40.5,
        width_px: 15.0,
        height_px: f64::from(2 * (2 + number / 4 % 3) + 1),
    }
}

fn at(number: u32) -> NodeTime {
    NodeTime(0).plus_seconds(1.0 + f64::from(number) / 30.0)
}

fn golden() -> Value {
    serde_json::from_str(include_str!("tests/golden.json")).expect("is JSON")
}

fn past() -> Past {
    let mut past = Past::default();
    for number in 0..=NEWEST {
        past.remember(at(number), &picture(number), bounds(number));
    }
    past
}

fn close(ours: &[f32], theirs: &Value, within: f64) {
    let theirs: Vec<f64> = theirs
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(Value::as_f64)
        .collect();
    assert_eq!(ours.len(), theirs.len());
    for (ours, theirs) in ours.iter().zip(theirs) {
        assert!((f64::from(*ours) - theirs).abs() < within, "{ours} is not {theirs}");
    }
}

#[test]
fn windows_numbers_and_what_the_model_says_are_those_of_the_script() {
    let (past, golden) = (past(), golden());
    for (light, camera) in [(Light::Infrared, "infrared"), (Light::Visible, "visible")] {
        let (windows, numbers) = past.input(at(NEWEST), light).expect("something was seen");
        for (cell, theirs) in golden["cells"].as_object().expect("cells") {
            let ours = f64::from(windows[cell.parse::<usize>().expect("a number")]);
            assert!(
                (ours - theirs.as_f64().expect("a number")).abs() < 1e-3,
                "cell {cell}: {ours}, {theirs}"
            );
        }
        close(&numbers, &golden[camera]["numbers"], 1e-3);
        let classifier = TrackClassifier::new(light).expect("is a model");
        let said = run(&classifier.net, &classifier.threads, windows, numbers).expect("runs");
        close(&said.map(|said| said as f32), &golden[camera]["probabilities"], 5e-3);
    }
}

#[test]
fn only_what_is_needed_is_kept_and_a_track_that_has_ended_is_forgotten() {
    let past = past();
    let oldest_s = at(NEWEST).seconds_since(past.seen.front().expect("there is one").0);
    assert!((APART_S * 7.0..APART_S * 8.0 + 0.04).contains(&oldest_s), "{oldest_s}");
    let mut classifier = TrackClassifier::new(Light::Visible).expect("is a model");
    let mut tracks = vec![track(1, 0), track(2, 0)];
    classifier.look(at(0), &picture(0), &mut tracks).expect("looks");
    assert_eq!(classifier.tracks.len(), 2);
    classifier.look(at(1), &picture(1), &mut [track(2, 1)]).expect("looks");
    assert_eq!(classifier.tracks.keys().copied().collect::<Vec<_>>(), [2]);
}

fn track(id: u64, number: u32) -> PictureTrack {
    PictureTrack {
        id,
        bounds: bounds(number),
        velocity_px_s: (30.0, 0.0),
        error_px: 1.0,
        scores: ClassScores::all([("drone".to_owned(), 0.6), ("bird".to_owned(), 0.3)]),
        age_s: 1.0,
        coasted_s: 0.0,
        found: Some(bounds(number)),
        moved: true,
    }
}

#[test]
fn what_both_say_counts_and_how_sure_the_finder_is_stays() {
    let finder = ClassScores::all([("drone".to_owned(), 0.6), ("bird".to_owned(), 0.3)]);
    let past = |said: [f64; 4], runs: u32| Past {
        said: said.map(|said| said.ln() * f64::from(runs)),
        runs,
        ..Past::default()
    };
    assert_eq!(past([0.25; 4], 0).joined(&finder), finder);
    let bird = past([0.02, 0.94, 0.02, 0.02], 5).joined(&finder);
    let (class, score) = bird.best().expect("something");
    assert_eq!(class, "bird");
    assert!(score > 0.55 && score <= 0.6, "{score}");
    let whole: f64 = bird.iter().map(|(_, score)| score).sum();
    assert!((whole - 0.6).abs() < 1e-3, "{whole}");
    let unknown = ClassScores::one("unknown", 0.5);
    assert_eq!(past([0.25; 4], 3).joined(&unknown), unknown);
}

#[test]
fn what_has_not_moved_for_a_while_is_a_part_of_the_scene() {
    let moving = track(1, 0);
    let still = PictureTrack {
        moved: false,
        ..track(1, 0)
    };
    let new = PictureTrack {
        age_s: 0.3,
        ..still.clone()
    };
    assert_eq!([&moving, &still, &new].map(crate::eye::stands), [false, true, false]);
}
