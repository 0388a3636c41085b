//! What moves in the picture, with the camera's own motion taken out: for far things of a few pixels, which no model knows by their looks.
//!
//! 1. How the whole picture has moved since the last ones: [`shift`].
//! 2. A pixel has changed if it is brighter or darker than all nine around where it was, in the last picture and in the one before. So neither an
//!    edge that is half a pixel off nor the place that something left has changed.
//! 3. Pixels that have changed together are one thing.

mod shift;

use crate::Bounds;
use crate::gray::Gray;
use std::collections::VecDeque;

/// A pixel has changed if it differs by so many times the noise.
const NOISE_TIMES: f64 = 5.0;
/// And by so much at least, of 255.
const LEAST_CHANGE: f64 = 10.0;
/// Of fewer pixels than this nothing is made.
const LEAST_PIXELS: usize = 2;
/// Something of more pixels than this share of the picture is no far thing.
const LARGEST_SHARE: f64 = 0.02;
/// Pixels with so many pixels between them belong together.
const GAP_PX: usize = 2;
/// When more of the picture than this changes, it was no thing that moved: the light, or a picture that could not be laid over the last one.
const TOO_MUCH: f64 = 0.03;

/// Something that moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moving {
    /// Where.
    pub bounds: Bounds,
    /// How much clearer than the noise it is.
    pub contrast: f64,
}

/// What a picture says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// How far what stands still has moved since the last picture, to the right and down; `None` if that cannot be told.
    pub shift_px: Option<(f64, f64)>,
    /// What has moved otherwise.
    pub moving: Vec<Moving>,
}

/// Looks for what moves, from one picture to the next.
#[derive(Debug, Default)]
pub struct MotionDetector {
    /// The last pictures, the newest last, and how far each had moved since the one before.
    last: VecDeque<(Gray, (f64, f64))>,
}

impl MotionDetector {
    /// Takes the next picture. One of another size begins anew. `expected_px` is how far what stands still is likely to have moved, to the right and down.
    pub fn take(&mut self, picture: Gray, expected_px: (f64, f64)) -> Motion {
        let same = |last: &Gray| (last.width, last.height) == (picture.width, picture.height);
        if self.last.back().is_some_and(|(last, _)| !same(last)) {
            self.last.clear();
        }
        let shift_px = self
            .last
            .back()
            .and_then(|(last, _)| shift::between(last, &picture, expected_px));
        let motion = Motion {
            shift_px,
            moving: shift_px.map(|shift| self.moving(&picture, shift)).unwrap_or_default(),
        };
        if shift_px.is_none() {
            self.last.clear();
        }
        self.last.push_back((picture, shift_px.unwrap_or_default()));
        if self.last.len() > 2 {
            self.last.pop_front();
        }
        motion
    }

    fn moving(&self, picture: &Gray, shift: (f64, f64)) -> Vec<Moving> {
        let (Some((older, _)), Some((last, before))) = (self.last.front(), self.last.get(1)) else {
            return Vec::new();
        };
        let since_older = (shift.0 + before.0, shift.1 + before.1);
        let first = changes(picture, last, shift);
        let noise = noise(&first).max(1.0);
        let least = (NOISE_TIMES * noise).max(LEAST_CHANGE);
        let candidates: Vec<usize> = (0..first.len()).filter(|at| f64::from(first[*at]) >= least).collect();
        if candidates.len() as f64 > TOO_MUCH * first.len() as f64 {
            return Vec::new();
        }
        let mut changed = vec![0_u8; first.len()];
        for at in candidates {
            let change = change(picture, older, since_older, at);
            if f64::from(change) >= least {
                changed[at] = first[at].min(change);
            }
        }
        let most = (LARGEST_SHARE * first.len() as f64) as usize;
        let things = together(&changed, picture.width, picture.height);
        let things = things
            .into_iter()
            .filter(|thing| (LEAST_PIXELS..=most).contains(&thing.pixels));
        things.map(|thing| thing.moving(noise)).collect()
    }
}

