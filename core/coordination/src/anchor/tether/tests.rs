//! References that leave a fence and come back: nobody's place goes outside, nothing jumps, and in the end it is followed again.

use super::*;
use proptest::prelude::*;
use skein_domain::{BreachAction, NodeTime, ZoneKind};
use skein_safety::{Fence, Zone};

const PERIOD_S: f64 = 0.02;

/// A square of so many metres from the origin to each side.
fn square(half_m: f64) -> Fences {
    let corners = vec![
        [-half_m, -half_m],
        [half_m, -half_m],
        [half_m, half_m],
        [-half_m, half_m],
    ];
    Fences::new(vec![Zone {
        name: "square".into(),
        kind: ZoneKind::Inclusion,
        action: BreachAction::Hold,
        volume: Fence::new(corners, 0.0, 100.0).unwrap(),
    }])
}

/// A cross, ten metres to each side.
fn places() -> Vec<OffsetFrd> {
    [(10.0, 0.0), (-10.0, 0.0), (0.0, 10.0), (0.0, -10.0)]
        .iter()
        .map(|(forward_m, right_m)| OffsetFrd::new(*forward_m, *right_m, 0.0))
        .collect()
}

/// Leads along a way given by time; checks every step of it.
fn fly(
    tether: &mut Tether,
    fences: &Fences,
    seconds: f64,
    way: impl Fn(f64) -> (Vector3<f64>, Vector3<f64>),
) -> AnchorReference {
    let places = places();
    let room = Room {
        fences,
        places: &places,
    };
    let mut last: Option<AnchorReference> = None;
    for step in 0..(seconds / PERIOD_S) as u32 {
        let (position, velocity) = way(f64::from(step) * PERIOD_S);
        let wanted = AnchorReference {
            position: position.into(),
            velocity: velocity.into(),
            time: NodeTime::from_seconds(f64::from(step) * PERIOD_S),
            ..AnchorReference::default()
        };
        let anchor = tether.lead(wanted, 0.3, &room, PERIOD_S);
        assert_eq!(room.outside(&anchor.position, 0.3), 0, "at step {step}: {anchor:?}");
        if let Some(last) = last {
            let expected = last.position.after(&anchor.velocity, PERIOD_S);
            assert!(anchor.position.distance_m(&expected) < 0.05, "{last:?} {anchor:?}");
        }
        last = Some(anchor);
    }
    last.unwrap()
}

#[test]
fn it_stops_before_its_places_are_outside_and_goes_on_when_the_reference_is_back() {
    let fences = square(50.0);
    let mut tether = Tether::default();
    let north = |north_m: f64, speed_m_s: f64| (Vector3::new(north_m, 0.0, -20.0), Vector3::new(speed_m_s, 0.0, 0.0));
    let stands = fly(&mut tether, &fences, 20.0, |t| north(5.0 * t, 5.0));
    assert!(tether.is_held());
    assert!(stands.velocity.vector().norm() < 1e-9, "{stands:?}");
    // Ten metres of formation, the way it takes to brake from 5 m/s, begun half a second early.
    assert!(
        stands.position.north_m > 33.0 && stands.position.north_m < 40.5,
        "{stands:?}"
    );
    let back = fly(&mut tether, &fences, 20.0, |t| north(100.0 - 5.0 * t, -5.0));
    assert!(!tether.is_held());
    assert!(back.position.north_m < 1.0, "{back:?}");
    // On to the other side.
    let stands = fly(&mut tether, &fences, 30.0, |t| north(-5.0 * t, -5.0));
    assert!(tether.is_held());
    assert!(
        stands.position.north_m < -33.0 && stands.position.north_m > -40.5,
        "{stands:?}"
    );
}

#[test]
fn without_a_fence_it_is_the_reference() {
    let mut tether = Tether::default();
    let far = fly(&mut tether, &Fences::default(), 60.0, |t| {
        (Vector3::new(9.0 * t, 0.0, -20.0), Vector3::new(9.0, 0.0, 0.0))
    });
    assert!((far.position.north_m - 9.0 * 59.98).abs() < 1e-9);
    assert!(!tether.is_held());
}

#[test]
fn who_is_outside_already_holds_nobody_up() {
    let (fences, places) = (square(5.0), places());
    let room = Room {
        fences: &fences,
        places: &places,
    };
    let mut tether = Tether::default();
    for step in 0..500 {
        let wanted = AnchorReference {
            position: PositionNed::new(0.02 * f64::from(step), 0.0, -20.0),
            velocity: VelocityNed::new(1.0, 0.0, 0.0),
            ..AnchorReference::default()
        };
        assert_eq!(tether.lead(wanted, 0.0, &room, PERIOD_S), wanted);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn wherever_the_reference_goes_no_place_goes_outside(
        half_m in 15.0..80.0, radius_m in 0.0..150.0, speed_m_s in 0.5..10.0, phase in 0.0..std::f64::consts::TAU,
    ) {
        // Round a circle about a place beside the fence, from inside.
        let fences = square(half_m);
        let rate: f64 = speed_m_s / f64::max(radius_m, 1.0);
        let on_circle = move |t: f64| {
            let at: f64 = phase + rate * t;
            let centre = Vector3::new(-radius_m * phase.cos(), -radius_m * phase.sin(), -20.0);
            let (sin, cos) = at.sin_cos();
            (
                centre + Vector3::new(radius_m * cos, radius_m * sin, 0.0),
                Vector3::new(-sin, cos, 0.0) * (radius_m * rate),
            )
        };
        let mut tether = Tether::default();
        let round_s = (std::f64::consts::TAU / rate).min(300.0);
        let last = fly(&mut tether, &fences, round_s, on_circle);
        // Back where it began, inside: a while later it is together with a reference that stands there.
        let (stands, _) = on_circle(round_s);
        if stands.xy().amax() < half_m - 25.0 {
            let end = fly(&mut tether, &fences, 120.0, |_| (stands, Vector3::zeros()));
            prop_assert!(end.position.distance_m(&stands.into()) < 0.3, "{last:?} {end:?}");
        }
    }
}
