//! The demonstration's flight plan: how long the legs can be so that the whole flight fits into the time asked for.

use skein_domain::NodeTime;
use skein_domain::{FormationRequest, OffsetFrd, PositionNed, Route, Shape};
use skein_flight::formation::slots;
use skein_flight::transition::{self, MotionLimits};

/// Distance between neighbours in every formation and on the ground, in metres.
pub const SPACING_M: f64 = 5.0;
/// Height of the flight above the field in metres.
pub const HEIGHT_M: f64 = 6.0;
/// Speed of the leader on its route in metres per second.
pub const SPEED_M_S: f64 = 5.0;
/// Radius of the route's corners in metres.
pub const CORNER_RADIUS_M: f64 = 12.0;
/// Speed limit within the formation while it changes, in metres per second.
pub const TRANSITION_SPEED_M_S: f64 = 8.0;
/// Rest after each change, in seconds: the vehicles settle, and the referee looks whether each is in its slot.
pub const SETTLE_S: f64 = 1.5;

/// Shortest leg that shows anything of straight flight, in metres.
const SHORTEST_LEG_M: f64 = 36.0;
/// Longest leg: beyond it nothing new is seen.
const LONGEST_LEG_M: f64 = 80.0;
/// Start of the estimator, arming, climb, entering OFFBOARD, in seconds.
const UP_S: f64 = 16.0;
/// Descent, touch-down, disarming, in seconds.
const DOWN_S: f64 = 16.0;
/// What a route costs beyond its length: speeding up, slowing down, corners, settling, in seconds.
const ROUTE_OVERHEAD_S: f64 = 4.5;

/// The plan.
pub struct Layout {
    /// How many vehicles.
    pub vehicles: usize,
    /// Length of the first leg in metres.
    pub leg_m: f64,
    /// Time between two take-offs in seconds.
    pub take_off_stagger_s: f64,
    /// About how long the flight takes in seconds.
    pub expected_s: f64,
    /// What was asked for, in seconds.
    pub asked_s: Option<f64>,
}

impl Layout {
    /// Fits the flight of so many vehicles into the time asked for, as far as it can be.
    pub fn plan(vehicles: usize, asked_s: Option<f64>) -> Self {
        let take_off_stagger_s = (8.0 / vehicles as f64).min(0.5);
        let changes_s = changes_s(vehicles);
        let fixed_s = UP_S + take_off_stagger_s * vehicles as f64 + changes_s + DOWN_S + 2.0 * ROUTE_OVERHEAD_S;
        let leg_m = match asked_s {
            Some(asked_s) => (asked_s - fixed_s) * SPEED_M_S / LEGS,
            None => 60.0,
        }
        .clamp(SHORTEST_LEG_M, LONGEST_LEG_M);
        Self {
            vehicles,
            leg_m,
            take_off_stagger_s,
            expected_s: fixed_s + leg_m * LEGS / SPEED_M_S,
            asked_s,
        }
    }

    /// One paragraph for the person who watches.
    pub fn describe(&self) -> String {
        let more = match self.asked_s {
            Some(asked_s) if self.expected_s > asked_s + 1.0 => {
                format!(
                    " {} vehicles need more than the {asked_s:.0} s asked for.",
                    self.vehicles
                )
            }
            _ => String::new(),
        };
        format!(
            "{} vehicles fly for about {:.0} s.{more}",
            self.vehicles, self.expected_s
        )
    }

    /// The way out: north, east, half-way back south; two right-angled turns.
    pub fn way_out(&self, start: PositionNed) -> Route {
        let leg = self.leg_m;
        let at = |north: f64, east: f64| start.moved(nalgebra::Vector3::new(north, east, 0.0));
        self.route(vec![at(leg, 0.0), at(leg, leg), at(leg * 0.4, leg)])
    }

    /// The way back to where the leader took off, west and then south, so that the formation comes home over the field.
    pub fn way_back(&self, from: PositionNed, home: PositionNed) -> Route {
        let corner = PositionNed::new(from.north_m, home.east_m, from.down_m);
        self.route(vec![corner, PositionNed::new(home.north_m, home.east_m, from.down_m)])
    }

    fn route(&self, waypoints: Vec<PositionNed>) -> Route {
        Route {
            waypoints,
            speed_m_s: SPEED_M_S,
            corner_radius_m: CORNER_RADIUS_M,
        }
    }
}

/// Length of both routes in legs.
const LEGS: f64 = 2.6 + 1.4;

/// Time for the changes of formation in seconds, from the same planner that plans them in flight.
fn changes_s(vehicles: usize) -> f64 {
    let limits = MotionLimits {
        speed_m_s: TRANSITION_SPEED_M_S,
        acceleration_m_s2: 3.0,
        climb_m_s: 2.5,
        min_distance_m: 2.8,
    };
    let shapes = [Shape::Grid, Shape::Wedge, Shape::Line, Shape::Circle, Shape::Grid];
    let places = shapes.map(|shape| slots(&FormationRequest::new(shape, SPACING_M), vehicles).unwrap_or_default());
    let change_s = |from: &[OffsetFrd], to: &[OffsetFrd]| {
        transition::plan(from, to, &limits, NodeTime(0)).map_or(10.0, |plan| plan.duration_s) + SETTLE_S
    };
    places
        .windows(2)
        .map(|pair| pair.first().zip(pair.last()).map_or(0.0, |(a, b)| change_s(a, b)))
        .sum()
}
