//! Who is obeyed, and in which frame a yaw is held.

use super::*;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

const US: Party = (245, 190);
const OTHERS: Party = (255, 190);
const AUTOPILOT: Party = (1, 1);
const NORTH: Carrier = Carrier {
    yaw_rad: 0.0,
    yaw_rate_rad_s: 0.0,
};

fn angles(pitch_rad: f64, yaw_rad: f64, flags: u32) -> Asked {
    Asked {
        pitch_rad,
        yaw_rad,
        pitch_rad_s: f64::NAN,
        yaw_rad_s: f64::NAN,
        flags,
    }
}

fn ours() -> Gimbal {
    let mut gimbal = Gimbal::new(GimbalSettings::default());
    gimbal.configure(US, (245.0, 190.0), AUTOPILOT);
    gimbal
}

fn run(gimbal: &mut Gimbal, carrier: &Carrier, seconds: f64) {
    for _ in 0..(seconds / 0.004) as usize {
        gimbal.step(carrier, |_| Vector3::new(10.0, 10.0, 14.142_135_623), 0.004);
    }
}

#[test]
fn nobody_is_obeyed_before_control_was_taken_and_then_one() {
    let mut gimbal = Gimbal::new(GimbalSettings::default());
    let asked = angles(-0.5, 0.3, 0);
    assert!(!gimbal.ask(US, &asked, &NORTH));
    assert!(!gimbal.ask((0, 0), &asked, &NORTH), "nobody is not a party");
    gimbal.configure(US, (245.0, 190.0), AUTOPILOT);
    assert!(gimbal.ask(US, &asked, &NORTH));
    assert!(!gimbal.ask(OTHERS, &asked, &NORTH));
    run(&mut gimbal, &NORTH, 1.0);
    assert!((gimbal.head.pitch.angle_rad + 0.5).abs() < 1e-3);
    // Only its own control can be given back, but anyone may take it, as with PX4.
    gimbal.configure(OTHERS, (-3.0, -3.0), AUTOPILOT);
    assert_eq!(
        gimbal.owner,
        (245, 0),
        "the component is the same, as PX4 looks at each for itself"
    );
    gimbal.configure(OTHERS, (255.0, 190.0), AUTOPILOT);
    assert!(!gimbal.ask(US, &asked, &NORTH) && gimbal.ask(OTHERS, &asked, &NORTH));
    gimbal.configure(OTHERS, (-1.0, f32::NAN), AUTOPILOT);
    assert_eq!(gimbal.owner, OTHERS);
    gimbal.configure(OTHERS, (-2.0, -2.0), AUTOPILOT);
    assert_eq!(gimbal.owner, AUTOPILOT);
    gimbal.configure(OTHERS, (0.0, 0.0), AUTOPILOT);
    assert_eq!(gimbal.owner, (0, 0));
}

#[test]
fn a_locked_yaw_stays_when_the_vehicle_turns_and_a_following_one_turns_with_it() {
    for (flags, kept_north) in [(flags::YAW_LOCK, true), (0, false), (flags::YAW_IN_EARTH_FRAME, false)] {
        let mut gimbal = ours();
        gimbal.ask(US, &angles(0.0, 0.5, flags), &NORTH);
        run(&mut gimbal, &NORTH, 1.0);
        let mut carrier = Carrier {
            yaw_rad: 0.0,
            yaw_rate_rad_s: 0.8,
        };
        let mut worst_rad = 0.0_f64;
        for _ in 0..250 {
            // The vehicle jumps into its turn, the head takes a moment to follow.
            carrier.yaw_rad += carrier.yaw_rate_rad_s * 0.004;
            gimbal.step(&carrier, |_| Vector3::x(), 0.004);
            let held = if kept_north {
                gimbal.yaw_north_rad(&carrier)
            } else {
                gimbal.head.yaw.angle_rad
            };
            worst_rad = worst_rad.max((held - 0.5).abs());
        }
        assert!(worst_rad < 0.03, "{flags}: {worst_rad}");
        assert_eq!(gimbal.is_yaw_locked(), kept_north);
    }
}

#[test]
fn a_yaw_is_read_in_the_frame_in_which_it_is_held_whatever_other_flags_say() {
    let east = Carrier {
        yaw_rad: FRAC_PI_2,
        yaw_rate_rad_s: 0.0,
    };
    for (flags, north_rad) in [
        (flags::YAW_LOCK, 0.2),
        (0, FRAC_PI_2 + 0.2),
        (flags::YAW_IN_EARTH_FRAME, FRAC_PI_2 + 0.2),
        (flags::YAW_LOCK | flags::YAW_IN_VEHICLE_FRAME, 0.2),
        (flags::YAW_LOCK | flags::YAW_IN_EARTH_FRAME, 0.2),
    ] {
        let mut gimbal = ours();
        gimbal.ask(US, &angles(0.0, 0.2, flags), &east);
        run(&mut gimbal, &east, 3.0);
        assert!((gimbal.yaw_north_rad(&east) - north_rad).abs() < 1e-3, "{flags}");
    }
}

