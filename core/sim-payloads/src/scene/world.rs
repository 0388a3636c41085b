//! Sky and ground: a gradient, a horizon in haze, and fields with a grid that stay where they are when the camera moves.
//!
//! Must never do: flicker. What is finer than a pixel fades out with the distance.

use super::canvas::{Canvas, Colour};
use super::clouds::Clouds;
use super::{Lens, Look, Scene};

/// What the world looks like before any light and distance.
struct Palette {
    zenith: Colour,
    haze: Colour,
    field: Colour,
    line: Colour,
    cloud: Colour,
}

const VISIBLE: Palette = Palette {
    zenith: [92.0, 140.0, 210.0],
    haze: [205.0, 216.0, 226.0],
    field: [104.0, 124.0, 82.0],
    line: [196.0, 190.0, 170.0],
    cloud: [236.0, 238.0, 240.0],
};
/// A sky that is the colder the higher one looks; soil and clouds are warmer.
const INFRARED: Palette = Palette {
    zenith: [22.0; 3],
    haze: [84.0; 3],
    field: [108.0; 3],
    line: [124.0; 3],
    cloud: [66.0; 3],
};
/// Fields differ in brightness by up to this share.
const FIELD_SPREAD: f32 = 0.16;
/// Side of a field, and width of the line between two, in metres.
const FIELD_M: f32 = 10.0;
const LINE_M: f32 = 0.3;
/// The ground turns to haze over this distance, in metres.
const HAZE_M: f32 = 900.0;

/// What is the same for all pixels.
struct Ground<'a> {
    palette: &'a Palette,
    seed: u32,
    eye_north_m: f32,
    eye_east_m: f32,
    /// Height of the camera over the ground in metres; it never is below.
    height_m: f32,
    /// Radians per pixel.
    pixel_rad: f32,
}

/// Draws every pixel.
pub(super) fn draw(scene: &Scene, lens: &Lens, canvas: &mut Canvas<'_>) {
    let palette = match scene.look {
        Look::Visible => &VISIBLE,
        Look::Infrared => &INFRARED,
    };
    let clouds = Clouds::new(scene, lens);
    let ground = Ground {
        palette,
        seed: scene.seed,
        eye_north_m: lens.eye.x as f32,
        eye_east_m: lens.eye.y as f32,
        height_m: (scene.ground_down_m - lens.eye.z).max(0.05) as f32,
        pixel_rad: (1.0 / lens.focal_px) as f32,
    };
    let step = (lens.right / lens.focal_px).cast::<f32>();
    for row in 0..lens.height_px {
        let first = lens.ray(0.5, f64::from(row) + 0.5).cast::<f32>();
        canvas.row(row as usize, lens.width_px as usize, |column| {
            let ray = first + step * column as f32;
            let level = (ray.x * ray.x + ray.y * ray.y).sqrt();
            if ray.z <= 0.0 {
                let clear = palette.sky(-ray.z / level.max(1e-6));
                match &clouds {
                    None => clear,
                    Some(clouds) => mix(clear, palette.cloud, clouds.share(ray.x, ray.y, -ray.z, level)),
                }
            } else {
                ground.colour(ray.x, ray.y, ray.z, level)
            }
        });
    }
}

impl Palette {
    /// The clear sky at a slope over the horizon.
    fn sky(&self, slope: f32) -> Colour {
        let up = slope / (slope + 0.35);
        mix(self.haze, self.zenith, up)
    }
}

impl Ground<'_> {
    fn colour(&self, north: f32, east: f32, down: f32, level: f32) -> Colour {
        let reach = self.height_m / down;
        let (north_m, east_m) = (self.eye_north_m + north * reach, self.eye_east_m + east * reach);
        let distance_m = level * reach;
        let haze = distance_m / (distance_m + HAZE_M);
        // Length on the ground that one pixel takes, along the view, where it is longest.
        let pixel_m = self.pixel_rad * reach * (1.0 + distance_m / self.height_m);
        let sharp = FIELD_M / (FIELD_M + 2.0 * pixel_m);
        let ((row, north_edge_m), (column, east_edge_m)) = (place(north_m), place(east_m));
        let tone = 1.0 + FIELD_SPREAD * sharp * sharp * tone(self.seed, row, column);
        let [red, green, blue] = self.palette.field;
        let field = [red * tone, green * tone, blue * tone];
        let edge_m = north_edge_m.min(east_edge_m);
        // The line's share of the pixel; far away, of the field.
        let share = ((0.5 * (LINE_M + pixel_m) - edge_m) / pixel_m.max(1e-3)).clamp(0.0, 1.0)
            * (LINE_M / pixel_m.max(LINE_M)).min(1.0);
        mix(mix(field, self.palette.line, share), self.palette.haze, haze)
    }
}

/// Chance at a point of a grid, -1..1: always the same one.
pub(super) fn tone(seed: u32, row: i32, column: i32) -> f32 {
    let mut bits = seed ^ (row as u32).wrapping_mul(0x9E37_79B1) ^ (column as u32).wrapping_mul(0x85EB_CA77);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x2C1B_3C6D);
    bits = (bits ^ (bits >> 12)).wrapping_mul(0x297A_2D39);
    bits ^= bits >> 15;
    (bits >> 8) as f32 / (1 << 23) as f32 - 1.0
}

/// Which field, and how far from the nearest line between two, in metres.
fn place(along_m: f32) -> (i32, f32) {
    let fields = along_m * (1.0 / FIELD_M);
    // Rounding down by way of a whole number: the library's own is a call per pixel.
    let toward_zero = fields as i32;
    let field = toward_zero.wrapping_sub(i32::from(fields < toward_zero as f32));
    let within_m = along_m - field as f32 * FIELD_M;
    (field, within_m.min(FIELD_M - within_m))
}

fn mix([r0, g0, b0]: Colour, [r1, g1, b1]: Colour, share: f32) -> Colour {
    [r0 + (r1 - r0) * share, g0 + (g1 - g0) * share, b0 + (b1 - b0) * share]
}
