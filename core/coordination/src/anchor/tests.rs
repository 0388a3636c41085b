//! Tests of anchors that are no vehicle: the same for everybody, without jumps when the plan changes.

use super::*;
use crate::references::ReferenceReport;
use skein_domain::Route;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn place(heading_rad: f64) -> AnchorPlan {
    AnchorPlan::Place {
        position: PositionNed::new(10.0, 20.0, -5.0),
        heading_rad,
        max_rate_rad_s: 0.2,
    }
}

fn path() -> AnchorPlan {
    AnchorPlan::Path {
        route: Route {
            waypoints: vec![PositionNed::new(60.0, 0.0, -5.0), PositionNed::new(60.0, 60.0, -5.0)],
            speed_m_s: 5.0,
            corner_radius_m: 8.0,
        },
        from: PositionNed::new(0.0, 0.0, -5.0),
        heading_rad: 0.0,
        heading: FormationHeading::Course { max_rate_rad_s: 0.3 },
        acceleration_m_s2: 2.0,
        climb_m_s: 2.0,
        descent_m_s: 1.0,
        start: at(2.0),
    }
}

#[test]
fn two_nodes_that_look_at_different_times_see_the_same_virtual_leader() {
    let references = References::new(12.0);
    let (mut early, mut late) = (AnchorKeeper::default(), AnchorKeeper::default());
    for period in 0..1_000 {
        early.at(
            Some(&path()),
            None,
            &references,
            &Fences::default(),
            at(f64::from(period) * 0.02),
        );
    }
    let now = at(20.0);
    let seen = early
        .at(Some(&path()), None, &references, &Fences::default(), now)
        .expect("flies");
    assert_eq!(
        late.at(Some(&path()), None, &references, &Fences::default(), now),
        Some(seen)
    );
    assert!(seen.velocity.norm() > 1.0, "{seen:?}");
}

#[test]
fn a_formation_at_a_place_turns_towards_its_heading_no_faster_than_it_may() {
    let references = References::new(12.0);
    let mut keeper = AnchorKeeper::default();
    keeper.at(Some(&place(0.0)), None, &references, &Fences::default(), at(0.0));
    let mut before = 0.0_f64;
    for period in 1..=1_000 {
        let now = at(f64::from(period) * 0.02);
        let anchor = keeper
            .at(Some(&place(1.5)), None, &references, &Fences::default(), now)
            .expect("stands");
        assert!((anchor.heading_rad - before).abs() <= 0.2 * 0.02 + 1e-9, "at {now:?}");
        assert_eq!(anchor.position, PositionNed::new(10.0, 20.0, -5.0));
        before = anchor.heading_rad;
    }
    assert!((before - 1.5).abs() < 1e-3);
}

#[test]
fn a_reference_that_is_not_known_is_no_anchor_and_one_that_is_forgotten_stands() {
    let references = References::new(12.0);
    let plan = AnchorPlan::Reference {
        name: "car".into(),
        heading: FormationHeading::Course { max_rate_rad_s: 0.3 },
        places: Vec::new(),
    };
    let mut keeper = AnchorKeeper::default();
    assert_eq!(
        keeper.at(Some(&plan), None, &references, &Fences::default(), at(0.0)),
        None
    );
    let report = |north_m: f64| ReferenceReport {
        position: PositionNed::new(north_m, 0.0, -8.0),
        velocity: Some(VelocityNed::new(3.0, 0.0, 0.0)),
        heading_rad: None,
    };
    let mut last = None;
    for step in 0..50 {
        let seconds = f64::from(step) * 0.2;
        references
            .tell("car", report(3.0 * seconds), at(seconds))
            .expect("is taken");
        last = keeper.at(Some(&plan), None, &references, &Fences::default(), at(seconds));
    }
    let moving = last.expect("is known");
    assert!(moving.velocity.north_m_s > 2.0, "{moving:?}");
    assert!(references.forget("car"));
    let standing = keeper
        .at(Some(&plan), None, &references, &Fences::default(), at(10.0))
        .expect("stands");
    assert_eq!(standing.velocity, VelocityNed::default());
    assert!((standing.position.north_m - moving.position.north_m).abs() < 1e-9);
}

/// The leader's anchor is taken away when the plan changes: the formation turns from the heading it had all the same.
#[test]
fn a_formation_that_was_led_turns_from_the_heading_it_had() {
    let mut keeper = AnchorKeeper::default();
    let references = References::new(12.0);
    let at = |s: f64| NodeTime::from_seconds(10.0 + s);
    let led = AnchorReference {
        heading_rad: 3.0,
        time: at(0.0),
        ..AnchorReference::default()
    };
    assert_eq!(
        keeper.at(None, Some(&led), &references, &Fences::default(), at(0.0)),
        None
    );
    let plan = AnchorPlan::Place {
        position: PositionNed::new(5.0, 0.0, -10.0),
        heading_rad: 0.0,
        max_rate_rad_s: 0.2,
    };
    let first = keeper
        .at(Some(&plan), None, &references, &Fences::default(), at(0.02))
        .expect("has an anchor");
    assert!((first.heading_rad - 3.0).abs() < 0.01, "{first:?}");
    let mut last = first;
    for period in 1..2_000 {
        last = keeper
            .at(
                Some(&plan),
                None,
                &references,
                &Fences::default(),
                at(0.02 + 0.02 * f64::from(period)),
            )
            .expect("has an anchor");
    }
    assert!(last.heading_rad.abs() < 0.01, "{last:?}");
}
