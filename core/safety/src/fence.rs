//! Fences: polygons on the ground with a floor and a ceiling, and several of them together. They know whether a place is inside, how
//! far outside, whether a straight way stays inside, and how fast a boundary may be approached.

mod approach;
mod clearance;
mod fences;
mod plan;
mod plane;
mod walls;
mod zone;

pub use approach::Approach;
pub use clearance::Clearance;
pub use fences::{Breach, Fences};
pub use plan::FencePlanError;
pub use walls::Wall;
pub use zone::Zone;

use plane::{distance_to_edge_m, edges, even_odd, on_edge, signed_area, touch, touches_at};
use skein_domain::{PositionNed, Refusal};
use thiserror::Error;

/// Why a fence cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FenceError {
    /// A polygon has at least three corners.
    #[error("a fence needs at least 3 corners, {count} were given")]
    TooFewVertices {
        /// How many were given, a repeated last one not counted.
        count: usize,
    },
    /// More corners than are worth checking 50 times a second.
    #[error("a fence may have at most {limit} corners, {count} were given")]
    TooManyVertices {
        /// How many were given.
        count: usize,
        /// How many are allowed.
        limit: usize,
    },
    /// A corner is not finite.
    #[error("corner {index} of the fence is not finite")]
    NotFinite {
        /// Its place in the list, from 0.
        index: usize,
    },
    /// Two edges cross, touch or lie on each other; twice the same edge is one without length.
    #[error("the fence crosses or touches itself: edges {first} and {second}")]
    SelfIntersecting {
        /// The edge that begins at the corner of this number, from 0.
        first: usize,
        /// The other edge.
        second: usize,
    },
    /// Nothing is inside.
    #[error("the fence encloses no area")]
    NoArea,
    /// The floor is not below the ceiling, or one of them is not a number.
    #[error("the floor at {floor_m} m must be below the ceiling at {ceiling_m} m")]
    FloorAboveCeiling {
        /// The floor in metres.
        floor_m: f64,
        /// The ceiling in metres.
        ceiling_m: f64,
    },
}

/// Places this near to the boundary count as on it, and so as inside.
const ON_EDGE_M: f64 = 1e-6;
/// More corners than this are refused.
const MAX_VERTICES: usize = 1000;

/// A polygon in north and east with floor and ceiling as heights above the swarm's origin. The boundary belongs to the inside.
#[derive(Debug, Clone, PartialEq)]
pub struct Fence {
    vertices: Vec<[f64; 2]>,
    south_west: [f64; 2],
    north_east: [f64; 2],
    convex: bool,
    floor_m: f64,
    ceiling_m: f64,
}

/// How far a place is outside, part by part; all zero inside.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Excess {
    /// Horizontal distance to the polygon in metres.
    pub outside_m: f64,
    /// Height above the ceiling in metres.
    pub above_m: f64,
    /// Depth below the floor in metres.
    pub below_m: f64,
}

impl Excess {
    /// Whether the place is inside.
    #[must_use]
    pub fn is_inside(&self) -> bool {
        // Written so that a part that is not a number is not inside.
        self.outside_m <= 0.0 && self.above_m <= 0.0 && self.below_m <= 0.0
    }

    /// All parts as one distance in metres.
    #[must_use]
    pub fn distance_m(&self) -> f64 {
        self.outside_m.hypot(self.above_m).hypot(self.below_m)
    }

    /// Whether no part is larger than in `other`: moving from there to here makes nothing worse.
    #[must_use]
    pub fn is_no_worse_than(&self, other: &Self) -> bool {
        self.outside_m <= other.outside_m && self.above_m <= other.above_m && self.below_m <= other.below_m
    }
}