#[test]
fn a_region_of_interest_is_looked_at_and_given_up() {
    let mut gimbal = Gimbal::new(GimbalSettings::default());
    gimbal.region_of_interest(Some(Geodetic::default()));
    run(&mut gimbal, &NORTH, 2.0);
    assert!((gimbal.head.pitch.angle_rad + 45_f64.to_radians()).abs() < 1e-3);
    assert!((gimbal.head.yaw.angle_rad - 45_f64.to_radians()).abs() < 1e-3);
    gimbal.region_of_interest(None);
    run(&mut gimbal, &NORTH, 2.0);
    assert!(gimbal.head.pitch.angle_rad.abs() < 1e-3 && gimbal.flags() & flags::NEUTRAL != 0);
}

#[test]
fn rates_turn_until_nobody_repeats_them_and_attitudes_are_taken_apart() {
    let mut gimbal = ours();
    let asked = Asked::from_attitude([f32::NAN; 4], [0.0, -0.2, 0.1], 0);
    assert!(asked.pitch_rad.is_nan());
    gimbal.ask(US, &asked, &NORTH);
    run(&mut gimbal, &NORTH, 2.0);
    assert!((gimbal.head.pitch.angle_rad + 0.4).abs() < 0.02 && (gimbal.head.yaw.angle_rad - 0.2).abs() < 0.02);
    run(&mut gimbal, &NORTH, 2.0);
    assert!(
        (gimbal.head.pitch.angle_rad + 0.4).abs() < 0.02,
        "two seconds, then it stands"
    );
    let turn = UnitQuaternion::from_euler_angles(0.0, -0.7, 0.3);
    let q = [turn.w, turn.i, turn.j, turn.k].map(|value| value as f32);
    let asked = Asked::from_attitude(q, [f32::NAN; 3], 0);
    assert!((asked.pitch_rad + 0.7).abs() < 1e-5 && (asked.yaw_rad - 0.3).abs() < 1e-5);
    assert!(Asked::from_attitude([0.0; 4], [0.0; 3], 0).pitch_rad.is_nan());
}

#[test]
fn to_retract_it_is_heard_and_not_done() {
    let mut gimbal = ours();
    gimbal.ask(US, &angles(-0.5, 0.2, 0), &NORTH);
    assert!(gimbal.ask(US, &angles(0.0, 0.0, flags::RETRACT), &NORTH));
    run(&mut gimbal, &NORTH, 1.0);
    assert!((gimbal.head.pitch.angle_rad + 0.5).abs() < 1e-3);
    assert!(gimbal.ask(US, &angles(-0.5, 0.0, flags::NEUTRAL), &NORTH));
    run(&mut gimbal, &NORTH, 1.0);
    assert!(gimbal.head.pitch.angle_rad.abs() < 1e-3);
}

/// Seen with PX4: its nose to the south, a place in the north-west, and the servo at 180 degrees.
#[test]
fn servos_are_not_turned_round_the_circle() {
    let south = Carrier {
        yaw_rad: 3.12,
        yaw_rate_rad_s: 0.0,
    };
    for (output, north_rad) in [
        (GimbalOutput::Servos { stabilised: true }, 3.12 - PI),
        (GimbalOutput::Device, -0.9),
    ] {
        let mut gimbal = Gimbal::new(GimbalSettings {
            output,
            ..GimbalSettings::default()
        });
        gimbal.configure(US, (245.0, 190.0), AUTOPILOT);
        gimbal.ask(US, &angles(0.0, -0.9, flags::YAW_LOCK), &south);
        run(&mut gimbal, &south, 4.0);
        assert!((gimbal.yaw_north_rad(&south) - north_rad).abs() < 0.01);
    }
}

/// Measured with PX4: -20 degrees with the lock gave 0 at the servo and -20 in what is said of it; 10 degrees per second gave 0.33.
#[test]
fn servos_that_are_not_stabilised_stay_where_they_are_to_be_held_and_rates_are_slow() {
    for (stabilised, pitch_rad) in [(false, 0.0), (true, -0.5)] {
        let mut gimbal = Gimbal::new(GimbalSettings {
            output: GimbalOutput::Servos { stabilised },
            ..GimbalSettings::default()
        });
        gimbal.configure(US, (245.0, 190.0), AUTOPILOT);
        gimbal.ask(US, &angles(-0.5, 0.3, flags::PITCH_LOCK), &NORTH);
        run(&mut gimbal, &NORTH, 1.0);
        assert!(
            (gimbal.head.pitch.angle_rad - pitch_rad).abs() < 1e-3 && (gimbal.head.yaw.angle_rad - 0.3).abs() < 1e-3
        );
        assert_eq!(gimbal.asked_rad(&NORTH), (-0.5, 0.3));
        let rates = Asked::from_attitude([f32::NAN; 4], [0.0, 0.0, 0.2], 0);
        gimbal.ask(US, &rates, &NORTH);
        run(&mut gimbal, &NORTH, 1.0);
        let turned_rad = gimbal.head.yaw.angle_rad - 0.3;
        assert!((turned_rad - 0.2 / 31.0).abs() < 1e-3, "{turned_rad}");
    }
}

proptest! {
    #[test]
    fn whoever_is_not_in_control_changes_nothing(system in any::<u8>(), component in any::<u8>(), pitch_rad in -2.0..0.5_f64, flags in any::<u32>()) {
        prop_assume!((system, component) != US);
        let mut gimbal = ours();
        let before = gimbal.clone();
        prop_assert!(!gimbal.ask((system, component), &angles(pitch_rad, 0.0, flags), &NORTH));
        prop_assert_eq!(gimbal, before);
    }
}
