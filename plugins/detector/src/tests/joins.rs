//! The rule that joins model and motion.

use crate::joining::join;
use skein_vision::{Bounds, ClassScores, Found, Moving, UNKNOWN_CLASS};

fn bounds(x_px: f64, size_px: f64) -> Bounds {
    Bounds {
        center_x_px: x_px,
        center_y_px: 20.0,
        width_px: size_px,
        height_px: size_px,
    }
}

fn found(x_px: f64, score: f64) -> Found {
    Found {
        bounds: bounds(x_px, 10.0),
        scores: ClassScores::one("bird", score),
    }
}

fn moving(x_px: f64, size_px: f64, contrast: f64) -> Moving {
    Moving {
        bounds: bounds(x_px, size_px),
        contrast,
    }
}

#[test]
fn what_moves_makes_the_box_around_it_surer_and_no_other() {
    let joined = join(vec![found(20.0, 0.5), found(80.0, 0.5)], &[moving(22.0, 4.0, 30.0)]);
    assert_eq!(joined.len(), 2);
    assert!(joined[0].scores.of("bird") > 0.5 && joined[0].scores.of("bird") < 1.0);
    assert_eq!(joined[1].scores.of("bird"), 0.5);
}

#[test]
fn something_small_that_moves_alone_is_unknown_and_something_large_is_nothing() {
    let joined = join(Vec::new(), &[moving(20.0, 4.0, 12.0), moving(60.0, 40.0, 50.0)]);
    let [one] = joined.as_slice() else { panic!("{joined:?}") };
    assert_eq!(one.scores.best(), Some((UNKNOWN_CLASS, 0.5)));
    assert_eq!(one.bounds, bounds(20.0, 4.0));
}
