//! Figures that can be worked out by hand.

use super::*;

fn at(x_px: f64) -> Bounds {
    Bounds {
        center_x_px: x_px,
        center_y_px: 50.0,
        width_px: 10.0,
        height_px: 10.0,
    }
}

fn truth(class: &str, x_px: f64) -> TrueBox {
    TrueBox {
        thing: 0,
        class: class.to_owned(),
        bounds: at(x_px),
    }
}

fn told(track: u64, class: &str, score: f64, x_px: f64) -> ToldBox {
    ToldBox {
        track,
        class: class.to_owned(),
        score,
        bounds: at(x_px),
    }
}

fn scores(pictures: &[(Vec<TrueBox>, Vec<ToldBox>)]) -> Scores {
    let mut scorer = Scorer::new("drone");
    scorer.clip(pictures);
    scorer.scores()
}

#[test]
fn what_is_told_rightly_is_all_there_is() {
    let picture = (vec![truth("drone", 20.0)], vec![told(1, "drone", 0.9, 20.0)]);
    let of = scores(&vec![picture; 10]);
    assert_eq!((of.truths, of.told, of.right, of.identity_switches), (10, 10, 10, 0));
    let shares = [of.precision, of.recall, of.f1, of.ap50, of.mota, of.idf1];
    assert!(shares.iter().all(|share| (share - 1.0).abs() < 1e-9), "{of:?}");
}

#[test]
fn another_class_is_a_miss_and_a_false_box_in_a_clip_of_another_thing_counts() {
    let wrong = (vec![truth("drone", 20.0)], vec![told(1, "bird", 0.9, 20.0)]);
    let right = (vec![truth("drone", 20.0)], vec![told(1, "drone", 0.9, 21.0)]);
    let bird = (vec![truth("bird", 20.0)], vec![told(1, "drone", 0.8, 20.0)]);
    let of = scores(&[wrong, right, bird]);
    assert_eq!((of.truths, of.told, of.right), (2, 2, 1));
    assert_eq!((of.precision, of.recall, of.f1), (0.5, 0.5, 0.5));
    assert_eq!(of.mota, 0.0);
    // The surer one is right: half of what is there at full precision.
    assert_eq!(of.ap50, 0.5);
}

#[test]
fn less_than_half_shared_is_not_the_same_and_nothing_is_counted_twice() {
    // 10 by 10 boxes, 3.34 apart: 66.6 of 133.4 shared.
    let just = (vec![truth("drone", 20.0)], vec![told(1, "drone", 0.9, 23.3)]);
    let less = (vec![truth("drone", 20.0)], vec![told(1, "drone", 0.9, 23.4)]);
    assert_eq!((scores(&[just]).right, scores(&[less]).right), (1, 0));
    let twice = (
        vec![truth("drone", 20.0)],
        vec![told(1, "drone", 0.9, 20.0), told(2, "drone", 0.8, 20.5)],
    );
    let of = scores(&[twice]);
    assert_eq!((of.right, of.told), (1, 2));
}

#[test]
fn a_new_name_is_a_switch_and_costs_identity() {
    let named = |track| (vec![truth("drone", 20.0)], vec![told(track, "drone", 0.9, 20.0)]);
    let mut pictures = vec![named(1); 6];
    pictures.extend(vec![named(2); 4]);
    let of = scores(&pictures);
    assert_eq!(of.identity_switches, 1);
    assert_eq!(of.f1, 1.0);
    assert!((of.mota - 0.9).abs() < 1e-12);
    assert!((of.idf1 - 0.6).abs() < 1e-12);
}

#[test]
fn average_precision_is_the_area_under_the_best_precision() {
    let right = |score| (vec![truth("drone", 20.0)], vec![told(1, "drone", score, 20.0)]);
    let wrong = |score| (vec![], vec![told(1, "drone", score, 20.0)]);
    // By score: right, wrong, right, of two true ones: 0.5 * 1 + 0.5 * 2 / 3.
    let of = scores(&[right(0.9), wrong(0.8), right(0.7)]);
    assert!((of.ap50 - (0.5 + 0.5 * 2.0 / 3.0)).abs() < 1e-12);
    let nothing = scores(&[(vec![truth("drone", 20.0)], vec![])]);
    assert_eq!((nothing.ap50, nothing.recall, nothing.f1), (0.0, 0.0, 0.0));
}
