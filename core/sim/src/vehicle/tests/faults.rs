//! What goes wrong, and how a PX4 lives with it.

use super::rig::{Rig, position, quiet};
use crate::faults::{Fault, Receiver};
use crate::settings::SimSettings;
use crate::vehicle::LinkKind::Onboard;
use mavlink::dialects::common::{GpsFixType, MavMessage, MavResult};
use nalgebra::Vector3;
use skein_domain::{FlightMode, LandedState};

/// Flags of `ESTIMATOR_STATUS` of a vehicle in the air that knows everything.
const IN_THE_AIR: u16 = 895;

fn lost(lost: bool) -> Fault {
    let receiver = Receiver::All;
    Fault::GnssLost { receiver, lost }
}

fn flags(rig: &Rig) -> u16 {
    rig.last(|m| match m {
        MavMessage::ESTIMATOR_STATUS(s) => Some(s.flags.bits()),
        _ => None,
    })
    .expect("the estimator tells of itself")
}

#[test]
fn without_satellites_the_estimate_drifts_then_ends_and_the_vehicle_descends() {
    let mut rig = Rig::offboard(&quiet(), 20.0);
    rig.vehicle.inflict(lost(true));
    rig.run(4.5);
    let fix = rig.last(|m| match m {
        MavMessage::GPS_RAW_INT(g) => Some((g.fix_type, g.satellites_visible, g.lat)),
        _ => None,
    });
    assert_eq!(fix, Some((GpsFixType::GPS_FIX_TYPE_NO_FIX, 0, 0)));
    assert_eq!(
        rig.truth().mode,
        FlightMode::Offboard,
        "it flies on by its inertial sensors"
    );
    assert!(rig.rate_hz(Onboard, 32, 1.0) > 20.0);
    let drifted_m = rig.truth().estimate_error.norm();
    assert!((0.2..3.0).contains(&drifted_m), "{drifted_m} m");
    rig.run(2.0);
    assert_eq!((rig.truth().mode, rig.truth().failsafe), (FlightMode::Descend, true));
    assert!(rig.heard("Failsafe activated"));
    assert_eq!(flags(&rig) & (2 | 8 | 16), 0, "nothing horizontal is known");
    rig.run(1.0);
    assert_eq!(rig.rate_hz(Onboard, 32, 0.9) + rig.rate_hz(Onboard, 33, 0.9), 0.0);
    assert!(rig.rate_hz(Onboard, 30, 0.9) > 50.0, "it still knows how it lies");
    let held = rig.set_mode(4, 3);
    assert_eq!(held, Some(MavResult::MAV_RESULT_TEMPORARILY_REJECTED));
    // They come back: the position is set anew, and what was asked for goes on.
    rig.vehicle.inflict(lost(false));
    rig.run(3.0);
    assert_eq!((rig.truth().mode, rig.truth().failsafe), (FlightMode::Offboard, false));
    assert!(rig.truth().estimate_error.norm() < 0.05);
    assert_eq!(flags(&rig), IN_THE_AIR);
}

#[test]
fn without_satellites_a_descent_ends_on_the_ground() {
    let mut rig = Rig::offboard(&quiet(), 6.0);
    rig.vehicle.inflict(lost(true));
    let down = rig.run_until(60.0, |t| !t.armed && t.touches_ground);
    assert!(down.is_some(), "{:?}", rig.truth());
    assert_eq!(
        rig.arm(),
        Some(MavResult::MAV_RESULT_TEMPORARILY_REJECTED),
        "not without a place"
    );
}

#[test]
fn a_pilot_holds_the_height_instead_of_descending() {
    let mut rig = Rig::offboard(&quiet(), 10.0);
    rig.vehicle.pilot_mode(FlightMode::Position);
    rig.run(1.0);
    rig.vehicle.inflict(lost(true));
    rig.run(7.0);
    assert_eq!(rig.truth().mode, FlightMode::Altitude);
    assert!((rig.truth().height_m - 10.0).abs() < 1.0);
}

