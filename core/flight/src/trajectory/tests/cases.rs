//! Random journeys.

use crate::trajectory::{Journey, MotionState};
use proptest::prelude::*;
use skein_domain::{AccelerationNed, FlightLimits, PositionNed, VelocityNed};
use std::ops::Range;

pub fn place(north_m: f64, east_m: f64, down_m: f64) -> PositionNed {
    PositionNed::new(north_m, east_m, down_m)
}

pub fn limits(max_speed_m_s: f64, max_acceleration_m_s2: f64) -> FlightLimits {
    FlightLimits {
        max_speed_m_s,
        max_climb_m_s: 3.0,
        max_descent_m_s: 1.5,
        max_acceleration_m_s2,
        min_turn_radius_m: 0.0,
        endurance_s: None,
        keeps_view: false,
    }
}

fn any_place() -> impl Strategy<Value = PositionNed> {
    // Near ones too, and the very same.
    let near = (-3.0..3.0, -3.0..3.0, -1.0..1.0);
    let far = (-300.0..300.0, -300.0..300.0, -60.0..0.0);
    prop_oneof![
        3 => far.prop_map(|(n, e, d)| place(n, e, d)),
        1 => near.prop_map(|(n, e, d)| place(n, e, d)),
        1 => Just(place(5.0, 5.0, -5.0)),
    ]
}

fn any_limits() -> impl Strategy<Value = FlightLimits> {
    (0.5..20.0, 0.3..6.0, 0.3..4.0, 0.3..3.0).prop_map(|(speed, acceleration, climb, descent)| FlightLimits {
        max_climb_m_s: climb,
        max_descent_m_s: descent,
        ..limits(speed, acceleration)
    })
}

/// From rest.
pub fn journeys(vehicles: Range<usize>, waypoints: Range<usize>) -> impl Strategy<Value = Vec<Journey>> {
    let journey = (any_place(), prop::collection::vec(any_place(), waypoints), any_limits());
    let journey = journey.prop_map(|(start, waypoints, limits)| Journey {
        start: MotionState::at_rest(start),
        waypoints,
        limits,
    });
    prop::collection::vec(journey, vehicles)
}

/// From a motion within the limits.
pub fn moving_start() -> impl Strategy<Value = Journey> {
    let motion = (-1.0..1.0, -1.0..1.0, -1.0..1.0, -0.57..0.57, -0.57..0.57, -0.57..0.57);
    (
        motion,
        any_place(),
        prop::collection::vec(any_place(), 1..5),
        any_limits(),
    )
        .prop_map(|((n, e, d, an, ae, ad), start, waypoints, limits)| {
            let (speed, a) = (limits.max_speed_m_s * 0.7, limits.max_acceleration_m_s2);
            let vertical = if d < 0.0 {
                limits.max_climb_m_s
            } else {
                limits.max_descent_m_s
            };
            Journey {
                start: MotionState {
                    position: start,
                    velocity: VelocityNed::new(n * speed, e * speed, d * vertical),
                    acceleration: AccelerationNed::new(an * a, ae * a, ad * a),
                },
                waypoints,
                limits,
            }
        })
}
