//! A leader's route over time: straight legs, rounded corners, and a speed that is never above the asked one nor more than the
//! acceleration allows in the corners.

mod path;

use crate::speed::{Phase, ramps};
use nalgebra::Vector3;
use path::{Path, Piece};
use skein_domain::{AccelerationNed, PositionNed, Route, VelocityNed};
use thiserror::Error;

/// Why a route cannot be flown.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RouteError {
    /// There is no waypoint.
    #[error("a route needs at least one waypoint")]
    NoWaypoints,
    /// All waypoints are where the route starts.
    #[error("the route has no length: all waypoints are where it starts")]
    NoLength,
    /// The start is not finite.
    #[error("the start of the route is not finite")]
    StartNotFinite,
    /// A waypoint is not finite, or too far to be counted with.
    #[error("waypoint {index} is not finite")]
    WaypointNotFinite {
        /// Its place in the list, from 0.
        index: usize,
    },
    /// A limit is not usable.
    #[error("{limit} = {value}: it must be a finite number above zero")]
    InvalidLimit {
        /// Which one.
        limit: &'static str,
        /// What was given.
        value: f64,
    },
    /// The corner radius is negative or not finite.
    #[error("corner radius {radius_m} m: it must be a finite number, zero or above")]
    InvalidRadius {
        /// What was given.
        radius_m: f64,
    },
}

impl RouteError {
    /// The same about the route without the corner in front of it.
    fn without_lead_in(self) -> Self {
        match self {
            Self::WaypointNotFinite { index } => Self::WaypointNotFinite {
                index: index.saturating_sub(1),
            },
            other => other,
        }
    }
}

/// What a vehicle can do along a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathLimits {
    /// Largest acceleration, along the path and across it, in metres per second squared.
    pub acceleration_m_s2: f64,
    /// Largest climb rate in metres per second.
    pub climb_m_s: f64,
    /// Largest descent rate in metres per second.
    pub descent_m_s: f64,
}

impl PathLimits {
    /// No limit to climb and descent but the speed along the path.
    #[must_use]
    pub fn level(acceleration_m_s2: f64) -> Self {
        Self {
            acceleration_m_s2,
            climb_m_s: f64::MAX,
            descent_m_s: f64::MAX,
        }
    }

    pub(crate) fn check(&self, speed_m_s: f64) -> Result<(), RouteError> {
        for (limit, value) in [
            ("speed_m_s", speed_m_s),
            ("acceleration_m_s2", self.acceleration_m_s2),
            ("climb_m_s", self.climb_m_s),
            ("descent_m_s", self.descent_m_s),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(RouteError::InvalidLimit { limit, value });
            }
        }
        Ok(())
    }

    /// The speed along a direction that keeps climb and descent within their limits.
    pub(crate) fn speed_along(&self, direction: &Vector3<f64>, speed_m_s: f64) -> f64 {
        let down = direction.z;
        let vertical = if down < 0.0 {
            self.climb_m_s / -down
        } else {
            self.descent_m_s / down
        };
        // A level direction divides by zero: infinite, or not a number, which `min` leaves out.
        speed_m_s.min(vertical)
    }
}

/// Where the leader should be at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RouteSample {
    /// Position.
    pub position: PositionNed,
    /// Velocity.
    pub velocity: VelocityNed,
    /// Acceleration.
    pub acceleration: AccelerationNed,
    /// Course over ground in radians, clockwise from north; on a vertical piece that of the piece before it.
    pub course_rad: f64,
    /// Its rate in radians per second.
    pub course_rate_rad_s: f64,
    /// Whether it is in a rounded corner.
    pub turning: bool,
    /// Whether the end is reached.
    pub finished: bool,
}

/// One phase of constant acceleration on one piece of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stretch {
    start_s: f64,
    piece: usize,
    phase: Phase,
}

/// A route laid out in space and time, built once.
#[derive(Debug, Clone, PartialEq)]
pub struct RouteTrajectory {
    path: Path,
    stretches: Vec<Stretch>,
    duration_s: f64,
}

impl RouteTrajectory {
    /// The route from `start`, where it begins at rest; it ends at rest at the last waypoint.
    ///
    /// A corner is rounded with the route's radius, or a smaller one where a leg is too short for it. Where hardly any radius is
    /// left (a turn right back, a radius of zero asked for) the leader stops in the corner. Waypoints nearer than a centimetre to
    /// the one before are left out.
    ///
    /// # Errors
    /// [`RouteError`] for a route without waypoints or length, or numbers that are not usable.
    pub fn new(start: PositionNed, route: &Route, acceleration_m_s2: f64) -> Result<Self, RouteError> {
        Self::within(start, route, &PathLimits::level(acceleration_m_s2))
    }