#[test]
fn a_small_error_of_the_receiver_is_followed_and_a_large_one_only_after_seven_seconds() {
    let mut rig = Rig::offboard(&quiet(), 10.0);
    let offset = |north_m: f64| Fault::GnssOffset {
        receiver: Receiver::First,
        offset_m: Vector3::new(north_m, 0.0, 0.0),
    };
    rig.vehicle.inflict(offset(2.0));
    rig.run(6.0);
    assert!((rig.truth().estimate_error.north_m - 2.0).abs() < 0.05);
    rig.vehicle.inflict(offset(32.0));
    rig.run(6.5);
    assert!((rig.truth().estimate_error.north_m - 2.0).abs() < 0.05, "not believed");
    assert_ne!(flags(&rig) & 1024, 0, "and said so");
    let before = rig.truth().position.north_m;
    rig.run(1.0);
    assert!((rig.truth().estimate_error.north_m - 32.0).abs() < 0.1, "given in");
    rig.run(10.0);
    let flown_m = rig.truth().position.north_m - before;
    assert!((flown_m + 30.0).abs() < 1.0, "it flies off by as much: {flown_m}");
}

#[test]
fn a_second_receiver_tells_of_itself_and_takes_over() {
    let settings = SimSettings {
        second_gnss: true,
        ..quiet()
    };
    let mut rig = Rig::offboard(&settings, 10.0);
    let (first, second) = (Receiver::First, Receiver::Second);
    let east = Vector3::new(0.0, 20.0, 0.0);
    rig.vehicle.inflict(Fault::GnssOffset {
        receiver: second,
        offset_m: east,
    });
    rig.run(2.0);
    let place = |rig: &Rig| {
        let first = rig.last(|m| match m {
            MavMessage::GPS_RAW_INT(g) => Some(g.lon),
            _ => None,
        });
        let second = rig.last(|m| match m {
            MavMessage::GPS2_RAW(g) => Some(g.lon),
            _ => None,
        });
        (first.unwrap(), second.unwrap())
    };
    let (a, b) = place(&rig);
    let apart_m = f64::from(b - a) * 1e-7 * 111_320.0 * rig.truth().geodetic.latitude_deg.to_radians().cos();
    assert!((apart_m - 20.0).abs() < 0.2, "{apart_m}");
    assert!(rig.truth().estimate_error.norm() < 0.05, "the first one is followed");
    rig.vehicle.inflict(Fault::GnssOffset {
        receiver: second,
        offset_m: Vector3::zeros(),
    });
    rig.vehicle.inflict(Fault::GnssLost {
        receiver: first,
        lost: true,
    });
    rig.run(10.0);
    assert_eq!(rig.truth().mode, FlightMode::Offboard);
    assert!(rig.truth().estimate_error.norm() < 0.05);
    let healthy = rig.last(|m| match m {
        MavMessage::SYS_STATUS(s) => Some(s.onboard_control_sensors_health.bits() & 0x20 != 0),
        _ => None,
    });
    assert_eq!(healthy, Some(false));
}

#[test]
fn a_stuck_vehicle_is_carried_off_and_still_comes_down() {
    let settings = SimSettings {
        wind: crate::WindSettings {
            mean_north_m_s: 3.0,
            mean_east_m_s: 0.0,
            ..crate::WindSettings::CALM
        },
        ..quiet()
    };
    let mut rig = Rig::offboard(&settings, 10.0);
    rig.vehicle.inflict(Fault::Stuck(true));
    let (start, own) = (rig.truth().position, rig.own_position());
    rig.stream = Some(position(own + Vector3::new(-20.0, 0.0, -5.0)));
    rig.run(12.0);
    let t = rig.truth();
    assert_eq!(t.mode, FlightMode::Offboard);
    let drifted_m = t.position.north_m - start.north_m;
    assert!(
        (5.0..36.0).contains(&drifted_m),
        "with the wind, not against it: {drifted_m}"
    );
    assert!((t.height_m - 10.0).abs() < 0.6, "{}", t.height_m);
    rig.land();
    assert!(rig.run_until(40.0, |t| !t.armed).is_some());
}

