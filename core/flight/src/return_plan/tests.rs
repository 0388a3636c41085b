//! Tests of the common return: heights and landing places apart, and nobody through another's height.

use super::*;
use proptest::prelude::*;

fn settings(ceiling_down_m: Option<f64>) -> ReturnSettings {
    ReturnSettings {
        height_m: 12.0,
        layer_gap_m: 4.0,
        landing_spacing_m: 3.0,
        ceiling_down_m,
    }
}

fn homing() -> impl Strategy<Value = Vec<Homing>> {
    let coordinates = [-80.0..80.0_f64, -80.0..80.0, -60.0..-2.0, -3.0..3.0, -3.0..3.0];
    proptest::collection::vec(coordinates, 1..60).prop_map(|all| {
        let one = |(i, [n, e, d, home_n, home_e]): (usize, [f64; 5])| Homing {
            vehicle: VehicleId(i as u16 + 1),
            position: PositionNed::new(n, e, d),
            home: PositionNed::new(home_n, home_e, 0.0),
        };
        all.into_iter().enumerate().map(one).collect()
    })
}

proptest! {
    #[test]
    fn landing_places_and_heights_are_apart_and_the_order_of_heights_stays(all in homing()) {
        let settings = settings(None);
        let ways = plan(&all, &settings);
        for (i, (a, from_a)) in ways.iter().zip(&all).enumerate() {
            prop_assert!(a.cruise_down_m <= -settings.height_m + 1e-9);
            prop_assert!(!a.shares_height);
            for (b, from_b) in ways.iter().zip(&all).skip(i + 1) {
                prop_assert!(a.spot.horizontal_distance_m(&b.spot) >= settings.landing_spacing_m - 1e-9);
                prop_assert!((a.cruise_down_m - b.cruise_down_m).abs() >= settings.layer_gap_m - 1e-9);
                if from_a.position.down_m < from_b.position.down_m {
                    prop_assert!(a.cruise_down_m < b.cruise_down_m, "the higher one stays higher");
                }
            }
        }
    }

    #[test]
    fn nobody_flies_above_the_ceiling(all in homing(), ceiling_m in 15.0..40.0_f64) {
        let ways = plan(&all, &settings(Some(-ceiling_m)));
        for way in &ways {
            prop_assert!(way.cruise_down_m >= -ceiling_m - 1e-9, "{way:?}");
        }
    }
}

#[test]
fn whoever_has_a_launch_place_to_itself_lands_there() {
    let at = |id: u16, north_m: f64| Homing {
        vehicle: VehicleId(id),
        position: PositionNed::new(30.0, north_m, -10.0),
        home: PositionNed::new(0.0, north_m, 0.0),
    };
    let ways = plan(&[at(1, 0.0), at(2, 5.0), at(3, 5.0)], &settings(None));
    assert_eq!(ways[0].spot, PositionNed::new(0.0, 0.0, 0.0));
    assert_eq!(ways[1].spot, PositionNed::new(0.0, 5.0, 0.0));
    assert!(ways[2].spot.horizontal_distance_m(&ways[1].spot) >= 3.0);
}
