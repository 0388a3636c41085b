//! What is known of how well a vehicle knows where it is, and what is noticed when that changes.

use crate::rig::Rig;
use nalgebra::Vector3;
use skein_domain::link::LinkEvent;
use skein_domain::{EstimatorHealth, FlightMode, GnssFix};
use skein_px4::LinkSettings;
use skein_sim::{Fault, Receiver, SimSettings};

fn lost(lost: bool) -> Fault {
    let receiver = Receiver::All;
    Fault::GnssLost { receiver, lost }
}

fn with_two_receivers() -> Rig {
    let sim = SimSettings {
        second_gnss: true,
        ..SimSettings::default()
    };
    Rig::with(LinkSettings::default(), sim)
}

#[test]
fn receivers_estimator_wind_and_battery_are_told() {
    let mut rig = with_two_receivers();
    rig.wind = Vector3::new(3.0, -1.0, 0.0);
    rig.take_off();
    rig.run(30.0);
    let (telemetry, _) = rig.read();
    let frame = telemetry.local_frame.unwrap();
    let here = frame.position(&rig.truth().geodetic);
    for (fix, place) in [
        (telemetry.gnss.fix, telemetry.gnss_place),
        (telemetry.gnss2.fix, telemetry.gnss2_place),
    ] {
        assert_eq!(fix, GnssFix::ThreeD);
        let apart = frame.position(&place.unwrap()).vector() - here.vector();
        assert!(apart.norm() < 0.5, "{apart:?}");
    }
    assert_eq!((telemetry.gnss_healthy, telemetry.gnss.satellites), (Some(true), 16));
    let health = telemetry.estimator.unwrap();
    assert!(
        health.is_position_good(true) && !health.has(EstimatorHealth::GNSS_GLITCH),
        "{health:?}"
    );
    let wind = telemetry.wind.unwrap();
    assert!(
        (wind.north_m_s - 3.0).abs() < 0.4 && (wind.east_m_s + 1.0).abs() < 0.3,
        "{wind:?}"
    );
    let used = telemetry.battery_use;
    let consumed_ah = (1.0 - rig.truth().battery as f32) * 5.0;
    assert!((used.consumed_ah.unwrap() - consumed_ah).abs() < 0.02, "{used:?}");
    assert!(used.remaining_s.unwrap() > 1000.0 && used.consumed_wh.is_none());
    let heard = telemetry.heard;
    for (what, time) in [
        ("local", heard.local),
        ("global", heard.global),
        ("attitude", heard.attitude),
        ("gnss", heard.gnss),
        ("gnss2", heard.gnss2),
        ("estimator", heard.estimator),
        ("wind", heard.wind),
        ("battery", heard.battery),
        ("system status", heard.system_status),
    ] {
        assert!(rig.now().seconds_since(time) < 2.2, "{what}: {time:?} of {}", rig.now_s);
    }
}

#[test]
fn one_receiver_is_told_from_none_that_disagrees() {
    let mut rig = Rig::new();
    rig.run(15.0);
    let (telemetry, _) = rig.read();
    assert_eq!((telemetry.gnss2_place, telemetry.heard.gnss2.0), (None, 0));
    assert_eq!(
        (telemetry.wind, telemetry.heard.wind.0),
        (None, 0),
        "it stands on the ground"
    );
}

#[test]
fn satellites_lost_are_seen_before_the_position_ends() {
    let mut rig = Rig::new();
    rig.take_off();
    rig.vehicle.inflict(lost(true));
    let lost_s = rig.now_s;
    rig.run_until("seen", 1.0, |rig| rig.read().0.gnss.fix == GnssFix::None);
    let (telemetry, _) = rig.read();
    assert_eq!(telemetry.gnss_place, None);
    assert!(telemetry.gnss.horizontal_accuracy_m.unwrap() > 50.0);
    assert!(
        rig.now().seconds_since(telemetry.heard.local) < 0.1,
        "the estimate goes on"
    );
    rig.run_until("failsafe", 8.0, |rig| rig.read().0.mode == FlightMode::Descend);
    assert!((5.0..6.5).contains(&(rig.now_s - lost_s)), "{}", rig.now_s - lost_s);
    rig.run(2.0);
    let (telemetry, health) = rig.read();
    assert!(health.connected && rig.now().seconds_since(telemetry.heard.local) > 1.5);
    assert!(!telemetry.estimator.unwrap().is_position_good(true));
    assert_eq!(telemetry.gnss_healthy, Some(false));
}

#[test]
fn receivers_that_disagree_can_be_told() {
    let mut rig = with_two_receivers();
    rig.take_off();
    rig.vehicle.inflict(Fault::GnssOffset {
        receiver: Receiver::Second,
        offset_m: Vector3::new(0.0, 25.0, 0.0),
    });
    rig.run(1.5);
    let (telemetry, _) = rig.read();
    let frame = telemetry.local_frame.unwrap();
    let [first, second] = [telemetry.gnss_place, telemetry.gnss2_place].map(|place| frame.position(&place.unwrap()));
    let apart_m = (second.vector() - first.vector()).norm();
    assert!((apart_m - 25.0).abs() < 0.5, "{apart_m}");
}

#[test]
fn a_stopped_estimate_is_stale_on_a_link_that_lives() {
    let mut rig = Rig::new();
    rig.take_off();
    rig.vehicle.inflict(Fault::EstimateStopped(true));
    rig.run(2.0);
    let (telemetry, health) = rig.read();
    let age_s = rig.now().seconds_since(telemetry.heard.local);
    assert!(health.connected && (1.9..2.1).contains(&age_s), "{age_s}");
    assert!(rig.now().seconds_since(telemetry.heard.attitude) < 0.3);
    assert!(rig.now().seconds_since(telemetry.position_time) > 1.9);
}

fn jumps(rig: &Rig) -> Vec<f64> {
    let jump = |(_, event): &(f64, LinkEvent)| match event {
        LinkEvent::ClockJumped { by_s } => Some(*by_s),
        _ => None,
    };
    rig.events.iter().filter_map(jump).collect()
}

#[test]
fn a_step_of_the_clock_is_told_and_positions_stay_fresh() {
    for step_s in [0.08, -0.3, 12.0, -1.8] {
        let mut rig = Rig::new();
        rig.take_off();
        rig.run(10.0);
        rig.vehicle.inflict(Fault::ClockStep(step_s));
        let stepped_s = rig.now_s;
        rig.run_until("told", 1.6, |rig| !jumps(rig).is_empty());
        assert!((jumps(&rig)[0] - step_s).abs() < 0.01, "{:?} for {step_s}", jumps(&rig));
        while rig.now_s < stepped_s + 6.0 {
            rig.run(0.1);
            let age_s = rig.now().seconds_since(rig.read().0.heard.local);
            assert!(age_s < 0.25, "{age_s} s old after a step by {step_s} s");
        }
        assert_eq!(jumps(&rig).len(), 1);
        assert!(!rig.has(&LinkEvent::Rebooted));
        assert_eq!(rig.truth().mode, FlightMode::Offboard);
        let (telemetry, _) = rig.read();
        let age_s = rig.now().seconds_since(telemetry.position_time);
        assert!((0.0..0.05).contains(&age_s), "{age_s} after {step_s}");
    }
}

#[test]
fn a_step_back_by_more_than_two_seconds_is_taken_for_a_restart() {
    let mut rig = Rig::new();
    rig.take_off();
    rig.vehicle.inflict(Fault::ClockStep(-4.0));
    rig.run(3.0);
    assert!(rig.has(&LinkEvent::Rebooted) && jumps(&rig).is_empty());
}
