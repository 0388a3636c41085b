//! Paths against what motion has to be: continuous, as fast as told, back where it began.

use super::*;
use proptest::prelude::*;

fn place() -> impl Strategy<Value = PositionNed> {
    (-300.0..300.0, -300.0..300.0, -120.0..0.0).prop_map(|(north, east, down)| PositionNed::new(north, east, down))
}

fn path() -> impl Strategy<Value = ObjectPath> {
    prop_oneof![
        (place(), place())
            .prop_filter("apart", |(from, to)| from.horizontal_distance_m(to) > 20.0)
            .prop_map(|(from, to)| ObjectPath::Line { from, to }),
        (place(), 20.0..300.0).prop_map(|(centre, radius_m)| ObjectPath::Circle { centre, radius_m }),
        place().prop_map(ObjectPath::Hover),
    ]
}

fn object() -> impl Strategy<Value = SceneObject> {
    let kinds = vec![TargetKind::Quadrotor, TargetKind::Bird, TargetKind::Aeroplane];
    (prop::sample::select(kinds), path(), 2.0..40.0, 0.0..1.0).prop_map(|(kind, path, speed_m_s, phase)| SceneObject {
        kind,
        size_m: None,
        path,
        speed_m_s: Some(speed_m_s),
        phase,
    })
}

proptest! {
    #[test]
    fn the_velocity_is_the_difference_quotient_of_the_position(object in object(), time_s in -500.0..5000.0_f64) {
        let step_s = 1e-4;
        let (before, now, after) = (object.at(time_s - step_s), object.at(time_s), object.at(time_s + step_s));
        let quotient = (after.position.vector() - before.position.vector()) / (2.0 * step_s);
        // The strongest acceleration is that of the climb, 6 x 120 m / (20 m)^2 x (40 m/s)^2.
        let off = (quotient - now.velocity.vector()).norm();
        prop_assert!(off < 3000.0 * step_s, "{off}");
        let level = now.velocity.vector().xy().norm();
        let speed = if matches!(object.path, ObjectPath::Hover(_)) { 0.0 } else { object.speed_m_s() };
        prop_assert!((level - speed).abs() < 1e-9, "{level}");
        // Neither does its attitude jump, and its nose is where it goes.
        prop_assert!((after.roll_rad - before.roll_rad).abs() < 10.0 * step_s);
        let nose = now.velocity.vector().xy() - Vector2::new(now.yaw_rad.cos(), now.yaw_rad.sin()) * level;
        prop_assert!(nose.norm() < 1e-9);
    }

    #[test]
    fn it_keeps_to_its_path(object in object(), time_s in 0.0..5000.0_f64) {
        let now = object.at(time_s);
        let place = now.position.vector();
        match object.path {
            ObjectPath::Circle { centre, radius_m } => {
                prop_assert!(((place - centre.vector()).norm() - radius_m).abs() < 1e-6);
                // Clockwise seen from above: what it goes around is to its right.
                let to_centre = (centre.vector() - place).xy();
                prop_assert!(across(now.velocity.vector().xy()).dot(&to_centre) > 0.0 && now.roll_rad > 0.0);
            }
            ObjectPath::Hover(position) => prop_assert_eq!(now.position, position),
            ObjectPath::Line { from, to } => {
                let (low, high) = (from.down_m.min(to.down_m), from.down_m.max(to.down_m));
                prop_assert!((low - 1e-9..=high + 1e-9).contains(&place.z));
                let turn_m = (object.speed_m_s().powi(2) / (9.81 * 0.5_f64.tan())).max(1.0);
                let middle = (from.vector() + to.vector()) / 2.0;
                let way = (to.vector() - from.vector()).xy();
                let offset = (place - middle).xy();
                prop_assert!(offset.dot(&way).abs() / way.norm() <= way.norm() / 2.0 + turn_m + 1e-6);
                let aside = offset.dot(&across(way)) / way.norm();
                prop_assert!((-1e-6..=2.0 * turn_m + 1e-6).contains(&aside), "{}", aside);
            }
        }
    }
}

#[test]
fn a_line_leads_there_and_back() {
    let (from, to) = (PositionNed::new(0.0, 10.0, -20.0), PositionNed::new(100.0, 10.0, -50.0));
    let object = SceneObject {
        kind: TargetKind::FixedWing,
        size_m: None,
        path: ObjectPath::Line { from, to },
        speed_m_s: Some(10.0),
        phase: 0.0,
    };
    let turn_m = 100.0 / (9.81 * 0.5_f64.tan());
    let turn_s = PI * turn_m / 10.0;
    let near = |time_s: f64, place: PositionNed| {
        let now = object.at(time_s).position;
        assert!(now.distance_m(&place) < 1e-6, "{now:?} at {time_s}");
    };
    near(0.0, from);
    near(10.0, to);
    near(10.0 + turn_s, PositionNed::new(100.0, 10.0 + 2.0 * turn_m, -50.0));
    near(20.0 + 2.0 * turn_s, from);
    let (climbing, turning) = (object.at(5.0), object.at(10.0 + turn_s / 2.0));
    assert!(climbing.pitch_rad > 0.2 && climbing.roll_rad == 0.0, "{climbing:?}");
    assert!(turning.pitch_rad.abs() < 1e-9 && turning.roll_rad > 0.4, "{turning:?}");
}

#[test]
fn wings_beat_and_what_hovers_looks_where_it_is_told() {
    let bird = SceneObject {
        kind: TargetKind::Bird,
        size_m: Some(1.0),
        path: ObjectPath::Hover(PositionNed::default()),
        speed_m_s: None,
        phase: 0.25,
    };
    let (now, half_a_beat_on, a_beat_on) = (bird.at(3.0), bird.at(3.125), bird.at(3.25));
    assert!((now.yaw_rad - PI / 2.0).abs() < 1e-9);
    assert!((half_a_beat_on.beat_rad - now.beat_rad).abs() > 3.0);
    assert!((a_beat_on.beat_rad - now.beat_rad).abs() < 1e-9);
}
