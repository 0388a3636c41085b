//! Items of a route, and routes that cannot be meant. Uploads as a whole are tested against the simulated autopilot.

use super::*;
use skein_domain::Geodetic;

fn point(speed_m_s: Option<f64>) -> RoutePoint {
    RoutePoint {
        place: Geodetic {
            latitude_deg: 47.4,
            longitude_deg: 8.5,
            altitude_amsl_m: 500.0,
        },
        speed_m_s,
    }
}

#[test]
fn a_speed_stands_before_the_point_it_is_for_and_only_when_it_changes() {
    let items = items(&[
        point(None),
        point(Some(4.0)),
        point(Some(4.0)),
        point(None),
        point(Some(6.0)),
    ]);
    let words: Vec<String> = items
        .iter()
        .map(|item| match item {
            Item::Speed { speed_m_s } => format!("{speed_m_s} m/s"),
            Item::Point { index, .. } => index.to_string(),
        })
        .collect();
    assert_eq!(words, ["0", "4 m/s", "1", "2", "3", "6 m/s", "4"]);
}

#[test]
fn a_route_that_cannot_be_meant_is_refused_with_its_point() {
    assert_eq!(wrong(&[]), None);
    assert_eq!(wrong(&[point(None), point(Some(5.0))]), None);
    for speed in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e3] {
        let Some(Refusal::InvalidValue { detail }) = wrong(&[point(None), point(Some(speed))]) else {
            panic!("{speed} m/s")
        };
        assert!(detail.starts_with("point 1"), "{detail}");
    }
    let mut nowhere = point(None);
    nowhere.place.latitude_deg = f64::NAN;
    assert!(wrong(&[nowhere]).is_some());
    assert!(wrong(&vec![point(None); POINTS_MAX + 1]).is_some());
}