    /// The same with limits to climb and descent.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn within(start: PositionNed, route: &Route, limits: &PathLimits) -> Result<Self, RouteError> {
        Self::from_motion(start, &VelocityNed::default(), route, limits)
    }

    /// The same for a leader that already moves at the start: it goes on as fast as it is, and turns towards the first waypoint in an
    /// arc as round as the route's corners. Where that cannot be (a turn right back, a waypoint too near, a speed above the route's) the
    /// route begins slower than the leader is; whoever flies it lets the difference fade out.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_motion(
        start: PositionNed,
        velocity: &VelocityNed,
        route: &Route,
        limits: &PathLimits,
    ) -> Result<Self, RouteError> {
        limits.check(route.speed_m_s)?;
        let (lead_in, entry_m_s) = lead_in(start, velocity, route, limits);
        let path = match lead_in {
            Some(corner) => {
                let waypoints = std::iter::once(&corner).chain(&route.waypoints).copied().collect();
                Path::new(
                    start,
                    &Route {
                        waypoints,
                        ..route.clone()
                    },
                )
                .map_err(RouteError::without_lead_in)?
            }
            None => Path::new(start, route)?,
        };
        let speeds = boundary_speeds(&path.pieces, route.speed_m_s, entry_m_s, limits);
        let mut stretches = Vec::with_capacity(path.pieces.len() * 2);
        let mut start_s = 0.0;
        for (piece, (shape, ends)) in path.pieces.iter().zip(speeds.windows(2)).enumerate() {
            let (entry, exit) = (
                ends.first().copied().unwrap_or(0.0),
                ends.last().copied().unwrap_or(0.0),
            );
            let cap = piece_cap(shape, route.speed_m_s, limits);
            let constant = Phase {
                duration_s: shape.length_m() / entry,
                at_m: 0.0,
                speed_m_s: entry,
                acceleration_m_s2: 0.0,
            };
            let phases = match shape {
                Piece::Straight { length_m, .. } => {
                    ramps(*length_m, entry, exit, cap, limits.acceleration_m_s2).to_vec()
                }
                Piece::Arc { .. } => vec![constant],
            };
            for phase in phases.into_iter().filter(|phase| phase.duration_s > 0.0) {
                stretches.push(Stretch { start_s, piece, phase });
                start_s += phase.duration_s;
            }
        }
        Ok(Self {
            path,
            stretches,
            duration_s: start_s,
        })
    }

    /// How long it takes in seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Length along the rounded path in metres.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.path.pieces.iter().map(Piece::length_m).sum()
    }

    /// The place where it ends.
    #[must_use]
    pub fn end(&self) -> PositionNed {
        self.path.end
    }

    /// Where the leader should be `t_s` seconds after the start. Before it (and for a time that is not a number): at rest at the
    /// start; after the end: at rest there.
    #[must_use]
    pub fn sample(&self, t_s: f64) -> RouteSample {
        let t_s = t_s.max(0.0);
        let at = self
            .stretches
            .partition_point(|stretch| stretch.start_s <= t_s)
            .saturating_sub(1);
        let last_course = self.path.courses_rad.last().copied().unwrap_or(0.0);
        let (Some(stretch), true) = (self.stretches.get(at), t_s < self.duration_s) else {
            return RouteSample {
                position: self.path.end,
                velocity: VelocityNed::default(),
                acceleration: AccelerationNed::default(),
                course_rad: last_course,
                course_rate_rad_s: 0.0,
                turning: false,
                finished: true,
            };
        };
        let (distance_m, speed) = stretch.phase.at(t_s - stretch.start_s);
        let Some(piece) = self.path.pieces.get(stretch.piece) else {
            return self.sample(f64::INFINITY);
        };
        let held_course = self.path.courses_rad.get(stretch.piece).copied().unwrap_or(last_course);
        let point = piece.at(distance_m);
        let (course_rad, course_per_m) = point.course(held_course);
        RouteSample {
            position: point.position.into(),
            velocity: (point.tangent * speed).into(),
            acceleration: (point.tangent * stretch.phase.acceleration_m_s2 + point.curvature * (speed * speed)).into(),
            course_rad,
            course_rate_rad_s: course_per_m * speed,
            turning: matches!(piece, Piece::Arc { .. }),
            finished: false,
        }
    }
}