#[test]
fn the_estimate_stops_while_the_vehicle_flies_on_and_silence_is_complete() {
    let mut rig = Rig::offboard(&quiet(), 10.0);
    rig.vehicle.inflict(Fault::EstimateStopped(true));
    rig.run(3.0);
    for id in [32, 33, 230, 331] {
        assert_eq!(rig.rate_hz(Onboard, id, 2.5), 0.0, "{id}");
    }
    assert!(rig.rate_hz(Onboard, 0, 2.5) > 0.5);
    assert_eq!(rig.truth().mode, FlightMode::Offboard);
    rig.vehicle.inflict(Fault::EstimateStopped(false));
    rig.vehicle.inflict(Fault::Silent(true));
    let before = rig.received.len();
    rig.run(3.0);
    assert_eq!(rig.received.len(), before);
    assert_eq!(
        rig.truth().mode,
        FlightMode::Return,
        "it has not heard any setpoint either"
    );
    rig.vehicle.inflict(Fault::Silent(false));
    rig.run(1.0);
    assert!(rig.received.len() > before);
}

#[test]
fn the_motors_stop_in_flight_and_it_falls() {
    let mut rig = Rig::flying(&quiet(), 20.0);
    let stop = |rig: &mut Rig, force: f32| rig.command(400, [0.0, force, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(stop(&mut rig, 0.0), Some(MavResult::MAV_RESULT_TEMPORARILY_REJECTED));
    assert_eq!(stop(&mut rig, 21_196.0), Some(MavResult::MAV_RESULT_ACCEPTED));
    rig.run(0.9);
    let t = rig.truth();
    assert!(!t.armed && !t.touches_ground);
    assert!((7.0..10.5).contains(&t.velocity.down_m_s), "{:?}", t.velocity);
    assert_eq!(t.landed, LandedState::OnGround, "disarmed counts as landed to PX4");
    let fell_s = rig.run_until(3.0, |t| t.touches_ground).expect("the ground") + 1.0;
    assert!((1.9..2.4).contains(&fell_s), "{fell_s}");
    assert!(rig.truth().touch_down_max_m_s > 16.0);
}

#[test]
fn battery_and_clock_do_as_they_are_told() {
    let mut rig = Rig::offboard(&quiet(), 10.0);
    rig.vehicle.inflict(Fault::BatteryCharge(0.5));
    rig.vehicle.inflict(Fault::BatteryDrain(10.0));
    rig.run(15.0);
    let charge = rig.truth().battery;
    assert!((charge - 0.4).abs() < 0.002, "a tenth of the 1500 s: {charge}");
    let stamp = |rig: &Rig| {
        rig.last(|m| match m {
            MavMessage::ATTITUDE(a) => Some(a.time_boot_ms),
            _ => None,
        })
    };
    let before = stamp(&rig).unwrap();
    rig.vehicle.inflict(Fault::ClockStep(7.5));
    rig.run(0.1);
    let step_ms = stamp(&rig).unwrap() - before;
    assert!((7_550..7_650).contains(&step_ms), "{step_ms}");
    rig.run(1.0);
    assert_eq!(rig.truth().mode, FlightMode::Offboard);
}

#[test]
fn the_wind_is_told_in_flight_and_where_the_air_moves_to() {
    let settings = SimSettings {
        wind: crate::WindSettings {
            mean_north_m_s: 4.0,
            mean_east_m_s: -2.0,
            ..crate::WindSettings::CALM
        },
        ..quiet()
    };
    let mut rig = Rig::ready(&settings);
    assert_eq!(
        rig.command(511, [231.0, 500_000.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Some(MavResult::MAV_RESULT_ACCEPTED)
    );
    rig.run(2.0);
    assert_eq!(rig.rate_hz(Onboard, 231, 2.0), 0.0, "nothing is known on the ground");
    rig.take_off(5.0);
    rig.run(45.0);
    let wind = rig.last(|m| match m {
        MavMessage::WIND_COV(w) => Some((w.wind_x, w.wind_y)),
        _ => None,
    });
    let (north, east) = wind.expect("the wind is told");
    assert!((north - 4.0).abs() < 0.4 && (east + 2.0).abs() < 0.4, "{north} {east}");
}
