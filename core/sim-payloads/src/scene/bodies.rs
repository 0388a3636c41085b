//! Ellipsoids where they stand in the world: how far they reach in a picture, and how those that have a heading are drawn.
//!
//! Must never do: draw outside of the bounds that it gives.

use super::canvas::{Canvas, Colour};
use super::shapes::{self, MOST_PARTS, Part};
use super::solids::{self, Sampling};
use super::{Lens, Look, NEAREST_M, SceneTarget};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// What looks smaller than this is sampled so often along each side of a pixel: the thinner wings and blades are, the more often.
const SAMPLES: [(f64, u32); 4] = [(24.0, 8), (48.0, 6), (100.0, 4), (160.0, 2)];

/// An ellipsoid in the world.
pub(super) struct Solid {
    middle: Vector3<f64>,
    /// From the unit ball to the ellipsoid about its middle.
    axes: Matrix3<f64>,
}

/// Everything that a target is made of.
pub(super) fn solids(target: &SceneTarget) -> impl Iterator<Item = Solid> {
    let simple = solids::parts(target.kind).iter().map(|part| {
        let turn = solids::axes();
        (turn * Vector3::from(part.middle), turn * diagonal(part.half))
    });
    let turn = attitude(target);
    let jointed = shapes::parts(target.kind).unwrap_or_default().iter();
    let jointed = jointed.map(move |part| {
        let (middle, posed) = part.posed(target.beat_rad);
        (turn * middle, turn.matrix() * posed.matrix() * diagonal(part.half))
    });
    simple.chain(jointed).map(|(middle, axes)| Solid {
        middle: target.position.vector() + middle * target.size_m,
        axes: axes * target.size_m,
    })
}

fn diagonal(values: [f64; 3]) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::from(values))
}

fn attitude(target: &SceneTarget) -> Rotation3<f64> {
    Rotation3::from_euler_angles(target.roll_rad, target.pitch_rad, target.yaw_rad)
}

/// The smallest box around something in a picture, in pixels; it may reach out of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extent {
    pub(super) left_px: f64,
    pub(super) right_px: f64,
    pub(super) top_px: f64,
    pub(super) bottom_px: f64,
}

impl Extent {
    /// Around a whole target, and around what of it lies within the picture, if anything does; `None` if any of it is not ahead of the camera.
    pub(super) fn of(target: &SceneTarget, lens: &Lens) -> Option<(Self, Option<Self>)> {
        let mut extents = solids(target).map(|solid| Self::of_solid(&solid, lens));
        let first = extents.next()??;
        // Part by part: the corner of a box around everything may be empty.
        extents.try_fold((first, first.within(lens)), |(whole, inside), next| {
            let next = next?;
            let inside = match (inside, next.within(lens)) {
                (Some(one), Some(other)) => Some(one.and(&other)),
                (one, other) => one.or(other),
            };
            Some((whole.and(&next), inside))
        })
    }

    /// Around this and another one.
    fn and(&self, other: &Self) -> Self {
        Self {
            left_px: self.left_px.min(other.left_px),
            right_px: self.right_px.max(other.right_px),
            top_px: self.top_px.min(other.top_px),
            bottom_px: self.bottom_px.max(other.bottom_px),
        }
    }

    fn of_solid(solid: &Solid, lens: &Lens) -> Option<Self> {
        let across = Silhouette::along(solid, lens, &lens.right)?;
        let along = Silhouette::along(solid, lens, &lens.down)?;
        let (middle_x_px, middle_y_px) = (0.5 * f64::from(lens.width_px), 0.5 * f64::from(lens.height_px));
        Some(Self {
            left_px: middle_x_px + across.low_px,
            right_px: middle_x_px + across.high_px,
            top_px: middle_y_px + along.low_px,
            bottom_px: middle_y_px + along.high_px,
        })
    }

    /// What of it lies within a picture; `None` if nothing does.
    fn within(&self, lens: &Lens) -> Option<Self> {
        let inside = Self {
            left_px: self.left_px.max(0.0),
            right_px: self.right_px.min(f64::from(lens.width_px)),
            top_px: self.top_px.max(0.0),
            bottom_px: self.bottom_px.min(f64::from(lens.height_px)),
        };
        (inside.width_px() > 0.0 && inside.height_px() > 0.0).then_some(inside)
    }

    /// Whether any of a pixel is in it.
    fn touches(&self, column: u32, row: u32) -> bool {
        let (left_px, top_px) = (f64::from(column), f64::from(row));
        self.left_px < left_px + 1.0 && self.right_px > left_px && self.top_px < top_px + 1.0 && self.bottom_px > top_px
    }

    pub(super) fn width_px(&self) -> f64 {
        self.right_px - self.left_px
    }

