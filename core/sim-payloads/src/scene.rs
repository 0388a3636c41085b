//! What a camera would see: a pinhole picture of a flat world with vehicles and other things in it, and where in the picture a place lies.
//! The same seed, pose and targets give the same picture.
//!
//! * [`Scene`]: draws it. [`truth()`]: what is in it, and where.
//! * [`SceneObject`]: something that moves by itself, and where it is at a time.
//! * [`Flaws`]: what is wrong with a camera: light, noise, wind, where it thinks that it looks.
//!
//! Must never do: allocate per picture, read a clock, or draw what is behind the camera.

mod bodies;
mod canvas;
mod clouds;
pub mod flaws;
pub mod objects;
mod shapes;
mod solids;
mod truth;
mod world;

pub use flaws::Flaws;
pub use objects::{ObjectPath, SceneObject};
pub use truth::{Seen, truth};

use canvas::Canvas;
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::payload::CameraPose;
use skein_domain::{PositionNed, VelocityNed};

/// Nothing nearer than this is seen, in metres.
const NEAREST_M: f64 = 0.2;
/// The field of view is taken to be no narrower and no wider than this, in radians.
const NARROWEST_RAD: f64 = 1e-3;
const WIDEST_RAD: f64 = 3.0;

/// Something in the world beside the ground, at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SceneTarget {
    /// Its middle.
    pub position: PositionNed,
    /// How wide it is from tip to tip, in metres.
    pub size_m: f64,
    /// What it looks like.
    pub kind: TargetKind,
    /// Where it goes. It is not drawn; who asks for the truth is told.
    pub velocity: VelocityNed,
    /// Its roll, to the right; as the other angles, of no effect on a multirotor or a marker.
    pub roll_rad: f64,
    /// Its pitch, upwards.
    pub pitch_rad: f64,
    /// Where its nose points, clockwise from north.
    pub yaw_rad: f64,
    /// How far its wings or rotor are within a beat or a turn.
    pub beat_rad: f64,
}

/// What something in the world looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TargetKind {
    /// A dark multirotor, as vehicles of the swarm are drawn: a body, four arms, four rotors.
    #[default]
    Multirotor,
    /// A red ball.
    Marker,
    /// A light quadrotor with a camera and skids, somebody else's.
    Quadrotor,
    /// A small aeroplane without a crew: long wings, a tail in the shape of a V.
    FixedWing,
    /// A bird that beats its wings.
    Bird,
    /// A light aeroplane with high wings.
    Aeroplane,
    /// A helicopter with a turning rotor and a tail.
    Helicopter,
}

impl TargetKind {
    /// Its name, as configurations have it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Multirotor => "multirotor",
            Self::Marker => "marker",
            Self::Quadrotor => "quadrotor",
            Self::FixedWing => "fixed_wing",
            Self::Bird => "bird",
            Self::Aeroplane => "aeroplane",
            Self::Helicopter => "helicopter",
        }
    }
}

/// A world to take pictures of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scene {
    seed: u32,
    ground_down_m: f64,
    look: Look,
    clouds: f64,
}

/// What a camera is sensitive to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Look {
    /// Light, in colour.
    #[default]
    Visible,
    /// Warmth, in grey: warm bodies are bright, the sky is dark, the ground in between.
    Infrared,
}

impl Scene {
    /// A world with a ground at the height of the swarm frame's origin.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self::with_ground(seed, 0.0)
    }

    /// A world with a ground so much below the swarm frame's origin.
    #[must_use]
    pub fn with_ground(seed: u64, ground_down_m: f64) -> Self {
        Self {
            seed: (seed ^ (seed >> 32)) as u32,
            ground_down_m,
            look: Look::Visible,
            clouds: 0.0,
        }
    }

    /// The same world to another camera.
    #[must_use]
    pub fn with_look(self, look: Look) -> Self {
        Self { look, ..self }
    }

    /// The same world under clouds that cover about this share of its sky, 0..=1.
    #[must_use]
    pub fn with_clouds(self, clouds: f64) -> Self {
        Self { clouds, ..self }
    }

    /// Draws a picture, three bytes per pixel: red, green, blue, row by row from the top. Draws the rows that fit into `out`.
    pub fn render(&self, pose: &CameraPose, targets: &[SceneTarget], width_px: u32, height_px: u32, out: &mut [u8]) {
        let lens = Lens::new(pose, (width_px, height_px));
        let mut canvas = Canvas::new(out);
        world::draw(self, &lens, &mut canvas);
        // From the farthest to the nearest; a list in order would have to be allocated.
        let mut drawn = (f64::INFINITY, usize::MAX);
        while let Some((order, target)) = farthest_after(&lens, targets, drawn) {
            match target.kind {
                TargetKind::Multirotor | TargetKind::Marker => solids::draw(target, &lens, self.look, &mut canvas),
                _ => bodies::draw(target, &lens, self.look, &mut canvas),
            }
            drawn = order;
        }
    }
}