impl Fence {
    /// A fence from its corners `[north, east]` in metres in the swarm frame, in either direction; the first may be repeated at the
    /// end. `floor_m` and `ceiling_m` are heights above the swarm's origin.
    ///
    /// # Errors
    /// [`FenceError`] if it is not a simple polygon or a number is not usable.
    pub fn new(vertices: Vec<[f64; 2]>, floor_m: f64, ceiling_m: f64) -> Result<Self, FenceError> {
        if !(floor_m.is_finite() && ceiling_m.is_finite()) {
            return Err(FenceError::FloorAboveCeiling { floor_m, ceiling_m });
        }
        Self::open(vertices, floor_m, ceiling_m)
    }

    /// The same, but the floor may be minus infinity and the ceiling infinity: a side without a limit.
    pub(crate) fn open(mut vertices: Vec<[f64; 2]>, floor_m: f64, ceiling_m: f64) -> Result<Self, FenceError> {
        if let Some(index) = vertices.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
            return Err(FenceError::NotFinite { index });
        }
        if vertices.len() > 1 && vertices.first() == vertices.last() {
            vertices.pop();
        }
        let count = vertices.len();
        if count < 3 {
            return Err(FenceError::TooFewVertices { count });
        }
        if count > MAX_VERTICES {
            return Err(FenceError::TooManyVertices {
                count,
                limit: MAX_VERTICES,
            });
        }
        if floor_m.is_nan() || ceiling_m.is_nan() || floor_m >= ceiling_m {
            return Err(FenceError::FloorAboveCeiling { floor_m, ceiling_m });
        }
        if let Some((first, second)) = first_self_contact(&vertices) {
            return Err(FenceError::SelfIntersecting { first, second });
        }
        let area_m2 = signed_area(&vertices).abs();
        if !(area_m2 > 0.0 && area_m2.is_finite()) {
            return Err(FenceError::NoArea);
        }
        let fold = |pick: fn(f64, f64) -> f64, start: f64| {
            vertices
                .iter()
                .fold([start; 2], |so_far, v| [pick(so_far[0], v[0]), pick(so_far[1], v[1])])
        };
        Ok(Self {
            south_west: fold(f64::min, f64::INFINITY),
            north_east: fold(f64::max, f64::NEG_INFINITY),
            convex: plane::is_convex(&vertices),
            vertices,
            floor_m,
            ceiling_m,
        })
    }

    /// The corners `[north, east]` in metres.
    #[must_use]
    pub fn vertices(&self) -> &[[f64; 2]] {
        &self.vertices
    }

    /// Height of the floor above the swarm's origin in metres.
    #[must_use]
    pub fn floor_m(&self) -> f64 {
        self.floor_m
    }

    /// Height of the ceiling above the swarm's origin in metres.
    #[must_use]
    pub fn ceiling_m(&self) -> f64 {
        self.ceiling_m
    }

    /// How far a place is outside. A place that is not finite is infinitely far outside.
    #[must_use]
    pub fn excess(&self, position: &PositionNed) -> Excess {
        if !position.is_finite() {
            return Excess {
                outside_m: f64::INFINITY,
                above_m: f64::INFINITY,
                below_m: f64::INFINITY,
            };
        }
        let height_m = -position.down_m;
        Excess {
            outside_m: self.outside_m([position.north_m, position.east_m]),
            above_m: (height_m - self.ceiling_m).max(0.0),
            below_m: (self.floor_m - height_m).max(0.0),
        }
    }

    /// The same for a vehicle that may stand on the ground, where the floor does not count.
    pub(crate) fn excess_standing(&self, position: &PositionNed, airborne: bool) -> Excess {
        let mut excess = self.excess(position);
        if !airborne {
            excess.below_m = if excess.below_m.is_finite() {
                0.0
            } else {
                excess.below_m
            };
        }
        excess
    }

    /// Whether a place is inside (the boundary is).
    ///
    /// # Errors
    /// [`Refusal::OutsideFence`] with the limit that is exceeded, or [`Refusal::InvalidValue`] for a place that is not finite.
    pub fn contains(&self, position: &PositionNed) -> Result<(), Refusal> {
        if !position.is_finite() {
            return Err(Refusal::invalid("position is not finite"));
        }
        let excess = self.excess(position);
        if excess.is_inside() {
            Ok(())
        } else {
            Err(self.refusal(position, &excess))
        }
    }

    /// Whether the straight way between two places stays inside.
    ///
    /// # Errors
    /// As [`Self::contains`].
    pub fn contains_way(&self, from: &PositionNed, to: &PositionNed) -> Result<(), Refusal> {
        self.contains(from)?;
        self.contains(to)?;
        let (a, b) = ([from.north_m, from.east_m], [to.north_m, to.east_m]);
        if self.convex || self.way_is_inside(a, b) {
            return Ok(());
        }
        Err(Refusal::OutsideFence {
            detail: format!(
                "the straight way from ({:.1}, {:.1}) to ({:.1}, {:.1}) m crosses the boundary",
                a[0], a[1], b[0], b[1]
            ),
        })
    }

    /// The refusal for a place with this excess.
    pub(crate) fn refusal(&self, position: &PositionNed, excess: &Excess) -> Refusal {
        let height_m = -position.down_m;
        let detail = if excess.outside_m > 0.0 {
            format!("{:.1} m beyond the boundary", excess.outside_m)
        } else if excess.above_m > 0.0 {
            format!("height {height_m:.1} m is over the ceiling of {:.1} m", self.ceiling_m)
        } else {
            format!("height {height_m:.1} m is under the floor of {:.1} m", self.floor_m)
        };
        Refusal::OutsideFence { detail }
    }

    /// Horizontal distance to the polygon; zero inside and on the boundary.
    fn outside_m(&self, p: [f64; 2]) -> f64 {
        let in_box = p[0] >= self.south_west[0] - ON_EDGE_M
            && p[0] <= self.north_east[0] + ON_EDGE_M
            && p[1] >= self.south_west[1] - ON_EDGE_M
            && p[1] <= self.north_east[1] + ON_EDGE_M;
        if in_box && (even_odd(&self.vertices, p) || edges(&self.vertices).any(|e| on_edge(e, p, ON_EDGE_M))) {
            return 0.0;
        }
        edges(&self.vertices)
            .map(|e| distance_to_edge_m(e, p))
            .fold(f64::INFINITY, f64::min)
    }

    /// For two places inside: whether the way between them is too. Between two places where it touches the boundary it is either
    /// all inside or all outside.
    fn way_is_inside(&self, a: [f64; 2], b: [f64; 2]) -> bool {
        let mut shares: Vec<f64> = edges(&self.vertices).flat_map(|e| touches_at(a, b, e)).collect();
        shares.extend([0.0, 1.0]);
        shares.sort_by(f64::total_cmp);
        shares.windows(2).all(|pair| {
            let middle = 0.5 * pair.iter().sum::<f64>();
            self.outside_m([a[0] + (b[0] - a[0]) * middle, a[1] + (b[1] - a[1]) * middle]) <= 0.0
        })
    }
}

/// The first two edges that touch each other other than as neighbours in their common corner.
fn first_self_contact(vertices: &[[f64; 2]]) -> Option<(usize, usize)> {
    let count = vertices.len();
    let all: Vec<_> = edges(vertices).collect();
    if let Some(empty) = all.iter().position(|e| e[0] == e[1]) {
        return Some((empty, empty));
    }
    for (first, e) in all.iter().enumerate() {
        for (second, f) in all.iter().enumerate().skip(first + 1) {
            let contact = if second == first + 1 {
                plane::folds_back(*e, *f)
            } else if first == 0 && second == count - 1 {
                plane::folds_back(*f, *e)
            } else {
                touch(*e, *f)
            };
            if contact {
                return Some((first, second));
            }
        }
    }
    None
}

#[cfg(test)]
pub(crate) mod tests;