/// How much each pixel has changed.
fn changes(picture: &Gray, last: &Gray, shift: (f64, f64)) -> Vec<u8> {
    (0..picture.pixels.len())
        .map(|at| change(picture, last, shift, at))
        .collect()
}

/// How much brighter or darker a pixel is than all nine around where it was.
fn change(picture: &Gray, last: &Gray, shift: (f64, f64), at: usize) -> u8 {
    let x = (at % picture.width) as i32 - shift.0.round() as i32;
    let y = (at / picture.width) as i32 - shift.1.round() as i32;
    let inside = (1..last.width as i32 - 1).contains(&x) && (1..last.height as i32 - 1).contains(&y);
    if !inside {
        return 0;
    }
    let (mut least, mut most) = (u8::MAX, 0);
    for row in y - 1..=y + 1 {
        let start = row as usize * last.width + x as usize - 1;
        for pixel in &last.pixels[start..start + 3] {
            least = least.min(*pixel);
            most = most.max(*pixel);
        }
    }
    let pixel = picture.pixels[at];
    pixel.saturating_sub(most).max(least.saturating_sub(pixel))
}

/// The standard deviation of what changes without anything that moves, from the half of the pixels that change least.
fn noise(changes: &[u8]) -> f64 {
    let mut counts = [0_usize; 256];
    for change in changes {
        counts[usize::from(*change)] += 1;
    }
    // Nine tenths of the pixels lie below one and two thirds deviations.
    let (mut below, mut level) = (0, 0);
    for (value, count) in counts.iter().enumerate() {
        below += count;
        level = value;
        if below * 10 >= changes.len() * 9 {
            break;
        }
    }
    level as f64 / 1.65
}

/// Pixels that have changed together.
struct Thing {
    left: usize,
    right: usize,
    top: usize,
    bottom: usize,
    pixels: usize,
    greatest: u8,
}

impl Thing {
    fn moving(&self, noise: f64) -> Moving {
        let middle = |from: usize, to: usize| (from + to + 1) as f64 / 2.0;
        let side = |from: usize, to: usize| (to - from + 1) as f64;
        Moving {
            bounds: Bounds {
                center_x_px: middle(self.left, self.right),
                center_y_px: middle(self.top, self.bottom),
                width_px: side(self.left, self.right),
                height_px: side(self.top, self.bottom),
            },
            contrast: f64::from(self.greatest) / noise,
        }
    }
}

/// Joins neighbours among the pixels that have changed.
fn together(changed: &[u8], width: usize, height: usize) -> Vec<Thing> {
    let mut seen = vec![false; changed.len()];
    let mut things = Vec::new();
    for start in 0..changed.len() {
        if changed[start] == 0 || seen[start] {
            continue;
        }
        seen[start] = true;
        let (x, y) = (start % width, start / width);
        let mut thing = Thing {
            left: x,
            right: x,
            top: y,
            bottom: y,
            pixels: 0,
            greatest: 0,
        };
        let mut waiting = vec![start];
        while let Some(at) = waiting.pop() {
            let (x, y) = (at % width, at / width);
            thing.left = thing.left.min(x);
            thing.right = thing.right.max(x);
            thing.top = thing.top.min(y);
            thing.bottom = thing.bottom.max(y);
            thing.pixels += 1;
            thing.greatest = thing.greatest.max(changed[at]);
            for row in y.saturating_sub(GAP_PX)..(y + GAP_PX + 1).min(height) {
                for column in x.saturating_sub(GAP_PX)..(x + GAP_PX + 1).min(width) {
                    let next = row * width + column;
                    if changed[next] > 0 && !seen[next] {
                        seen[next] = true;
                        waiting.push(next);
                    }
                }
            }
        }
        things.push(thing);
    }
    things
}

#[cfg(test)]
mod tests;
