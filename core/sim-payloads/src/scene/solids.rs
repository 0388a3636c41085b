//! Solid things in the world: ellipsoids, so that each pixel's ray is tested against the true shape from any side.
//!
//! Must never do: draw a thing larger or smaller than it is; what is smaller than a pixel darkens it by its share.

use super::canvas::{Canvas, Colour};
use super::{Lens, Look, NEAREST_M, SceneTarget, TargetKind};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::FRAC_1_SQRT_2;

const MULTIROTOR: Colour = [58.0, 60.0, 66.0];
const MARKER: Colour = [205.0, 28.0, 22.0];
/// How bright their warmth is to an infrared camera.
const MULTIROTOR_HEAT: f32 = 215.0;
const MARKER_HEAT: f32 = 160.0;
/// Where the light comes from: from above, a little from the south-west.
const LIGHT: [f64; 3] = [-0.41, -0.41, -0.81];
/// A target narrower than this many pixels is sampled sixteen times per pixel.
const SMALL_PX: f64 = 24.0;
const SAMPLES: u32 = 4;
/// What would be wider than this is not drawn: the camera is inside of it.
const LARGEST_PX: f64 = 1e5;

/// Half axes and middle of an ellipsoid, as shares of the thing's width, along its own axes.
pub(super) struct Ellipsoid {
    pub(super) middle: [f64; 3],
    pub(super) half: [f64; 3],
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

/// What a kind is made of that has no heading; nothing of the others.
pub(super) fn parts(kind: TargetKind) -> &'static [Ellipsoid] {
    match kind {
        TargetKind::Multirotor => &MULTIROTOR_PARTS,
        TargetKind::Marker => &MARKER_PARTS,
        _ => &[],
    }
}

/// Draws one target without a heading over what is there.
pub(super) fn draw(target: &SceneTarget, lens: &Lens, look: Look, canvas: &mut Canvas<'_>) {
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
        parts: parts(target.kind),
        light: turned(Vector3::from(LIGHT)),
    };
    let base = match (look, target.kind) {
        (Look::Visible, TargetKind::Marker) => MARKER,
        (Look::Visible, _) => MULTIROTOR,
        (Look::Infrared, TargetKind::Marker) => [MARKER_HEAT; 3],
        (Look::Infrared, _) => [MULTIROTOR_HEAT; 3],
    };
    let sampling = Sampling::new(lens, samples);
    let range = |middle_px: f64, size_px: u32| {
        let from = (middle_px - reach_px).floor().clamp(0.0, f64::from(size_px));
        let to = (middle_px + reach_px).ceil().clamp(0.0, f64::from(size_px));
        from as u32..to as u32
    };
    for row in range(down_px, lens.height_px) {
        for column in range(right_px, lens.width_px) {
            let (share, [brightness]) = sampling.pixel(column, row, |ray| seen.hit(&turned(*ray)).map(|lit| [lit]));
            if share > 0.0 {
                let pixel = row as usize * lens.width_px as usize + column as usize;
                canvas.cover(pixel, base.map(|value| value * brightness), share);
            }
        }
    }
}

/// How the rays of a pixel are chosen.
pub(super) struct Sampling<'a> {
    lens: &'a Lens,
    /// Along each side of a pixel.
    samples: u32,
}

impl<'a> Sampling<'a> {
    pub(super) fn new(lens: &'a Lens, samples: u32) -> Self {
        Self { lens, samples }
    }

    /// The share of a pixel's rays that hit, and the mean of what they hit.
    pub(super) fn pixel<const N: usize>(
        &self,
        column: u32,
        row: u32,
        hit: impl Fn(&Vector3<f64>) -> Option<[f64; N]>,
    ) -> (f32, [f32; N]) {
        let samples = self.samples;
        let (mut hits, mut sum) = (0_u32, [0.0; N]);
        for sample in 0..samples * samples {
            let within = |i: u32| (f64::from(i) + 0.5) / f64::from(samples);
            let ray = self.lens.ray(
                f64::from(column) + within(sample % samples),
                f64::from(row) + within(sample / samples),
            );
            if let Some(values) = hit(&ray) {
                hits += 1;
                for (total, value) in sum.iter_mut().zip(values) {
                    *total += value;
                }
            }
        }
        if hits == 0 {
            return (0.0, [0.0; N]);
        }
        let share = f64::from(hits) / f64::from(samples * samples);
        (share as f32, sum.map(|total| (total / f64::from(hits)) as f32))
    }
}

/// A target as it is seen, in its own axes and measured in its own width.
struct SeenTarget {
    offset: Vector3<f64>,
    parts: &'static [Ellipsoid],
    light: Vector3<f64>,
}

impl SeenTarget {
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

/// The other way round: the axes of the arms in the world.
pub(super) fn axes() -> Matrix3<f64> {
    Matrix3::from_columns(&[Vector3::x(), Vector3::y(), Vector3::z()].map(turned)).transpose()
}

impl Look {
    /// How bright a surface is that looks into this direction: the light's doing, or none of it where warmth is seen.
    pub(super) fn lit(self, normal: &Vector3<f64>) -> f64 {
        match self {
            Self::Visible => 0.75 + 0.25 * normal.dot(&Vector3::from(LIGHT)),
            Self::Infrared => 1.0,
        }
    }
}
