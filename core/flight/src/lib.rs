//! Formations, slot assignment, transitions between formations, routes, and what a follower should do now: pure geometry and
//! kinematics.
//!
//! Must never do: I/O, read a clock, spawn, draw random numbers. Time comes in as an argument, so that the same input gives the
//! same output. No function panics or loops on numbers that are not finite: constructors refuse them with a typed error, and what
//! samples hands them on, so that the safety gate refuses them.
#![forbid(unsafe_code)]

pub mod assignment;
pub mod consensus;
pub mod drag;
pub mod follow;
pub mod formation;
pub mod goto;
pub mod heading;
pub mod limits;
pub mod reference;
pub mod return_plan;
pub mod route;
mod speed;
mod time_law;
pub mod trajectory;
pub mod transition;
pub mod virtual_leader;
pub mod way_around;

pub use drag::DragEstimator;
pub use formation::FormationError;
pub use goto::GoTo;
pub use heading::HeadingFollower;
pub use reference::{ReferenceError, ReferenceLimits, ReferenceTracker};
pub use route::{PathLimits, RouteError, RouteSample, RouteTrajectory};
pub use transition::{Change, MotionLimits, SlotSample, TransitionPlan};
pub use virtual_leader::{VirtualLeader, VirtualLeaderError};
pub use way_around::{NoWay, WayAround, way_around};