    pub(super) fn height_px(&self) -> f64 {
        self.bottom_px - self.top_px
    }
}

/// How far an ellipsoid reaches along one axis of a picture, from its middle.
struct Silhouette {
    low_px: f64,
    high_px: f64,
}

impl Silhouette {
    /// The planes through the eye that touch it and are square to the axis: where a line of sight just meets the ellipsoid.
    fn along(solid: &Solid, lens: &Lens, axis: &Vector3<f64>) -> Option<Self> {
        let offset = solid.middle - lens.eye;
        let (depth, aside) = (offset.dot(&lens.forward), offset.dot(axis));
        let (forward, sideways) = (solid.axes.tr_mul(&lens.forward), solid.axes.tr_mul(axis));
        let ahead = depth - forward.norm() >= NEAREST_M;
        if !ahead {
            return None;
        }
        // A plane at the slope s touches where (aside - s depth)^2 = |sideways - s forward|^2.
        let a = depth * depth - forward.norm_squared();
        let b = aside * depth - sideways.dot(&forward);
        let c = aside * aside - sideways.norm_squared();
        let root = (b * b - a * c).max(0.0).sqrt();
        let (low_px, high_px) = ((b - root) / a * lens.focal_px, (b + root) / a * lens.focal_px);
        (low_px.is_finite() && high_px.is_finite()).then_some(Self { low_px, high_px })
    }
}

/// One part made ready for rays from the eye.
struct Facing {
    extent: Extent,
    /// From the world to where the part is the unit ball.
    to_ball: Matrix3<f64>,
    from: Vector3<f64>,
    colour: Colour,
}

impl Facing {
    fn new(solid: &Solid, part: &Part, lens: &Lens, look: Look) -> Option<Self> {
        let to_ball = solid.axes.try_inverse()?;
        Some(Self {
            extent: Extent::of_solid(solid, lens)?,
            to_ball,
            from: to_ball * (lens.eye - solid.middle),
            colour: match look {
                Look::Visible => part.paint.colour,
                Look::Infrared => [part.paint.heat; 3],
            },
        })
    }

    /// How far along a ray it is, and which way its surface looks there.
    fn hit(&self, ray: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let along = self.to_ball * ray;
        let (a, b, c) = (
            along.norm_squared(),
            self.from.dot(&along),
            self.from.norm_squared() - 1.0,
        );
        let root = b * b - a * c;
        if root < 0.0 {
            return None;
        }
        let distance = (-b - root.sqrt()) / a;
        (distance > 0.0).then(|| (distance, self.to_ball.tr_mul(&(self.from + along * distance))))
    }
}

/// Draws a target that has a heading over what is there.
pub(super) fn draw(target: &SceneTarget, lens: &Lens, look: Look, canvas: &mut Canvas<'_>) {
    let parts = shapes::parts(target.kind).unwrap_or_default();
    let Some((whole, Some(inside))) = Extent::of(target, lens) else {
        return;
    };
    let mut facing: [Option<Facing>; MOST_PARTS] = Default::default();
    for ((place, solid), part) in facing.iter_mut().zip(solids(target)).zip(parts) {
        *place = Facing::new(&solid, part, lens, look);
    }
    // Most pixels of a box are empty, and most others meet one part or two.
    let near = |column: u32, row: u32| {
        let numbered = facing.iter().flatten().zip(0_u32..);
        numbered
            .filter(|(part, _)| part.extent.touches(column, row))
            .fold(0, |near, (_, number)| near | 1 << number)
    };
    let hit = |near: u32, ray: &Vector3<f64>| {
        let parts = facing
            .iter()
            .flatten()
            .zip(0_u32..)
            .filter(|(_, number)| near >> number & 1 == 1);
        let hits = parts.filter_map(|(part, _)| Some((part.hit(ray)?, part)));
        let ((_, normal), part) = hits.min_by(|((a, _), _), ((b, _), _)| a.total_cmp(b))?;
        let lit = look.lit(&normal.normalize());
        Some(part.colour.map(|value| f64::from(value) * lit))
    };
    let longest_px = whole.width_px().max(whole.height_px());
    let samples = SAMPLES.iter().find(|(below_px, _)| longest_px < *below_px);
    let sampling = Sampling::new(lens, samples.map_or(1, |(_, samples)| *samples));
    for row in inside.top_px as u32..inside.bottom_px.ceil() as u32 {
        for column in inside.left_px as u32..inside.right_px.ceil() as u32 {
            let near = near(column, row);
            if near == 0 {
                continue;
            }
            let (share, colour) = sampling.pixel(column, row, |ray| hit(near, ray));
            if share > 0.0 {
                let pixel = row as usize * lens.width_px as usize + column as usize;
                canvas.cover(pixel, colour, share);
            }
        }
    }
}
