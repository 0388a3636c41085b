//! Whether something moves relative to the scene behind it: a detector takes parts of the scene for things that fly, and those stand still in it.
//!
//! Must never do: name what it is.

use crate::{Bounds, Turn};
use skein_domain::NodeTime;
use std::collections::VecDeque;

/// For so long it is remembered where something was, in seconds. The scene's own motion is known from picture to picture: over longer times its error would
/// be taken for a motion.
const REMEMBERED_S: f64 = 2.0;
/// A place is remembered so often, in seconds.
const EVERY_S: f64 = 0.25;
/// What is as far from where it was as this share of its longer side has moved. Boxes of what stands still wander by a tenth.
const MOVED_SIZES: f64 = 0.2;
/// Or, if it is large, as this many pixels.
const MOVED_PX: f64 = 8.0;
/// If it is so in as many pictures, one after the other: a single box may lie anywhere.
const MOVED_FOR: u32 = 3;
/// The first boxes are not looked at: the filter still finds out how large it is.
const FIRST_BOXES: u32 = 3;

/// Where something was, as the scene lies now.
#[derive(Debug, Clone, Default)]
pub(super) struct Stillness {
    was: VecDeque<(NodeTime, f64, f64)>,
    boxes: u32,
    /// Pictures, one after the other, in which it was far from where it was.
    far: u32,
    moved: bool,
}

impl Stillness {
    /// To the next picture.
    pub(super) fn advance(&mut self, turn: &Turn) {
        for (_, x_px, y_px) in &mut self.was {
            let (moved_x_px, moved_y_px) = turn.at(*x_px, *y_px);
            *x_px += moved_x_px;
            *y_px += moved_y_px;
        }
    }

    /// Takes where it is in this picture.
    pub(super) fn take(&mut self, now: NodeTime, bounds: &Bounds) {
        self.boxes = self.boxes.saturating_add(1);
        if self.moved || self.boxes <= FIRST_BOXES {
            return;
        }
        let (x_px, y_px) = (bounds.center_x_px, bounds.center_y_px);
        let most_px = (MOVED_SIZES * bounds.width_px.max(bounds.height_px)).min(MOVED_PX);
        let is_far = self
            .was
            .iter()
            .any(|(_, was_x_px, was_y_px)| (x_px - was_x_px).hypot(y_px - was_y_px) > most_px);
        self.far = if is_far { self.far + 1 } else { 0 };
        self.moved = self.far >= MOVED_FOR;
        if self.moved {
            self.was.clear();
            return;
        }
        self.was.retain(|(at, _, _)| now.seconds_since(*at) < REMEMBERED_S);
        if self
            .was
            .back()
            .is_none_or(|(at, _, _)| now.seconds_since(*at) >= EVERY_S)
        {
            self.was.push_back((now, x_px, y_px));
        }
    }

    /// Whether it has ever moved.
    pub(super) fn moved(&self) -> bool {
        self.moved
    }
}
