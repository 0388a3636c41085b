//! What is asked means the same here as there, and no number gets through that cannot be meant.

use super::*;
use crate::interfaces::geometry::{Point, Vector3};
use proptest::prelude::*;
use skein_domain::PositionNed;
use std::f64::consts::FRAC_PI_2;

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>(),
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(1e308),
        Just(-1e308),
        -50.0..50.0
    ]
}

#[test]
fn a_place_and_a_yaw_are_turned_into_the_swarms_frame() {
    let request = GoToRequest {
        position: Point { x: 1.0, y: 2.0, z: 3.0 },
        set_yaw: true,
        yaw_rad: 0.0,
        speed_m_s: 0.0,
    };
    let Ok(VehicleCommand::GoTo {
        position,
        yaw_rad,
        speed_m_s,
    }) = go_to(&request)
    else {
        panic!("refused");
    };
    assert_eq!(position, PositionNed::new(2.0, 1.0, -3.0));
    assert!((yaw_rad.expect("a yaw") - FRAC_PI_2).abs() < 1e-12);
    assert_eq!(speed_m_s, None);
}

#[test]
fn a_formation_is_named_by_its_words() {
    let request = SetFormationRequest {
        shape: "echelon_left".into(),
        spacing_m: 5.0,
        heading: "fixed".into(),
        heading_rad: FRAC_PI_2,
        rotation_rad: FRAC_PI_2,
        members: vec![3, 1],
        ..SetFormationRequest::default()
    };
    let asked = formation(&request).expect("taken");
    assert_eq!(asked.shape, Shape::EchelonLeft);
    assert_eq!(asked.scale, 1.0);
    assert!((asked.rotation_deg + 90.0).abs() < 1e-9);
    assert_eq!(asked.heading, HeadingRequest::Fixed { heading_deg: 0.0 });
    assert_eq!(asked.members, Some(vec![VehicleId(3), VehicleId(1)]));
    for shape in ["free", "", "Wedge", "blob"] {
        let request = SetFormationRequest {
            shape: shape.into(),
            ..request.clone()
        };
        assert_eq!(formation(&request).expect_err("refused").code(), "invalid_value");
    }
}

#[test]
fn nobody_follows_itself() {
    let follow_me = |followers: &[u16]| {
        follow(&FollowRequest {
            leader: 1,
            followers: followers.to_vec(),
            spacing_m: 4.0,
        })
    };
    assert_eq!(follow_me(&[2, 3]).expect("taken").leader, Some(VehicleId(1)));
    for followers in [&[][..], &[1], &[2, 2]] {
        assert_eq!(follow_me(followers).expect_err("refused").code(), "invalid_value");
    }
}

#[test]
fn a_gimbal_looks_where_it_is_told() {
    let request = |frame_id: &str, x, y, z| PointGimbalRequest {
        gimbal: String::new(),
        frame_id: frame_id.into(),
        direction: Vector3 { x, y, z },
    };
    let Ok(GimbalCommand::Angles {
        pitch_rad,
        yaw_rad,
        yaw_frame,
    }) = point_gimbal(&request("map", 1.0, 0.0, -1.0), "uav_1/base_link")
    else {
        panic!("refused");
    };
    assert_eq!(yaw_frame, GimbalYawFrame::North);
    assert!((pitch_rad + FRAC_PI_2 / 2.0).abs() < 1e-9 && (yaw_rad - FRAC_PI_2).abs() < 1e-9);
    assert!(point_gimbal(&request("uav_1/base_link", 1.0, 0.0, 0.0), "uav_1/base_link").is_ok());
    assert!(point_gimbal(&request("uav_2/base_link", 1.0, 0.0, 0.0), "uav_1/base_link").is_err());
    assert!(point_gimbal(&request("map", 0.0, 0.0, 0.0), "uav_1/base_link").is_err());
}

#[test]
fn a_velocity_that_is_too_fast_or_tips_over_is_refused() {
    let turning = |x, rolling, turning| Twist {
        linear: Vector3 { x, y: 0.0, z: 0.0 },
        angular: Vector3 {
            x: rolling,
            y: 0.0,
            z: turning,
        },
    };
    let twist = |x, rate| turning(x, 0.0, rate);
    assert!(velocity(&twist(3.0, 0.0), 5.0).is_ok());
    assert_eq!(velocity(&twist(6.0, 0.0), 5.0).expect_err("refused").code(), "too_fast");
    // Counter-clockwise there is clockwise here, as left is right.
    let stick = velocity(&twist(1.0, 0.5), 5.0).expect("is flown");
    assert_eq!((stick.forward_m_s, stick.yaw_rate_rad_s), (1.0, -0.5));
    for (refused, code) in [
        (twist(1.0, f64::NAN), "invalid_value"),
        (twist(1.0, 100.0), "invalid_value"),
        (turning(1.0, 0.5, 0.0), "not_supported"),
        (turning(1.0, f64::NAN, 0.0), "not_supported"),
    ] {
        assert_eq!(
            velocity(&refused, 5.0).expect_err("refused").code(),
            code,
            "{refused:?}"
        );
    }
    assert_eq!(
        velocity(&twist(1e308, 0.0), 5.0).expect_err("refused").code(),
        "invalid_value"
    );
}

proptest! {
    #[test]
    fn no_number_gets_through_that_cannot_be_meant(
        x in any_number(), y in any_number(), z in any_number(), a in any_number(), b in any_number(), c in any_number(),
        set in any::<bool>(), ids in proptest::collection::vec(any::<u16>(), 0..8),
    ) {
        if let Ok(VehicleCommand::TakeOff { height_m }) = take_off(&TakeOffRequest { height_m: x }) {
            prop_assert!(height_m > 0.0 && height_m <= HIGHEST_M);
        }
        let request = GoToRequest { position: Point { x, y, z }, set_yaw: set, yaw_rad: a, speed_m_s: b };
        if let Ok(VehicleCommand::GoTo { position, yaw_rad, speed_m_s }) = go_to(&request) {
            prop_assert!(position.norm() < 2.0 * FARTHEST_M);
            prop_assert!(yaw_rad.is_none_or(f64::is_finite));
            prop_assert!(speed_m_s.is_none_or(|speed| speed > 0.0 && speed <= FASTEST_M_S));
        }
        let twist = Twist { linear: Vector3 { x, y, z }, angular: Vector3 { x: a, y: b, z: c } };
        if let Ok(stick) = velocity(&twist, 12.0) {
            prop_assert!(stick.forward_m_s.hypot(stick.right_m_s).hypot(stick.up_m_s) <= 12.0);
            prop_assert!(stick.check().is_ok());
        }
        let request = SetFormationRequest {
            shape: "wedge".into(), spacing_m: x, heading: "fixed".into(), heading_rad: y, altitude_step_m: z,
            rotation_rad: a, scale: b, set_leader: set, leader: 1, members: ids.clone(),
        };
        if let Ok(asked) = formation(&request) {
            let HeadingRequest::Fixed { heading_deg } = asked.heading else { panic!("fixed") };
            let numbers = [asked.spacing_m, heading_deg, asked.altitude_step_m, asked.rotation_deg, asked.scale];
            prop_assert!(numbers.iter().all(|number| number.is_finite()) && asked.spacing_m > 0.0 && asked.scale > 0.0);
        }
        let _ = follow(&FollowRequest { leader: 1, followers: ids, spacing_m: c });
        let _ = point_gimbal(&PointGimbalRequest { gimbal: String::new(), frame_id: "map".into(), direction: twist.linear }, "");
    }
}
