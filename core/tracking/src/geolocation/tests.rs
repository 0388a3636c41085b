//! Tests of what becomes of findings: the bearing they mean, how sure it is, and what is left out.

use super::*;
use nalgebra::Vector3;
use skein_domain::PositionNed;
use skein_domain::payload::CameraPose;

const WIDTH_PX: u32 = 640;
const HEIGHT_PX: u32 = 480;

fn pose() -> CameraPose {
    CameraPose {
        position: PositionNed::new(5.0, -40.0, -30.0),
        roll_rad: 0.02,
        pitch_rad: -0.1,
        yaw_rad: 1.4,
        field_of_view_rad: 1.2,
    }
}

fn lens() -> Lens {
    Lens::new(pose(), WIDTH_PX, HEIGHT_PX).expect("is one")
}

fn finding(id: &str) -> Finding {
    let (x, y) = lens().pixel(Vector3::new(10.0, 20.0, -25.0)).expect("is in front");
    Finding {
        class: "drone".to_owned(),
        score: 0.8,
        center_x_px: x,
        center_y_px: y,
        width_px: 8.0,
        height_px: 4.0,
        id: id.to_owned(),
        ..Finding::default()
    }
}

fn state(findings: Vec<Finding>) -> DetectorState {
    DetectorState {
        camera: "camera".to_owned(),
        time: NodeTime::from_seconds(3.0),
        width_px: WIDTH_PX,
        height_px: HEIGHT_PX,
        pose: Some(pose()),
        findings,
    }
}

fn sightings(state: &DetectorState) -> Vec<Sighting> {
    let widths = skein_config::TrackingSettings::default().width_m;
    located(&Sensor("1/camera".to_owned()), state, 0.5, &widths)
}

#[test]
fn a_finding_is_a_bearing_to_where_the_thing_is() {
    let [sighting] = sightings(&state(vec![finding("7")])).try_into().expect("one");
    assert_eq!((sighting.name, sighting.sensor.0.as_str()), (Some(7), "1/camera"));
    let Observation::Bearing {
        origin,
        direction,
        error_rad,
        origin_error_m,
    } = sighting.observation
    else {
        panic!("no bearing");
    };
    let way = Vector3::new(10.0, 20.0, -25.0) - origin;
    assert!((way.normalize() - direction).norm() < 1e-9);
    assert_eq!(origin_error_m, 0.5);
    // A pixel at least, joined with half a degree.
    let expected_rad = (1.0 / lens().focal_px()).hypot(0.5_f64.to_radians());
    assert!((error_rad - expected_rad).abs() < 1e-12);
    assert_eq!(sighting.scores.best(), Some(("drone", 0.8)));
    let guess = sighting.guess.expect("a drone has a typical width");
    assert!((guess.range_m - 0.5 * lens().focal_px() / 8.0).abs() < 1e-9 && guess.range_factor == 2.0);
}

#[test]
fn how_sure_a_bearing_is_follows_from_the_detector_or_the_box() {
    let error_rad = |finding: Finding| match &sightings(&state(vec![finding]))[0].observation {
        Observation::Bearing { error_rad, .. } => *error_rad,
        Observation::Position { .. } => panic!("no bearing"),
    };
    let pointing_rad = 0.5_f64.to_radians();
    let said = Finding {
        error_px: 5.0,
        ..finding("")
    };
    assert!((error_rad(said) - (5.0 / lens().focal_px()).hypot(pointing_rad)).abs() < 1e-12);
    let large = Finding {
        width_px: 90.0,
        ..finding("")
    };
    assert!((error_rad(large) - (9.0 / lens().focal_px()).hypot(pointing_rad)).abs() < 1e-12);
}

#[test]
fn what_is_not_seen_or_cannot_be_is_no_sighting() {
    let coasted = Finding {
        coasted_s: 0.3,
        ..finding("1")
    };
    let unsound = Finding {
        score: 1.5,
        ..finding("2")
    };
    let nowhere = Finding {
        center_x_px: f64::NAN,
        ..finding("3")
    };
    let whole = state(vec![coasted, unsound, nowhere, finding("4")]);
    let names: Vec<_> = sightings(&whole).into_iter().map(|one| one.name).collect();
    assert_eq!(names, [Some(4)]);
    assert!(
        sightings(&DetectorState {
            pose: None,
            ..whole.clone()
        })
        .is_empty()
    );
    assert!(sightings(&DetectorState { width_px: 0, ..whole }).is_empty());
    assert_eq!(sightings(&state(vec![finding("5"); 100])).len(), MOST_FINDINGS);
}

#[test]
fn names_and_classes_are_those_of_the_detector() {
    assert_eq!(name(""), None);
    assert_eq!(name("42"), Some(42));
    assert!(name("bird-1").is_some() && name("bird-1") != name("bird-2"));
    let both = Finding {
        classes: BTreeMap::from([("drone".to_owned(), 0.7), ("bird".to_owned(), 0.2)]),
        ..finding("")
    };
    let scores = scores(&both);
    assert_eq!((scores.of("drone"), scores.of("bird")), (0.7, 0.2));
    let unknown = Finding {
        class: "kite".to_owned(),
        ..finding("")
    };
    assert_eq!(sightings(&state(vec![unknown]))[0].guess, None);
}
