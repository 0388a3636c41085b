//! Property tests of the frame arithmetic.

use super::*;
use proptest::prelude::*;

fn geodetic() -> impl Strategy<Value = Geodetic> {
    (-85.0..85.0f64, -179.0..179.0f64, -100.0..4000.0f64).prop_map(|(latitude_deg, longitude_deg, altitude_amsl_m)| {
        Geodetic {
            latitude_deg,
            longitude_deg,
            altitude_amsl_m,
        }
    })
}

fn offset() -> impl Strategy<Value = Vector3<f64>> {
    (-3000.0..3000.0f64, -3000.0..3000.0f64, -300.0..300.0f64).prop_map(|(n, e, d)| Vector3::new(n, e, d))
}

proptest! {
    #[test]
    fn swarm_frame_round_trips(origin in geodetic(), v in offset()) {
        let frame = SwarmFrame::new(origin);
        let position = PositionNed::from(v);
        let back = frame.position(&frame.geodetic(&position));
        prop_assert!(back.distance_m(&position) < 1e-3, "{back:?} {position:?}");
    }

    #[test]
    fn local_frame_is_recovered_from_one_pair(origin in geodetic(), v in offset()) {
        let truth = LocalFrame { origin };
        let local = LocalPositionNed::from(v);
        let found = LocalFrame::from_pair(&truth.geodetic(&local), &local);
        let moved = project(&origin, &found.origin);
        prop_assert!(moved.norm() < 1e-3, "off by {moved:?}");
    }

    #[test]
    fn two_vehicles_agree_on_a_swarm_position(origin in geodetic(), a in offset(), b in offset(), p in offset()) {
        let swarm = SwarmFrame::new(origin);
        let p = PositionNed::from(p);
        for start in [a, b] {
            let local = LocalFrame { origin: swarm.geodetic(&PositionNed::from(start)) };
            let back = local.to_swarm(&swarm, &local.from_swarm(&swarm, &p));
            prop_assert!(back.distance_m(&p) < 2e-3);
        }
    }

    #[test]
    fn offsets_rotate_and_return(v in offset(), heading in -7.0..7.0f64) {
        let offset = OffsetFrd::from(v);
        let back = OffsetFrd::from_ned(offset.rotated(heading), heading);
        prop_assert!((back.vector() - v).norm() < 1e-6);
    }
}

#[test]
fn one_degree_of_latitude_is_where_px4_puts_it() {
    let frame = SwarmFrame::new(Geodetic {
        latitude_deg: 47.0,
        longitude_deg: 8.0,
        altitude_amsl_m: 500.0,
    });
    let north = frame.position(&Geodetic {
        latitude_deg: 48.0,
        longitude_deg: 8.0,
        altitude_amsl_m: 510.0,
    });
    assert!((north.north_m - EARTH_RADIUS_M.to_radians()).abs() < 1.0);
    assert!((north.down_m + 10.0).abs() < 1e-9);
}