/// The largest speed on a piece.
fn piece_cap(piece: &Piece, speed_m_s: f64, limits: &PathLimits) -> f64 {
    match piece {
        Piece::Straight { direction, .. } => limits.speed_along(direction, speed_m_s),
        Piece::Arc { radius_m, .. } => {
            let steepest = piece
                .steepest()
                .into_iter()
                .map(|tangent| limits.speed_along(&tangent, speed_m_s))
                .fold(speed_m_s, f64::min);
            steepest.min((limits.acceleration_m_s2 * radius_m).sqrt())
        }
    }
}

/// A leader slower than this starts at rest, in metres per second.
const AT_REST_M_S: f64 = 0.3;
/// A course nearer than this to the first leg needs no arc, in radians.
const SAME_COURSE_RAD: f64 = 0.05;
/// A sharper turn than this is made by stopping, in radians.
const SHARPEST_TURN_RAD: f64 = 2.6;

/// Where a leader that moves turns towards the first waypoint, if it has to turn, and the speed with which its route begins.
fn lead_in(
    start: PositionNed,
    velocity: &VelocityNed,
    route: &Route,
    limits: &PathLimits,
) -> (Option<PositionNed>, f64) {
    let (speed, a) = (velocity.norm(), limits.acceleration_m_s2);
    let first = route.waypoints.first().map(|w| w.vector() - start.vector());
    let (Some(towards), Some(ahead)) = (
        first.and_then(|way| way.try_normalize(1e-6)),
        velocity.vector().try_normalize(AT_REST_M_S),
    ) else {
        return (None, 0.0);
    };
    let radius_m = route.corner_radius_m;
    let turn_rad = ahead.cross(&towards).norm().atan2(ahead.dot(&towards));
    if !(speed.is_finite() && turn_rad.is_finite() && radius_m.is_finite()) {
        return (None, 0.0);
    }
    if turn_rad < SAME_COURSE_RAD {
        return (None, speed * turn_rad.cos());
    }
    if turn_rad > SHARPEST_TURN_RAD || radius_m <= 0.0 {
        let stop = start.moved(ahead * (speed * speed / (2.0 * a)));
        return (Some(stop), speed);
    }
    // Each leg gives half of itself to the corner at most, and before the arc it slows down to what the arc allows. The turn at the
    // corner is sharper than the one seen from here, since the waypoint is nearer there: twice the cut leaves room for that.
    let cut_m = radius_m * (0.5 * turn_rad).tan();
    let braking_m = (speed * speed - a * radius_m).max(0.0) / (2.0 * a);
    (Some(start.moved(ahead * (2.0 * cut_m + braking_m))), speed)
}

/// Speeds at the ends of all pieces (one more than pieces): as fast as it is at the begin, at rest at the end of the route and where
/// the path has a kink, one speed throughout a corner, and everywhere reachable with the acceleration from both sides.
fn boundary_speeds(pieces: &[Piece], speed_m_s: f64, entry_m_s: f64, limits: &PathLimits) -> Vec<f64> {
    let caps: Vec<f64> = pieces.iter().map(|piece| piece_cap(piece, speed_m_s, limits)).collect();
    let mut speeds = vec![0.0; pieces.len() + 1];
    if let (Some(entry), Some(cap)) = (speeds.first_mut(), caps.first()) {
        *entry = entry_m_s.min(*cap);
    }
    for (i, (pair, cap)) in pieces.windows(2).zip(caps.windows(2)).enumerate() {
        let kink = matches!(pair, [Piece::Straight { stops_at_end: true, .. }, _]);
        if let (Some(speed), false) = (speeds.get_mut(i + 1), kink) {
            *speed = cap.iter().copied().fold(speed_m_s, f64::min);
        }
    }
    let reach = |from: f64, piece: &Piece| match piece {
        Piece::Straight { length_m, .. } => (from * from + 2.0 * limits.acceleration_m_s2 * length_m).sqrt(),
        Piece::Arc { .. } => from,
    };
    for (i, piece) in pieces.iter().enumerate() {
        let entry = speeds.get(i).copied().unwrap_or(0.0);
        if let Some(exit) = speeds.get_mut(i + 1) {
            *exit = exit.min(reach(entry, piece));
        }
    }
    for (i, piece) in pieces.iter().enumerate().rev() {
        let exit = speeds.get(i + 1).copied().unwrap_or(0.0);
        if let Some(entry) = speeds.get_mut(i) {
            *entry = entry.min(reach(exit, piece));
        }
    }
    speeds
}

#[cfg(test)]
mod tests;
