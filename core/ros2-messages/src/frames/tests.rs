//! The conversions against rotation matrices written out by hand, there and back.

use super::*;
use nalgebra::{Matrix3, Rotation3};
use proptest::prelude::*;

fn ned_to_enu() -> Matrix3<f64> {
    Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0)
}

fn frd_to_flu() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector::new(1.0, -1.0, -1.0))
}

/// Of forward-right-down in north-east-down, from the definition of the three angles.
fn body_in_ned(roll: f64, pitch: f64, yaw: f64) -> Matrix3<f64> {
    let about = |axis: Vector<f64>, angle: f64| Rotation3::new(axis * angle).into_inner();
    about(Vector::z(), yaw) * about(Vector::y(), pitch) * about(Vector::x(), roll)
}

fn matrix(q: &Quaternion) -> Matrix3<f64> {
    let q = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q.w, q.x, q.y, q.z));
    q.to_rotation_matrix().into_inner()
}

fn array(v: &Vector3) -> Vector<f64> {
    Vector::new(v.x, v.y, v.z)
}

#[test]
fn well_known_cases() {
    assert_eq!(
        point(&PositionNed::new(1.0, 2.0, -3.0)),
        Point { x: 2.0, y: 1.0, z: 3.0 }
    );
    // To the east is along x.
    assert!(yaw_rad(FRAC_PI_2).abs() < 1e-12);
    let east = orientation(0.0, 0.0, FRAC_PI_2);
    assert!((east.w - 1.0).abs() < 1e-12, "{east:?}");
    // Nose up by 90 degrees, to the north: forward is up.
    let up = matrix(&orientation(0.0, FRAC_PI_2, 0.0)) * Vector::x();
    assert!((up - Vector::z()).norm() < 1e-9, "{up}");
    // Left of a vehicle that looks north is west.
    let left = stick(&Vector3 { x: 0.0, y: 1.0, z: 0.0 }, 0.0).velocity(0.0);
    assert!((left.vector() - Vector::new(0.0, -1.0, 0.0)).norm() < 1e-12);
    // A camera that looks north: its axis is z, right of it is east, below is below.
    let optical = matrix(&optical(0.0, 0.0, 0.0));
    let axes = [Vector::z(), Vector::x(), Vector::y()].map(|axis| optical * axis);
    for (axis, expected) in axes.iter().zip([Vector::y(), Vector::x(), -Vector::z()]) {
        assert!((axis - expected).norm() < 1e-9, "{axes:?}");
    }
    assert_eq!(look(&Vector3::default(), true), None);
    assert_eq!(
        look(
            &Vector3 {
                x: f64::NAN,
                y: 0.0,
                z: 1.0
            },
            true
        ),
        None
    );
}

proptest! {
    #[test]
    fn positions_come_back(n in -1e5..1e5, e in -1e5..1e5, d in -1e4..1e4) {
        let there = PositionNed::new(n, e, d);
        prop_assert_eq!(position(&point(&there)), there);
    }

    #[test]
    fn yaws_come_back(yaw in -3.1..3.1) {
        prop_assert!((yaw_rad(yaw_rad(yaw)) - yaw).abs() < 1e-9);
    }

    #[test]
    fn an_attitude_is_the_product_of_the_frames(roll in -3.0..3.0, pitch in -1.5..1.5, yaw in -3.0..3.0) {
        let q = orientation(roll, pitch, yaw);
        let norm = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
        prop_assert!((norm - 1.0).abs() < 1e-9 && q.w >= 0.0);
        let expected = ned_to_enu() * body_in_ned(roll, pitch, yaw) * frd_to_flu();
        prop_assert!((matrix(&q) - expected).norm() < 1e-9);
    }

    #[test]
    fn a_velocity_in_the_body_is_the_one_in_the_world(
        n in -20.0..20.0, e in -20.0..20.0, d in -5.0..5.0, roll in -1.0..1.0, pitch in -1.0..1.0, yaw in -3.0..3.0,
    ) {
        let world = VelocityNed::new(n, e, d);
        let expected = frd_to_flu() * body_in_ned(roll, pitch, yaw).transpose() * world.vector();
        prop_assert!((array(&velocity_in_body(&world, roll, pitch, yaw)) - expected).norm() < 1e-9);
        // And back, of a level body.
        let level = velocity_in_body(&world, 0.0, 0.0, yaw);
        prop_assert!((stick(&level, 0.0).velocity(yaw).vector() - world.vector()).norm() < 1e-9);
    }

    #[test]
    fn a_direction_is_looked_along(pitch in -1.5..1.5, yaw in -3.0..3.0) {
        let forward = matrix(&orientation(0.0, pitch, yaw)) * Vector::x();
        let (found_pitch, found_yaw) = look(&vector(forward), true).expect("a direction");
        prop_assert!((found_pitch - pitch).abs() < 1e-9 && (found_yaw - yaw).abs() < 1e-9);
        // Of the body: to the right is clockwise.
        let (_, right) = look(&Vector3 { x: 1.0, y: -1.0, z: 0.0 }, false).expect("a direction");
        prop_assert!((right - FRAC_PI_2 / 2.0).abs() < 1e-9);
    }

    #[test]
    fn whatever_direction_comes_in_is_taken_without_a_panic(x in any::<f64>(), y in any::<f64>(), z in any::<f64>()) {
        if let Some((pitch, yaw)) = look(&Vector3 { x, y, z }, true) {
            prop_assert!(pitch.is_finite() && yaw.is_finite());
        }
    }
}

#[test]
fn a_covariance_turns_with_the_axes() {
    let ned = Matrix3::new(4.0, 1.0, 0.5, 1.0, 9.0, 0.25, 0.5, 0.25, 16.0);
    let whole = covariance(&ned).0;
    let expected = ned_to_enu() * ned * ned_to_enu().transpose();
    for (row, column) in (0..6).flat_map(|row| (0..6).map(move |column| (row, column))) {
        let wanted = if row < 3 && column < 3 {
            expected[(row, column)]
        } else {
            0.0
        };
        assert_eq!(whole[6 * row + column], wanted, "{row} {column}");
    }
    // East is better known than north here, and stands first in `map`.
    assert_eq!((whole[0], whole[7], whole[14]), (9.0, 4.0, 16.0));
}
