//! A way through space, built from a plan, and a moment on it.

use crate::blend::Motion;
use skein_flight::{GoTo, RouteTrajectory};

/// A plan's way, built once.
pub(crate) enum Track {
    Straight(GoTo),
    Route(RouteTrajectory),
    /// There is none to build, or it cannot be built.
    None,
}

/// Where a plan wants the vehicle at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    pub motion: Motion,
    /// Yaw and its rate, where the plan has its own.
    pub yaw: Option<(f64, f64)>,
    /// Course over ground, on a route.
    pub course_rad: Option<f64>,
    /// The end of the plan is reached.
    pub finished: bool,
}
