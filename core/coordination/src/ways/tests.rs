//! Routes of whole formations: every place is looked at, with the heading the formation has there.

use super::*;
use skein_domain::{BreachAction, ZoneKind};
use skein_safety::{Fence, Zone};

/// A corridor along north, 200 m long and 30 m wide.
fn corridor() -> Fences {
    let corners = vec![[-20.0, -15.0], [180.0, -15.0], [180.0, 15.0], [-20.0, 15.0]];
    Fences::new(vec![Zone {
        name: "corridor".into(),
        kind: ZoneKind::Inclusion,
        action: BreachAction::Hold,
        volume: Fence::new(corners, 0.0, 60.0).unwrap(),
    }])
}

fn at(north_m: f64, east_m: f64) -> PositionNed {
    PositionNed::new(north_m, east_m, -20.0)
}

fn flown(route: &[PositionNed], heading: &FormationHeading, place: OffsetFrd) -> Result<(), Refusal> {
    let route = Route {
        waypoints: route.to_vec(),
        speed_m_s: 5.0,
        corner_radius_m: 5.0,
    };
    keeps_places_inside(&corridor(), &at(0.0, 0.0), &route, heading, &[(VehicleId(4), place)])
}

const COURSE: FormationHeading = FormationHeading::Course { max_rate_rad_s: 0.3 };

#[test]
fn a_place_beside_the_anchor_is_inside_as_long_as_there_is_room_beside() {
    let beside = |right_m| OffsetFrd::new(0.0, right_m, 0.0);
    assert_eq!(flown(&[at(150.0, 0.0)], &COURSE, beside(12.0)), Ok(()));
    let refused = flown(&[at(150.0, 0.0), at(150.0, 10.0)], &COURSE, beside(16.0)).unwrap_err();
    let Refusal::OutsideFence { detail } = refused else {
        panic!("{refused}")
    };
    assert!(
        detail.starts_with("the place of vehicle 4 on the way to waypoint 1: "),
        "{detail}"
    );
}

#[test]
fn which_way_the_formation_heads_decides() {
    let ahead = OffsetFrd::new(25.0, 0.0, 0.0);
    let north = FormationHeading::Fixed {
        heading_rad: 0.0,
        max_rate_rad_s: None,
    };
    let east = FormationHeading::Fixed {
        heading_rad: std::f64::consts::FRAC_PI_2,
        max_rate_rad_s: None,
    };
    assert_eq!(flown(&[at(150.0, 0.0)], &north, ahead), Ok(()));
    assert!(flown(&[at(150.0, 0.0)], &east, ahead).is_err());
    assert_eq!(flown(&[at(150.0, 0.0)], &COURSE, ahead), Ok(()));
    // North, and then five metres east: the place ahead is swung out.
    assert!(flown(&[at(100.0, 0.0), at(100.0, 5.0)], &COURSE, ahead).is_err());
}

#[test]
fn what_is_swung_out_between_two_legs_is_seen() {
    // There and back: at both ends the place is beside the anchor's line, in the middle of the turn across the corridor.
    let behind = OffsetFrd::new(-20.0, 0.0, 0.0);
    let there_and_back = [at(100.0, 0.0), at(0.5, 0.0)];
    assert!(flown(&there_and_back, &COURSE, behind).is_err());
    assert_eq!(flown(&there_and_back[..1], &COURSE, behind), Ok(()));
}

#[test]
fn a_place_that_is_outside_now_may_come_in_on_the_first_leg() {
    let beside = OffsetFrd::new(0.0, 12.0, 0.0);
    let route = |waypoints: Vec<PositionNed>| Route {
        waypoints,
        speed_m_s: 5.0,
        corner_radius_m: 5.0,
    };
    let flown = |waypoints| {
        let places = [(VehicleId(4), beside)];
        keeps_places_inside(&corridor(), &at(0.0, 8.0), &route(waypoints), &COURSE, &places)
    };
    assert_eq!(flown(vec![at(60.0, -5.0), at(120.0, -5.0)]), Ok(()));
    assert!(flown(vec![at(60.0, 8.0)]).is_err());
    assert!(flown(vec![at(60.0, -5.0), at(120.0, 8.0)]).is_err());
}
