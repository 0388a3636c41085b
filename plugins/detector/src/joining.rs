//! The rule that joins what the model finds with what moves.
//!
//! 1. What the model finds where something moves is surer than what it finds where nothing does.
//! 2. What moves where the model finds nothing is told as [`UNKNOWN_CLASS`], if it is small: what is large and has no box is a cloud, a tree or a shadow.

use skein_vision::{ClassScores, Found, Moving, UNKNOWN_CLASS};

/// How much surer a box is in which something moves: see [`ClassScores::raised`].
const SURER: f64 = 0.2;
/// Something that moves belongs to a box if its middle is no farther from the box's than this share of its size.
const BELONGS: f64 = 0.75;
/// What is larger than this is nothing far, in pixels.
const FAR_PX: f64 = 16.0;
/// The score of something that moves, which stands out by so many times the noise: half as sure as can be.
const CONTRAST_HALF: f64 = 12.0;

/// Boxes of the model and things that move as one list.
pub(crate) fn join(mut found: Vec<Found>, moving: &[Moving]) -> Vec<Found> {
    let mut alone: Vec<Found> = Vec::new();
    let model = found.len();
    for one in moving {
        let mut of_model = false;
        for of in &mut found[..model] {
            if belongs(one, of) {
                of_model = true;
                of.scores = of.scores.raised(SURER);
            }
        }
        let side_px = one.bounds.width_px.max(one.bounds.height_px);
        if !of_model && side_px <= FAR_PX {
            let score = one.contrast / (one.contrast + CONTRAST_HALF);
            alone.push(Found {
                bounds: one.bounds,
                scores: ClassScores::one(UNKNOWN_CLASS, score),
            });
        }
    }
    found.append(&mut alone);
    found
}

fn belongs(moving: &Moving, found: &Found) -> bool {
    let (a, b) = (&moving.bounds, &found.bounds);
    (a.center_x_px - b.center_x_px).abs() <= BELONGS * b.width_px.max(a.width_px)
        && (a.center_y_px - b.center_y_px).abs() <= BELONGS * b.height_px.max(a.height_px)
}
