//! Solid things in the world: ellipsoids, so that each pixel's ray is tested against the true shape from any side.
//!
//! Must never do: draw a thing larger or smaller than it is; what is smaller than a pixel darkens it by its share.

use super::canvas::{Canvas, Colour};
use super::{Lens, NEAREST_M, SceneTarget, TargetKind};
use nalgebra::Vector3;
use std::f64::consts::FRAC_1_SQRT_2;

const MULTIROTOR: Colour = [58.0, 60.0, 66.0];
const MARKER: Colour = [205.0, 28.0, 22.0];
/// Where the light comes from: from above, a little from the south-west.
const LIGHT: [f64; 3] = [-0.41, -0.41, -0.81];
/// A target narrower than this many pixels is sampled sixteen times per pixel.
const SMALL_PX: f64 = 24.0;
const SAMPLES: u32 = 4;
/// What would be wider than this is not drawn: the camera is inside of it.
const LARGEST_PX: f64 = 1e5;

/// Half axes and middle of an ellipsoid, as shares of the thing's width, along its own axes.
struct Ellipsoid {
    middle: [f64; 3],
    half: [f64; 3],
}

const fn ellipsoid(middle: [f64; 3], half: [f64; 3]) -> Ellipsoid {
    Ellipsoid { middle, half }
}

/// Along the two pairs of arms, and down. The rotors' tips are half a width from the middle.
const MULTIROTOR_PARTS: [Ellipsoid; 7] = [
    ellipsoid([0.0, 0.0, 0.0], [0.15, 0.15, 0.10]),
    ellipsoid([0.0, 0.0, 0.0], [0.36, 0.03, 0.03]),
    ellipsoid([0.0, 0.0, 0.0], [0.03, 0.36, 0.03]),
    ellipsoid([0.35, 0.0, -0.03], [0.15, 0.15, 0.035]),
    ellipsoid([-0.35, 0.0, -0.03], [0.15, 0.15, 0.035]),
    ellipsoid([0.0, 0.35, -0.03], [0.15, 0.15, 0.035]),
    ellipsoid([0.0, -0.35, -0.03], [0.15, 0.15, 0.035]),
];
const MARKER_PARTS: [Ellipsoid; 1] = [ellipsoid([0.0, 0.0, 0.0], [0.5, 0.5, 0.5])];

/// Draws one target over what is there.
pub(super) fn draw(target: &SceneTarget, lens: &Lens, canvas: &mut Canvas<'_>) {
    let depth_m = lens.depth_m(&target.position);
    let Some((right_px, down_px)) = lens.project(&target.position.vector()) else {
        return;
    };
    // Seen at an angle to the axis a ball is drawn out; twice its width is enough up to 60 degrees.
    let reach_px = target.size_m / (depth_m - 0.5 * target.size_m).max(NEAREST_M) * lens.focal_px + 1.0;
    if !(reach_px > 0.0 && reach_px < LARGEST_PX) {
        return;
    }
    let samples = if reach_px < SMALL_PX { SAMPLES } else { 1 };
    let seen = SeenTarget {
        offset: turned(lens.eye - target.position.vector()) / target.size_m,
        parts: match target.kind {
            TargetKind::Multirotor => &MULTIROTOR_PARTS,
            TargetKind::Marker => &MARKER_PARTS,
        },
        light: turned(Vector3::from(LIGHT)),
    };
    let base = match target.kind {
        TargetKind::Multirotor => MULTIROTOR,
        TargetKind::Marker => MARKER,
    };
    let range = |middle_px: f64, size_px: u32| {
        let from = (middle_px - reach_px).floor().clamp(0.0, f64::from(size_px));
        let to = (middle_px + reach_px).ceil().clamp(0.0, f64::from(size_px));
        from as u32..to as u32
    };
    for row in range(down_px, lens.height_px) {
        for column in range(right_px, lens.width_px) {
            let (share, brightness) = seen.pixel(lens, column, row, samples);
            if share > 0.0 {
                let pixel = row as usize * lens.width_px as usize + column as usize;
                canvas.cover(pixel, base.map(|value| value * brightness), share);
            }
        }
    }
}

/// A target as it is seen, in its own axes and measured in its own width.
struct SeenTarget {
    offset: Vector3<f64>,
    parts: &'static [Ellipsoid],
    light: Vector3<f64>,
}

impl SeenTarget {
    /// The share of a pixel that it covers, and how bright it is there.
    fn pixel(&self, lens: &Lens, column: u32, row: u32, samples: u32) -> (f32, f32) {
        let (mut hits, mut brightness) = (0_u32, 0.0);
        for sample in 0..samples * samples {
            let within = |i: u32| (f64::from(i) + 0.5) / f64::from(samples);
            let ray = lens.ray(
                f64::from(column) + within(sample % samples),
                f64::from(row) + within(sample / samples),
            );
            if let Some(lit) = self.hit(&turned(ray)) {
                hits += 1;
                brightness += lit;
            }
        }
        if hits == 0 {
            return (0.0, 0.0);
        }
        let share = f64::from(hits) / f64::from(samples * samples);
        (share as f32, (brightness / f64::from(hits)) as f32)
    }

    /// How bright the nearest part is that a ray meets.
    fn hit(&self, ray: &Vector3<f64>) -> Option<f64> {
        let mut nearest: Option<(f64, f64)> = None;
        for part in self.parts {
            let half = Vector3::from(part.half);
            let from = (self.offset - Vector3::from(part.middle)).component_div(&half);
            let along = ray.component_div(&half);
            let (a, b, c) = (along.norm_squared(), from.dot(&along), from.norm_squared() - 1.0);
            let root = b * b - a * c;
            if root < 0.0 {
                continue;
            }
            let distance = (-b - root.sqrt()) / a;
            if distance > 0.0 && nearest.is_none_or(|(found, _)| distance < found) {
                let normal = (from + along * distance).component_div(&half).normalize();
                nearest = Some((distance, 0.8 + 0.2 * normal.dot(&self.light)));
            }
        }
        nearest.map(|(_, lit)| lit)
    }
}

/// From north, east, down to the axes of the arms: the nose lies between two of them.
fn turned(v: Vector3<f64>) -> Vector3<f64> {
    Vector3::new((v.x + v.y) * FRAC_1_SQRT_2, (v.y - v.x) * FRAC_1_SQRT_2, v.z)
}
