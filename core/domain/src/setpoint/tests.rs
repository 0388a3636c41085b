//! What is added against drag: level, along the velocity, bounded, and nothing without a drag or a velocity.

use super::*;
use proptest::prelude::*;

fn moving(velocity: [f64; 3], drag_per_s: Option<f64>) -> Setpoint {
    Setpoint {
        position: Some(PositionNed::default()),
        velocity: Some(Vector3::from(velocity).into()),
        acceleration: Some(AccelerationNed::new(0.5, -0.25, 0.125)),
        drag_per_s,
        ..Setpoint::default()
    }
}

#[test]
fn a_velocity_takes_acceleration_against_drag_and_a_hold_takes_none() {
    let forward = moving([4.0, -2.0, 1.0], Some(0.5)).forward_acceleration();
    assert_eq!(forward, Some(AccelerationNed::new(2.5, -1.25, 0.125)));
    let none = moving([4.0, -2.0, 1.0], None);
    assert_eq!(none.forward_acceleration(), none.acceleration);
    let stands = moving([0.0; 3], Some(1.0));
    assert_eq!(stands.forward_acceleration(), stands.acceleration);
    let hold = Setpoint {
        drag_per_s: Some(1.0),
        ..Setpoint::hold(PositionNed::default(), None)
    };
    assert_eq!(hold.forward_acceleration(), None);
}

#[test]
fn a_drag_that_is_no_number_makes_a_setpoint_unusable() {
    assert!(moving([1.0; 3], Some(0.3)).is_well_formed());
    assert!(!moving([1.0; 3], Some(f64::NAN)).is_well_formed());
}

proptest! {
    #[test]
    fn what_is_added_is_bounded_and_pushes_along_the_velocity(
        velocity in prop::array::uniform3(-30.0..30.0_f64), drag_per_s in -1e6..1e6_f64,
    ) {
        let setpoint = moving(velocity, Some(drag_per_s));
        let added = setpoint.forward_acceleration().unwrap().vector() - setpoint.acceleration.unwrap().vector();
        let level = Vector3::new(velocity[0], velocity[1], 0.0);
        prop_assert!(added.norm() <= 5.0 + 1e-9 && added.norm() <= DRAG_MAX_PER_S * level.norm() + 1e-9);
        prop_assert!(added.z == 0.0 && added.dot(&level) >= 0.0);
        prop_assert!(added.cross(&level).norm() < 1e-6);
    }
}

#[test]
fn a_reader_of_before_reads_a_setpoint_with_drag_and_the_other_way_round() {
    #[derive(Debug, PartialEq, Encode, Decode)]
    struct Before {
        #[n(1)]
        velocity: Option<VelocityNed>,
        #[n(4)]
        yaw_rate_rad_s: Option<f64>,
    }
    let setpoint = moving([1.0, 2.0, 3.0], Some(0.4));
    let before: Before = minicbor::decode(&minicbor::to_vec(setpoint).unwrap()).unwrap();
    assert_eq!(before.velocity, setpoint.velocity);
    let after: Setpoint = minicbor::decode(&minicbor::to_vec(before).unwrap()).unwrap();
    assert_eq!((after.velocity, after.drag_per_s), (setpoint.velocity, None));
}
