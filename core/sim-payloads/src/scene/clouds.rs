//! Clouds: a layer high over the ground that stays where it is, rough at three sizes.
//!
//! Must never do: flicker. What is finer than a pixel fades out with the distance.

use super::world::tone;
use super::{Lens, Scene};

/// How high over the origin of the swarm frame they are, in metres.
const HEIGHT_M: f32 = 1200.0;
/// Sizes of their roughness in metres, and how much each counts.
const ROUGHNESS: [(f32, f32); 3] = [(900.0, 0.6), (300.0, 0.28), (100.0, 0.12)];
/// From clear to covered within so much of the roughness.
const EDGE: f32 = 0.3;
/// They turn to haze over this distance, in metres.
const HAZE_M: f32 = 6000.0;

/// What is the same for all pixels.
pub(super) struct Clouds {
    seed: u32,
    eye_north_m: f32,
    eye_east_m: f32,
    over_m: f32,
    /// Radians per pixel.
    pixel_rad: f32,
    /// Roughness below this is clear sky.
    least: f32,
}

impl Clouds {
    /// `None` when there are none.
    pub(super) fn new(scene: &Scene, lens: &Lens) -> Option<Self> {
        (scene.clouds > 0.0).then(|| Self {
            seed: scene.seed ^ 0x5bd1_e995,
            eye_north_m: lens.eye.x as f32,
            eye_east_m: lens.eye.y as f32,
            over_m: (HEIGHT_M + lens.eye.z as f32).max(1.0),
            pixel_rad: (1.0 / lens.focal_px) as f32,
            // The roughness spreads over about -0.5 to 0.5.
            least: 0.5 - scene.clouds.min(1.0) as f32 * (1.0 + EDGE),
        })
    }

    /// How much of the sky they cover in a direction, 0..=1.
    pub(super) fn share(&self, north: f32, east: f32, up: f32, level: f32) -> f32 {
        let reach = self.over_m / up.max(1e-4);
        let (north_m, east_m) = (self.eye_north_m + north * reach, self.eye_east_m + east * reach);
        let distance_m = level * reach;
        let pixel_m = self.pixel_rad * reach * (1.0 + distance_m / self.over_m);
        let rough = ROUGHNESS.iter().zip(0_u32..).map(|((size_m, weight), octave)| {
            let sharp = size_m / (size_m + 2.0 * pixel_m);
            weight * sharp * sharp * between(self.seed.wrapping_add(octave), north_m / size_m, east_m / size_m)
        });
        let cover = smooth(((rough.sum::<f32>() - self.least) / EDGE).clamp(0.0, 1.0));
        cover * HAZE_M / (HAZE_M + distance_m)
    }
}

/// Chance between the points of a grid, -1..1 and without edges.
fn between(seed: u32, row: f32, column: f32) -> f32 {
    let ((row, down), (column, along)) = (whole(row), whole(column));
    let (down, along) = (smooth(down), smooth(along));
    let side = |row: i32| {
        let left = tone(seed, row, column);
        left + (tone(seed, row, column.wrapping_add(1)) - left) * along
    };
    let upper = side(row);
    upper + (side(row.wrapping_add(1)) - upper) * down
}

/// A number rounded down, and what is left of it.
fn whole(number: f32) -> (i32, f32) {
    // By way of a whole number: the library's own rounding is a call per pixel.
    let toward_zero = number as i32;
    let down = toward_zero.wrapping_sub(i32::from(number < toward_zero as f32));
    (down, number - down as f32)
}

fn smooth(share: f32) -> f32 {
    share * share * (3.0 - 2.0 * share)
}
