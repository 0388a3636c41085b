//! Six vehicles in a wedge on a route of three turns at 4 m/s, as a real PX4 flew it: how far they are from their slots, with the airframe of
//! PX4's own simulation and with a usual one.

use nalgebra::Vector3;
use skein_domain::{FormationRequest, Shape};
use skein_seeded::{Ask, Case, FlightStep, Outcome, When, fly};
use skein_sim::{Airframe, NoiseSettings, WindSettings};

/// Length of the route's legs in metres, and distance between neighbours.
const LEG_M: f64 = 41.0;
const SPACING_M: f64 = 6.0;

fn route_of_six(airframe: Airframe) -> Outcome {
    let form = Ask::Form(FormationRequest::new(Shape::Wedge, SPACING_M));
    let leg = |north: f64, east: f64| Vector3::new(north, east, 0.0) * LEG_M;
    let legs = vec![leg(1.0, 0.0), leg(0.0, 1.0), leg(-1.0, 0.0), leg(0.0, -1.0)];
    let route = || Ask::Route {
        legs: legs.clone(),
        speed_m_s: 4.0,
        corner_radius_m: 8.0,
    };
    let start = |i: usize| Vector3::new((i / 3) as f64, (i % 3) as f64, 0.0) * 8.0 - Vector3::z() * 10.0;
    let step = |ask: Ask| FlightStep {
        when: When::Settled(3.0),
        ask,
    };
    let case = Case {
        starts: (0..6).map(start).collect(),
        yaws_rad: vec![0.0; 6],
        joins: Vec::new(),
        leaves: Vec::new(),
        wind: WindSettings::CALM,
        noise: NoiseSettings::NONE,
        latencies_s: vec![0.02; 6],
        loss: 0.0,
        fence: None,
        closed: Vec::new(),
        abilities: Vec::new(),
        foreign: Vec::new(),
        steps: vec![step(form), step(route())],
        airframe,
        ..Case::draw(1)
    };
    fly(&case, false)
}

#[test]
fn the_slots_are_kept_where_the_air_is_thick() {
    for (airframe, p95_m) in [(Airframe::Sih, 0.55), (Airframe::Quadrotor, 0.3)] {
        let outcome = route_of_six(airframe);
        println!("{airframe:?}: {:.2?}, {:?}", outcome.on_route, outcome.filter);
        assert!(outcome.is_passed(), "{outcome}");
        assert!(outcome.on_route.p95_m < p95_m, "{outcome}");
    }
}
