//! What is in a picture, known from the scene itself: what detectors, trackers and geolocation are measured against.
//!
//! Must never do: look at the picture.

use super::bodies::Extent;
use super::{Lens, SceneTarget, TargetKind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::payload::CameraPose;
use skein_domain::{PositionNed, VelocityNed};

/// One thing in a picture, as it truly is. Pixels count from the picture's left upper corner.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Seen {
    /// Which of the targets it is, from 0. It is not written: whoever reads has another list.
    #[serde(skip)]
    pub target: usize,
    /// What it is.
    pub kind: TargetKind,
    /// Its middle.
    pub position: PositionNed,
    /// Where it goes.
    pub velocity: VelocityNed,
    /// Middle of the box, in pixels from the left. It is the smallest one around its parts, of which those at an edge of
    /// the picture are cut off there.
    pub center_x_px: f64,
    /// Middle of the box, in pixels from the top.
    pub center_y_px: f64,
    /// Width of the box in pixels.
    pub width_px: f64,
    /// Height of the box in pixels.
    pub height_px: f64,
    /// How large the box is against the one around the whole of it, 0..=1.
    pub inside: f64,
}

/// Everything that is in a picture of this width and height in pixels, in the order of the targets. What hides behind something is in it
/// all the same; what reaches beside or behind the camera is not.
#[must_use]
pub fn truth(pose: &CameraPose, targets: &[SceneTarget], size_px: (u32, u32)) -> Vec<Seen> {
    let lens = Lens::new(pose, size_px);
    let seen = |(number, target): (usize, &SceneTarget)| {
        let (whole, inside) = Extent::of(target, &lens)?;
        let inside = inside?;
        Some(Seen {
            target: number,
            kind: target.kind,
            position: target.position,
            velocity: target.velocity,
            center_x_px: 0.5 * (inside.left_px + inside.right_px),
            center_y_px: 0.5 * (inside.top_px + inside.bottom_px),
            width_px: inside.width_px(),
            height_px: inside.height_px(),
            inside: inside.width_px() * inside.height_px() / (whole.width_px() * whole.height_px()),
        })
    };
    targets.iter().enumerate().filter_map(seen).collect()
}

#[cfg(test)]
mod tests;
