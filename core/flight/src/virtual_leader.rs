//! A leader that is no vehicle: it flies a route on the common clock, so that every node that knows the route knows where it is.
//!
//! Must never do: depend on when it was asked before. Its place, its heading and how fast that turns are functions of the time alone.

use crate::heading::HeadingFollower;
use crate::route::{PathLimits, RouteError, RouteTrajectory};
use skein_domain::frames::wrap_angle_rad;
use skein_domain::{AnchorReference, FormationHeading, NodeTime, PositionNed, Route};
use thiserror::Error;

/// The heading is worked out in steps of this length in seconds, beginning with the start.
const STEP_S: f64 = 0.05;
/// A flight of more steps (about a day) is refused.
const MOST_STEPS: usize = 2_000_000;
/// After the end of the route the heading may go on turning towards the last course for this long in seconds.
const MOST_SETTLING_S: f64 = 600.0;

/// Why there cannot be a virtual leader.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum VirtualLeaderError {
    /// The route cannot be flown.
    #[error(transparent)]
    Route(#[from] RouteError),
    /// The route takes too long.
    #[error("the route takes {duration_s:.0} s, more than the {most_s:.0} s that a flight can take")]
    TooLong {
        /// How long it takes, in seconds.
        duration_s: f64,
        /// The longest, in seconds.
        most_s: f64,
    },
}

/// From `at_step` on the heading turns at this rate, until the next of these; for one step the rate is taken to be changing.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    at_step: usize,
    heading_rad: f64,
    rate_rad_s: f64,
    acceleration_rad_s2: f64,
}

/// A virtual leader on its route.
#[derive(Debug, Clone, PartialEq)]
pub struct VirtualLeader {
    route: RouteTrajectory,
    start: NodeTime,
    turns: Vec<Turn>,
}

impl VirtualLeader {
    /// One that stands at `from` with `heading_rad` until `start`, flies the route, and stands at its end. Its heading is that of
    /// [`HeadingFollower`] in the given mode.
    ///
    /// # Errors
    /// [`VirtualLeaderError`] for a route that cannot be flown or is too long.
    pub fn new(
        from: PositionNed,
        route: &Route,
        limits: &PathLimits,
        heading: FormationHeading,
        heading_rad: f64,
        start: NodeTime,
    ) -> Result<Self, VirtualLeaderError> {
        let route = RouteTrajectory::within(from, route, limits)?;
        let most_s = MOST_STEPS as f64 * STEP_S - MOST_SETTLING_S;
        let duration_s = route.duration_s();
        if duration_s.is_nan() || duration_s > most_s {
            return Err(VirtualLeaderError::TooLong { duration_s, most_s });
        }
        let turns = turns(&route, HeadingFollower::resume(heading, heading_rad, 0.0));
        Ok(Self { route, start, turns })
    }

    /// When it reaches the end of its route.
    #[must_use]
    pub fn end(&self) -> NodeTime {
        self.start.plus_seconds(self.route.duration_s())
    }

    /// The route in space and time.
    #[must_use]
    pub fn route(&self) -> &RouteTrajectory {
        &self.route
    }

    /// Where it is at `now`, and how it moves.
    #[must_use]
    pub fn anchor(&self, now: NodeTime) -> AnchorReference {
        let t_s = now.seconds_since(self.start);
        let (heading_rad, heading_rate_rad_s, heading_acceleration_rad_s2) = self.heading(t_s);
        let mut anchor = AnchorReference {
            heading_rad,
            heading_rate_rad_s,
            heading_acceleration_rad_s2,
            time: now,
            ..AnchorReference::default()
        };
        let here = self.route.sample(t_s);
        anchor.position = here.position;
        if t_s > 0.0 {
            (anchor.velocity, anchor.acceleration) = (here.velocity, here.acceleration);
        }
        anchor
    }

    /// Heading, its rate, and how that changes.
    fn heading(&self, t_s: f64) -> (f64, f64, f64) {
        let after = |turn: &Turn| turn.at_step as f64 * STEP_S <= t_s;
        let next = self.turns.partition_point(after);
        let turn = match next.checked_sub(1) {
            Some(last) => self.turns.get(last),
            // Before the start it stands.
            None => {
                let first = self.turns.first().map_or(0.0, |turn| turn.heading_rad);
                return (first, 0.0, 0.0);
            }
        };
        turn.map_or((0.0, 0.0, 0.0), |turn| {
            let since_s = t_s - turn.at_step as f64 * STEP_S;
            (
                wrap_angle_rad(turn.heading_rad + turn.rate_rad_s * since_s),
                turn.rate_rad_s,
                if since_s < STEP_S {
                    turn.acceleration_rad_s2
                } else {
                    0.0
                },
            )
        })
    }
}

/// The heading over the whole flight: a list of rates, each from one step on.
fn turns(route: &RouteTrajectory, mut follower: HeadingFollower) -> Vec<Turn> {
    let mut turns: Vec<Turn> = Vec::new();
    let (ends_s, mut step) = (route.duration_s(), 0_usize);
    loop {
        let t_s = step as f64 * STEP_S;
        let heading_rad = follower.heading_rad();
        let over = t_s >= ends_s;
        let (_, rate_rad_s) = follower.step(route.sample(t_s).course_rad, STEP_S);
        let settled = over && rate_rad_s.abs() < SETTLED_RAD_S;
        let rate_rad_s = if settled || t_s >= ends_s + MOST_SETTLING_S {
            0.0
        } else {
            rate_rad_s
        };
        if turns.last().is_none_or(|turn| turn.rate_rad_s != rate_rad_s) {
            turns.push(Turn {
                at_step: step,
                heading_rad,
                rate_rad_s,
                acceleration_rad_s2: follower.acceleration_rad_s2(),
            });
        }
        if over && rate_rad_s == 0.0 {
            return turns;
        }
        step += 1;
    }
}

/// Slower than this a turn after the end of the route is over, in radians per second.
const SETTLED_RAD_S: f64 = 1e-4;

#[cfg(test)]
mod tests;
