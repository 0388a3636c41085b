//! What goes over the bus small comes out as it went in.

use super::*;
use proptest::prelude::*;

proptest! {
    #[test]
    fn keys_name_what_they_were_made_of(kind in prop::sample::select(KINDS.to_vec()), item: u16, part: u8) {
        prop_assert_eq!(named(key(kind, item, part)), Some((kind, item)));
    }

    #[test]
    fn motion_goes_over_the_bus_to_the_millimetre(
        n in -1e5..1e5_f64, e in -1e5..1e5_f64, d in -1e4..1e4_f64, v in -50.0..50.0_f64, yaw in -3.2..3.2_f64, age in 0_u64..3_000_000,
    ) {
        let now = NodeTime(9_000_000);
        let own = VehicleKinematics {
            position: PositionNed { north_m: n, east_m: e, down_m: d },
            velocity: VelocityNed { north_m_s: v, east_m_s: -v, down_m_s: 0.5 * v },
            yaw_rad: yaw,
            measured: NodeTime(now.0 - age),
        };
        // The receiver's clock is elsewhere.
        let there = Motion::of(&own, now).kinematics(NodeTime(70_000_000));
        prop_assert!(there.position.distance_m(&own.position) < 0.001);
        prop_assert!((there.velocity.vector() - own.velocity.vector()).norm() < 0.001);
        prop_assert!((there.yaw_rad - own.yaw_rad).abs() < 1e-4);
        prop_assert_eq!(there.measured, NodeTime(70_000_000 - age));
    }
}

#[test]
fn numbers_that_are_none_go_over_the_bus_without_harm() {
    let own = VehicleKinematics {
        position: PositionNed {
            north_m: f64::NAN,
            east_m: f64::INFINITY,
            down_m: 0.0,
        },
        ..VehicleKinematics::default()
    };
    assert!(
        Motion::of(&own, NodeTime(5))
            .kinematics(NodeTime(5))
            .position
            .is_finite()
    );
}

#[test]
fn a_key_of_a_later_version_names_nothing() {
    assert_eq!(named(Key(200 << 24)), None);
}
