//! What is asked of the swarm: one formation after the other, of any shape, about any anchor, and routes for their leaders.

use super::{Ask, FlightStep, When, id_of};
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use skein_domain::{
    FormationAnchor, FormationControl, FormationRequest, HeadingRequest, OffsetFrd, PositionNed, Route, Shape,
};

/// The name of what formations may follow.
pub(crate) const REFERENCE: &str = "drawn";
/// A formation of more does not keep itself: what its members would have to hear is more than radios carry.
const KEEPS_ITSELF: usize = 40;

/// The steps of a flight.
pub(super) fn draw(count: usize, height_m: f64, rng: &mut ChaCha8Rng) -> Vec<FlightStep> {
    // A flight of many vehicles is long, and costs a multiple of a short one's time.
    let changes = match count {
        0..=12 => rng.random_range(2..=4),
        13..=60 => rng.random_range(2..=3),
        _ => 2,
    };
    let mut steps: Vec<FlightStep> = Vec::new();
    for number in 0..changes {
        let when = if number == 0 {
            When::Settled(1.0)
        } else if rng.random_bool(0.3) {
            When::Midway(rng.random_range(0.1..0.95))
        } else {
            When::Settled(rng.random_range(0.5..6.0))
        };
        let request = request(count, height_m, rng);
        let led = request.anchor == FormationAnchor::Leader;
        steps.push(FlightStep {
            when,
            ask: Ask::Form(request),
        });
        if led && rng.random_bool(0.5) {
            steps.push(FlightStep {
                when: When::Settled(rng.random_range(-1.0..2.0)),
                ask: route(rng),
            });
        }
    }
    steps
}

fn request(count: usize, height_m: f64, rng: &mut ChaCha8Rng) -> FormationRequest {
    let shape = Shape::ALL[rng.random_range(0..Shape::ALL.len())];
    // Places nearer to each other than the filter keeps vehicles apart at rest (radius, two estimates, and the downwash above each
    // other) would be kept by nobody; whoever asks for less than the radius itself is refused.
    let spacing_m = if rng.random_bool(0.04) {
        rng.random_range(1.0..2.0)
    } else if count > 40 {
        rng.random_range(4.5..7.0)
    } else {
        rng.random_range(4.5..11.0)
    };
    let level = !rng.random_bool(0.3);
    let heading = match rng.random_range(0..3) {
        0 => HeadingRequest::Auto,
        1 => HeadingRequest::Course,
        _ => HeadingRequest::Fixed {
            heading_deg: rng.random_range(0.0..360.0),
        },
    };
    let control = match rng.random_range(0..12) {
        0 if count <= KEEPS_ITSELF => FormationControl::Distances,
        1 if count <= KEEPS_ITSELF => FormationControl::Bearings,
        _ => FormationControl::Slots,
    };
    FormationRequest {
        control,
        heading,
        // As many steps as there are vehicles must not lead into the ground or the clouds.
        altitude_step_m: if level {
            0.0
        } else {
            rng.random_range(0.0..(40.0 / count as f64).min(1.5))
        },
        rotation_deg: if rng.random_bool(0.5) {
            0.0
        } else {
            rng.random_range(-180.0..180.0)
        },
        scale: if rng.random_bool(0.7) {
            1.0
        } else {
            rng.random_range(1.0..1.4)
        },
        arc_deg: rng.random_bool(0.5).then(|| rng.random_range(60.0..300.0)),
        pitch_m: rng.random_bool(0.5).then(|| rng.random_range(6.0..12.0)),
        offsets: (shape == Shape::Free).then(|| offsets(count, spacing_m, rng)),
        leader: rng.random_bool(0.2).then(|| id_of(rng.random_range(0..count))),
        anchor: anchor(height_m, rng),
        ..FormationRequest::new(shape, spacing_m)
    }
}

/// Anywhere within a box, none nearer to another than the spacing; where no more fit in, further and further away.
fn offsets(count: usize, spacing_m: f64, rng: &mut ChaCha8Rng) -> Vec<OffsetFrd> {
    let mut places = vec![Vector3::zeros()];
    let mut half_m = spacing_m * (count as f64).cbrt();
    while places.len() < count {
        half_m *= 1.02;
        let mut draw = || rng.random_range(-half_m..half_m);
        let place = Vector3::new(draw(), draw(), 0.3 * draw());
        if places.iter().all(|other| (other - place).norm() >= spacing_m) {
            places.push(place);
        }
    }
    places.into_iter().map(OffsetFrd::from).collect()
}

fn anchor(height_m: f64, rng: &mut ChaCha8Rng) -> FormationAnchor {
    let mut near = |reach_m: f64| {
        PositionNed::new(
            rng.random_range(-reach_m..reach_m),
            rng.random_range(-reach_m..reach_m),
            -height_m - rng.random_range(0.0..6.0),
        )
    };
    let (place, second, third) = (near(30.0), near(60.0), near(60.0));
    match rng.random_range(0..22) {
        20 | 21 => FormationAnchor::Reference { name: REFERENCE.into() },
        0..=11 => FormationAnchor::Leader,
        12..=15 => FormationAnchor::Place {
            position: place,
            heading_deg: rng.random_bool(0.5).then(|| rng.random_range(0.0..360.0)),
        },
        _ => FormationAnchor::Path {
            route: Route {
                waypoints: vec![place, second, third],
                speed_m_s: rng.random_range(1.0..8.0),
                corner_radius_m: rng.random_range(2.0..15.0),
            },
        },
    }
}

fn route(rng: &mut ChaCha8Rng) -> Ask {
    let mut course: f64 = rng.random_range(0.0..std::f64::consts::TAU);
    let legs = (0..rng.random_range(1..4))
        .map(|_| {
            course += rng.random_range(-2.2..2.2);
            let length_m = rng.random_range(20.0..60.0);
            Vector3::new(
                course.cos() * length_m,
                course.sin() * length_m,
                rng.random_range(-3.0..1.0),
            )
        })
        .collect();
    Ask::Route {
        legs,
        speed_m_s: rng.random_range(2.0..12.0),
        corner_radius_m: rng.random_range(2.0..15.0),
    }
}
