//! The shape of a route in space: straight pieces and circular arcs that touch them.

use super::RouteError;
use nalgebra::Vector3;
use skein_domain::{PositionNed, Route};

/// Waypoints nearer than this to the one before are left out.
const MIN_LEG_M: f64 = 0.01;
/// Turns smaller than this need no arc: the change of velocity is under a millimetre per second at usual speeds.
const MIN_TURN_RAD: f64 = 1e-4;
/// With less radius than this a corner is stopped in instead of flown through.
const MIN_RADIUS_M: f64 = 0.25;
/// A tangent with less of it in the plane has no course.
const MIN_LEVEL_SHARE: f64 = 1e-6;

/// One piece of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Piece {
    /// Straight on.
    Straight {
        from: Vector3<f64>,
        direction: Vector3<f64>,
        length_m: f64,
        /// The path has a kink at its end that can be passed at rest only.
        stops_at_end: bool,
    },
    /// An arc that leaves `from` along `direction` and bends towards `inwards`.
    Arc {
        from: Vector3<f64>,
        direction: Vector3<f64>,
        inwards: Vector3<f64>,
        radius_m: f64,
        angle_rad: f64,
    },
}

/// A place on a path: position, unit tangent, and how the tangent changes per metre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    pub position: Vector3<f64>,
    pub tangent: Vector3<f64>,
    pub curvature: Vector3<f64>,
}

impl Point {
    /// Course and its change per metre; `held_rad` without a change where the tangent is vertical.
    pub fn course(&self, held_rad: f64) -> (f64, f64) {
        let level2 = self.tangent.x * self.tangent.x + self.tangent.y * self.tangent.y;
        if level2 < MIN_LEVEL_SHARE * MIN_LEVEL_SHARE {
            return (held_rad, 0.0);
        }
        let turn = (self.tangent.x * self.curvature.y - self.tangent.y * self.curvature.x) / level2;
        (self.tangent.y.atan2(self.tangent.x), turn)
    }
}

impl Piece {
    /// Length along it.
    pub fn length_m(&self) -> f64 {
        match self {
            Self::Straight { length_m, .. } => *length_m,
            Self::Arc {
                radius_m, angle_rad, ..
            } => radius_m * angle_rad,
        }
    }

    /// The place `distance_m` from its begin.
    pub fn at(&self, distance_m: f64) -> Point {
        match *self {
            Self::Straight { from, direction, .. } => Point {
                position: from + direction * distance_m,
                tangent: direction,
                curvature: Vector3::zeros(),
            },
            Self::Arc {
                from,
                direction,
                inwards,
                radius_m,
                ..
            } => {
                let (sin, cos) = (distance_m / radius_m).sin_cos();
                Point {
                    position: from + (direction * sin + inwards * (1.0 - cos)) * radius_m,
                    tangent: direction * cos + inwards * sin,
                    curvature: (inwards * cos - direction * sin) / radius_m,
                }
            }
        }
    }

    /// The tangents among which the steepest climb and the steepest descent of an arc are.
    pub fn steepest(&self) -> Vec<Vector3<f64>> {
        let Self::Arc {
            direction,
            inwards,
            radius_m,
            angle_rad,
            ..
        } = *self
        else {
            return vec![self.at(0.0).tangent];
        };
        let extreme = inwards.z.atan2(direction.z);
        let inside = [extreme, extreme + std::f64::consts::PI, extreme - std::f64::consts::PI]
            .into_iter()
            .filter(|angle| (0.0..=angle_rad).contains(angle));
        [0.0, angle_rad]
            .into_iter()
            .chain(inside)
            .map(|angle| self.at(angle * radius_m).tangent)
            .collect()
    }
}

/// A whole path.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Path {
    pub pieces: Vec<Piece>,
    /// Per piece, the course where it has one of its own at its begin, else that of the piece before.
    pub courses_rad: Vec<f64>,
    pub end: PositionNed,
}

/// How one corner is passed.
#[derive(Debug, Clone, Copy, Default)]
struct Corner {
    /// What the arc takes away from both legs.
    cut_m: f64,
    arc: Option<(Vector3<f64>, f64, f64)>,
    stop: bool,
}

