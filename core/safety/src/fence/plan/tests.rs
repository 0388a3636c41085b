//! From the map into the frame: circles on the safe side, heights from the sea, and zones that cannot be placed.

use super::*;
use skein_domain::{BreachAction, Geodetic, PositionNed};

fn frame() -> SwarmFrame {
    SwarmFrame::new(Geodetic {
        latitude_deg: 47.397_742,
        longitude_deg: 8.545_594,
        altitude_amsl_m: 488.0,
    })
}

fn zone(kind: ZoneKind, outline: ZoneOutline) -> FenceZone {
    FenceZone {
        name: "zone".to_owned(),
        kind,
        outline,
        floor_m: None,
        ceiling_m: Some(600.0),
        altitude_reference: AltitudeReference::Amsl,
        action: BreachAction::Return,
    }
}

fn plan(zone: FenceZone) -> FencePlan {
    FencePlan {
        zones: vec![zone],
        breach_return: None,
    }
}

#[test]
fn circles_are_polygons_on_the_safe_side() {
    for radius_m in [0.5, 12.0, 100.0, 900.0, 40_000.0] {
        for kind in [ZoneKind::Inclusion, ZoneKind::Exclusion] {
            let outline = ZoneOutline::LocalCircle {
                centre_m: [3.0, -4.0],
                radius_m,
            };
            let fences = Fences::from_plan(&plan(zone(kind, outline)), Some(&frame())).unwrap();
            let off_m = CIRCLE_OFF_M.max(CIRCLE_OFF_SHARE * radius_m) * 1.01;
            for k in 0..500 {
                let (sin, cos) = (f64::from(k) / 500.0 * TAU).sin_cos();
                let at = |r: f64| PositionNed::new(3.0 + r * cos, -4.0 + r * sin, -10.0);
                let (without, within) = (at(radius_m + 1e-3), at((radius_m - 1e-3).max(0.0)));
                let (far, near) = (at(radius_m + off_m), at((radius_m - off_m).max(0.0)));
                match kind {
                    ZoneKind::Inclusion => {
                        assert!(
                            fences.contains(&without).is_err() && fences.contains(&near).is_ok(),
                            "{radius_m} m"
                        );
                    }
                    ZoneKind::Exclusion => {
                        assert!(
                            fences.contains(&within).is_err() && fences.contains(&far).is_ok(),
                            "{radius_m} m"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn heights_from_the_sea_are_brought_to_the_origin() {
    let frame = frame();
    let centre = MapPoint::new(47.398, 8.546);
    let outline = ZoneOutline::Circle {
        centre,
        radius_m: 200.0,
    };
    let fences = Fences::from_plan(&plan(zone(ZoneKind::Inclusion, outline)), Some(&frame)).unwrap();
    let [north_m, east_m] = centre.in_frame_m(&frame);
    let at = |height_m: f64| PositionNed::new(north_m, east_m, -height_m);
    assert!(
        fences.contains(&at(111.9)).is_ok() && fences.contains(&at(112.1)).is_err(),
        "600 m above the sea are 112 m"
    );
    assert!(fences.contains(&at(-400.0)).is_ok(), "no floor");
    assert_eq!(fences.breach(&at(120.0)).unwrap().action, BreachAction::Return);
}

#[test]
fn zones_that_cannot_be_placed_are_named() {
    let corners = vec![
        MapPoint::new(47.39, 8.54),
        MapPoint::new(47.40, 8.54),
        MapPoint::new(47.40, 8.55),
    ];
    let on_map = plan(zone(ZoneKind::Exclusion, ZoneOutline::Polygon { corners }));
    assert!(matches!(
        Fences::from_plan(&on_map, None),
        Err(FencePlanError::NoOrigin { index: 0, .. })
    ));
    assert!(Fences::from_plan(&on_map, Some(&frame())).is_ok());
    let exchanged = ZoneOutline::Circle {
        centre: MapPoint::new(8.5, 47.4),
        radius_m: 10.0,
    };
    let far = Fences::from_plan(&plan(zone(ZoneKind::Inclusion, exchanged)), Some(&frame()));
    assert!(matches!(far, Err(FencePlanError::TooFar { .. })), "{far:?}");
    let line = ZoneOutline::LocalPolygon {
        corners_m: vec![[0.0, 0.0], [1.0, 1.0]],
    };
    let error = Fences::from_plan(&plan(zone(ZoneKind::Inclusion, line)), Some(&frame())).unwrap_err();
    assert_eq!(
        error.to_string(),
        "zone 0 \"zone\": a fence needs at least 3 corners, 2 were given"
    );
    let round = ZoneOutline::LocalCircle {
        centre_m: [0.0, 0.0],
        radius_m: 5.0,
    };
    let many = FencePlan {
        zones: vec![zone(ZoneKind::Exclusion, round); 501],
        breach_return: None,
    };
    assert_eq!(
        Fences::from_plan(&many, Some(&frame())),
        Err(FencePlanError::TooManyZones { count: 501 })
    );
}
