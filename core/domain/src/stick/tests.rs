//! Axes and bounds of a stick.

use super::*;
use std::f64::consts::FRAC_PI_2;

#[test]
fn forward_is_where_the_nose_points_and_right_is_clockwise_of_it() {
    let stick = Stick {
        forward_m_s: 3.0,
        right_m_s: 1.0,
        up_m_s: 2.0,
        yaw_rate_rad_s: 0.0,
    };
    let east = stick.velocity(FRAC_PI_2);
    assert!(
        (east.east_m_s - 3.0).abs() < 1e-12 && (east.north_m_s + 1.0).abs() < 1e-12,
        "{east:?}"
    );
    assert_eq!(east.down_m_s, -2.0);
    let north = stick.velocity(0.0);
    assert_eq!((north.north_m_s, north.east_m_s), (3.0, 1.0));
}

#[test]
fn what_cannot_be_meant_is_refused_by_name() {
    let good = Stick {
        forward_m_s: -FASTEST_STICK_M_S,
        yaw_rate_rad_s: FASTEST_STICK_RAD_S,
        ..Stick::default()
    };
    assert_eq!(good.check(), Ok(()));
    for (broken, name) in [
        (
            Stick {
                forward_m_s: f64::NAN,
                ..good
            },
            "forward_m_s",
        ),
        (
            Stick {
                right_m_s: f64::INFINITY,
                ..good
            },
            "right_m_s",
        ),
        (Stick { up_m_s: 51.0, ..good }, "up_m_s"),
        (
            Stick {
                yaw_rate_rad_s: -7.0,
                ..good
            },
            "yaw_rate_rad_s",
        ),
    ] {
        let refusal = broken.check().expect_err("is refused");
        assert!(refusal.to_string().contains(name), "{refusal}");
    }
}