impl Path {
    /// Lays out a route from `start`.
    pub fn new(start: PositionNed, route: &Route) -> Result<Self, RouteError> {
        let legs = legs(start, route)?;
        let corners: Vec<Corner> = legs
            .windows(2)
            .map(|pair| corner(pair, route.corner_radius_m))
            .chain([Corner::default()])
            .collect();
        let mut pieces = Vec::with_capacity(2 * legs.len());
        let (mut at, mut cut_before_m) = (start.vector(), 0.0);
        for ((direction, leg_m), corner) in legs.iter().zip(&corners) {
            let from = at + direction * cut_before_m;
            let length_m = (leg_m - cut_before_m - corner.cut_m).max(0.0);
            pieces.push(Piece::Straight {
                from,
                direction: *direction,
                length_m,
                stops_at_end: corner.stop,
            });
            if let Some((inwards, radius_m, angle_rad)) = corner.arc {
                let from = from + direction * length_m;
                pieces.push(Piece::Arc {
                    from,
                    direction: *direction,
                    inwards,
                    radius_m,
                    angle_rad,
                });
            }
            at += direction * *leg_m;
            cut_before_m = corner.cut_m;
        }
        let first_course = pieces
            .iter()
            .map(|piece| piece.at(0.0).course(f64::NAN).0)
            .find(|course| course.is_finite())
            .unwrap_or(0.0);
        let mut held = first_course;
        let course_of = |piece: &Piece| {
            // An arc out of the vertical has the course it ends with, one into it the course it began with.
            let (begin, end) = (piece.at(0.0).course(held).0, piece.at(piece.length_m()).course(held).0);
            let course = begin;
            held = end;
            course
        };
        let courses_rad = pieces.iter().map(course_of).collect();
        Ok(Self {
            pieces,
            courses_rad,
            end: at.into(),
        })
    }
}

/// Directions and lengths of the legs, without those of no length.
fn legs(start: PositionNed, route: &Route) -> Result<Vec<(Vector3<f64>, f64)>, RouteError> {
    if route.waypoints.is_empty() {
        return Err(RouteError::NoWaypoints);
    }
    if !start.is_finite() {
        return Err(RouteError::StartNotFinite);
    }
    if !(route.corner_radius_m >= 0.0 && route.corner_radius_m.is_finite()) {
        return Err(RouteError::InvalidRadius {
            radius_m: route.corner_radius_m,
        });
    }
    let mut legs = Vec::with_capacity(route.waypoints.len());
    let mut at = start.vector();
    for (index, waypoint) in route.waypoints.iter().enumerate() {
        let way = waypoint.vector() - at;
        let length_m = way.norm();
        if !length_m.is_finite() {
            return Err(RouteError::WaypointNotFinite { index });
        }
        if length_m >= MIN_LEG_M {
            legs.push((way / length_m, length_m));
            at = waypoint.vector();
        }
    }
    if legs.is_empty() {
        Err(RouteError::NoLength)
    } else {
        Ok(legs)
    }
}

/// How the corner between two legs is passed: each leg gives at most half of itself to it.
fn corner(legs: &[(Vector3<f64>, f64)], radius_m: f64) -> Corner {
    let [(direction, before_m), (next, after_m)] = legs else {
        return Corner::default();
    };
    let across = next - direction * direction.dot(next);
    let angle_rad = across.norm().atan2(direction.dot(next));
    if angle_rad < MIN_TURN_RAD {
        return Corner::default();
    }
    let cut_per_radius = (0.5 * angle_rad).tan();
    let cut_m = (radius_m * cut_per_radius).min(0.5 * before_m.min(*after_m));
    let radius_m = cut_m / cut_per_radius;
    // Written so that a radius that is not a number stops too.
    let flyable = radius_m >= MIN_RADIUS_M;
    if !flyable {
        return Corner {
            stop: true,
            ..Corner::default()
        };
    }
    Corner {
        cut_m,
        arc: Some((across / across.norm(), radius_m, angle_rad)),
        stop: false,
    }
}
