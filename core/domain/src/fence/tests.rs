//! Zones: what is wrong with one is said, and the words in files stay the words in files.

use super::*;

fn zone(outline: ZoneOutline) -> FenceZone {
    FenceZone {
        name: "field".to_owned(),
        kind: ZoneKind::Inclusion,
        outline,
        floor_m: None,
        ceiling_m: None,
        altitude_reference: AltitudeReference::default(),
        action: BreachAction::default(),
    }
}

fn circle(radius_m: f64) -> FenceZone {
    zone(ZoneOutline::Circle {
        centre: MapPoint::new(47.4, 8.5),
        radius_m,
    })
}

#[test]
fn what_is_wrong_is_named() {
    assert_eq!(circle(10.0).check(), Ok(()));
    for radius_m in [0.0, -1.0, 2e5, f64::INFINITY] {
        assert_eq!(circle(radius_m).check(), Err(ZoneError::Radius { radius_m }));
    }
    assert!(matches!(circle(f64::NAN).check(), Err(ZoneError::Radius { .. })));
    let nameless = FenceZone {
        name: " ".to_owned(),
        ..circle(10.0)
    };
    assert_eq!(nameless.check(), Err(ZoneError::NoName));
    for (floor_m, ceiling_m) in [
        (Some(10.0), Some(10.0)),
        (Some(f64::NAN), None),
        (None, Some(f64::INFINITY)),
    ] {
        let band = FenceZone {
            floor_m,
            ceiling_m,
            ..circle(10.0)
        };
        assert!(matches!(band.check(), Err(ZoneError::FloorAboveCeiling { .. })));
    }
    let corners = vec![MapPoint::new(0.0, 0.0), MapPoint::new(0.0, 181.0)];
    let error = zone(ZoneOutline::Polygon { corners }).check();
    assert!(matches!(error, Err(ZoneError::NotAPlace { index: 1, .. })), "{error:?}");
    let corners_m = vec![[0.0, f64::NAN]];
    let error = zone(ZoneOutline::LocalPolygon { corners_m }).check();
    assert!(matches!(error, Err(ZoneError::NotAPlace { index: 0, .. })), "{error:?}");
}

#[test]
fn only_what_stands_on_the_map_needs_an_origin() {
    let local = zone(ZoneOutline::LocalCircle {
        centre_m: [0.0, 0.0],
        radius_m: 5.0,
    });
    let plan = |zone: FenceZone| FencePlan {
        zones: vec![zone],
        breach_return: None,
    };
    assert!(!plan(local.clone()).needs_origin());
    assert!(plan(circle(5.0)).needs_origin());
    assert!(
        plan(FenceZone {
            altitude_reference: AltitudeReference::Amsl,
            ..local
        })
        .needs_origin()
    );
}

#[test]
fn actions_are_ordered_by_how_much_they_do() {
    use BreachAction::{Hold, Land, Return, Warn};
    assert!(Warn < Hold && Hold < Return && Return < Land);
}