/// The farthest target that comes after `drawn` in the order of drawing.
fn farthest_after<'a>(
    lens: &Lens,
    targets: &'a [SceneTarget],
    drawn: (f64, usize),
) -> Option<((f64, usize), &'a SceneTarget)> {
    targets
        .iter()
        .enumerate()
        .map(|(index, target)| ((lens.depth_m(&target.position), index), target))
        .filter(|((depth_m, index), _)| *depth_m < drawn.0 || (*depth_m == drawn.0 && *index < drawn.1))
        .max_by(|(a, _), (b, _)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
}

/// Where in a picture of this size a place lies, in pixels from its upper left corner to the right and down; `None` if it is behind
/// the camera. It may lie outside of the picture.
#[must_use]
pub fn project(pose: &CameraPose, position: &PositionNed, width_px: u32, height_px: u32) -> Option<(f64, f64)> {
    Lens::new(pose, (width_px, height_px)).project(&position.vector())
}

/// How many pixels an angle takes in the middle of a picture of this width, per radian.
#[must_use]
pub fn focal_length_px(field_of_view_rad: f64, width_px: u32) -> f64 {
    let half = 0.5 * field_of_view_rad.clamp(NARROWEST_RAD, WIDEST_RAD);
    0.5 * f64::from(width_px) / half.tan()
}

/// A camera's pose made ready for computing with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lens {
    eye: Vector3<f64>,
    forward: Vector3<f64>,
    right: Vector3<f64>,
    down: Vector3<f64>,
    focal_px: f64,
    width_px: u32,
    height_px: u32,
}

impl Lens {
    fn new(pose: &CameraPose, (width_px, height_px): (u32, u32)) -> Self {
        let (sin_pitch, cos_pitch) = pose.pitch_rad.sin_cos();
        let (sin_yaw, cos_yaw) = pose.yaw_rad.sin_cos();
        let (sin_roll, cos_roll) = pose.roll_rad.sin_cos();
        let forward = Vector3::new(cos_pitch * cos_yaw, cos_pitch * sin_yaw, -sin_pitch);
        let level_right = Vector3::new(-sin_yaw, cos_yaw, 0.0);
        let level_down = forward.cross(&level_right);
        Self {
            eye: pose.position.vector(),
            forward,
            right: level_right * cos_roll + level_down * sin_roll,
            down: level_down * cos_roll - level_right * sin_roll,
            focal_px: focal_length_px(pose.field_of_view_rad, width_px),
            width_px,
            height_px,
        }
    }

    fn depth_m(&self, position: &PositionNed) -> f64 {
        (position.vector() - self.eye).dot(&self.forward)
    }

    fn project(&self, place: &Vector3<f64>) -> Option<(f64, f64)> {
        let offset = place - self.eye;
        let depth_m = offset.dot(&self.forward);
        if depth_m < NEAREST_M || !depth_m.is_finite() {
            return None;
        }
        let scale = self.focal_px / depth_m;
        Some((
            0.5 * f64::from(self.width_px) + offset.dot(&self.right) * scale,
            0.5 * f64::from(self.height_px) + offset.dot(&self.down) * scale,
        ))
    }

    /// The direction a point of the picture is seen in; its part along the optical axis is one.
    fn ray(&self, right_px: f64, down_px: f64) -> Vector3<f64> {
        let across = (right_px - 0.5 * f64::from(self.width_px)) / self.focal_px;
        let along = (down_px - 0.5 * f64::from(self.height_px)) / self.focal_px;
        self.forward + self.right * across + self.down * along
    }
}

#[cfg(test)]
mod tests;
