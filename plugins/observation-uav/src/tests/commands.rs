//! Which commands are taken, how they end, and what ends an observation.

use super::rig::{Rig, THE_TRACK, THE_VEHICLE};
use skein_plugin_sdk::domain::exchange::CommandProgress;
use skein_plugin_sdk::domain::payload::Target;
use skein_plugin_sdk::domain::{FlightState, PositionNed, Refusal, VehicleCommand, VehicleId};

fn place(north_m: f64, east_m: f64) -> Target {
    Target::Place {
        position: PositionNed::new(north_m, east_m, 0.0),
    }
}

#[test]
fn a_place_is_observed_from_the_nearest_point_of_the_circle_at_the_present_height() {
    let mut rig = Rig::new(crate::Settings::default());
    let id = rig.observe(place(60.0, 0.0), None, None);
    rig.run_until("on station", 60.0, |rig| rig.is_done(id));
    rig.run(5.0);
    assert!((rig.position.x - 45.0).abs() < 0.5, "{:?}", rig.position);
    assert!(rig.position.y.abs() < 0.5);
    assert!((rig.position.z + 20.0).abs() < 0.3);
    let report = rig.report();
    assert_eq!(report["activity"], "observing");
    assert_eq!(report["in_view"], true);
    assert_eq!(report["stand_off_m"], 15.0);
    assert_eq!(report["gimbal"], "gimbal");
    assert_eq!(rig.progress(id), [CommandProgress::Executing, CommandProgress::Done]);
}

#[test]
fn a_side_that_is_asked_for_is_flown_to_around_the_target() {
    let mut rig = Rig::new(crate::Settings::default());
    let id = rig.command(VehicleCommand::Observe {
        target: place(60.0, 0.0),
        stand_off_m: Some(20.0),
        height_m: None,
        // From the north, the far side.
        bearing_rad: Some(0.0),
    });
    let mut nearest_m = f64::INFINITY;
    rig.run_until("on station", 90.0, |rig| {
        nearest_m = nearest_m.min((rig.position.x - 60.0).hypot(rig.position.y));
        rig.is_done(id)
    });
    assert!(nearest_m > 14.0, "{nearest_m:.1} m from the target on the way");
    rig.run(5.0);
    assert!(
        (rig.position.x - 80.0).abs() < 1.0 && rig.position.y.abs() < 1.0,
        "{:?}",
        rig.position
    );
    let nowhere = rig.command(VehicleCommand::Observe {
        target: place(60.0, 0.0),
        stand_off_m: None,
        height_m: None,
        bearing_rad: Some(f64::NAN),
    });
    rig.tick();
    assert!(matches!(rig.refusal(nowhere), Some(Refusal::InvalidValue { .. })));
}

#[test]
fn what_is_not_there_is_refused_with_its_reason() {
    let mut rig = Rig::new(crate::Settings::default());
    let track = rig.observe(THE_TRACK, None, None);
    let vehicle = rig.observe(THE_VEHICLE, None, None);
    let itself = rig.observe(Target::Vehicle { vehicle: VehicleId(7) }, None, None);
    let nowhere = rig.observe(place(f64::NAN, 0.0), None, None);
    let near = rig.observe(place(10.0, 0.0), Some(1.0), None);
    let high = rig.observe(place(10.0, 0.0), None, Some(f64::INFINITY));
    let look = rig.command(VehicleCommand::LookAt { target: THE_TRACK });
    rig.tick();
    assert_eq!(rig.refusal(track), Some(Refusal::UnknownTrack { track: 5 }));
    assert_eq!(
        rig.refusal(vehicle),
        Some(Refusal::UnknownVehicle { vehicle: VehicleId(2) })
    );
    assert_eq!(rig.refusal(look), Some(Refusal::UnknownTrack { track: 5 }));
    for id in [itself, nowhere, near, high] {
        assert!(matches!(rig.refusal(id), Some(Refusal::InvalidValue { .. })), "{id}");
    }
    assert_eq!(rig.state, FlightState::Holding);
}

#[test]
fn a_target_that_vanishes_ends_the_observation_in_a_hold() {
    let mut rig = Rig::with_track(40.0, 10.0);
    let id = rig.observe(THE_TRACK, None, None);
    rig.run(2.0);
    assert_eq!(rig.state, FlightState::GoingTo);
    rig.track = None;
    let gone_s = rig.now.as_seconds();
    rig.run_until("holding", 10.0, |rig| rig.state == FlightState::Holding);
    let after_s = rig.now.as_seconds() - gone_s;
    assert!((3.0..3.2).contains(&after_s), "after {after_s:.2} s");
    assert_eq!(rig.refusal(id), Some(Refusal::UnknownTrack { track: 5 }));
    assert!(rig.notices().iter().any(|text| text.contains("track 5 is gone")));
    rig.run(5.0);
    assert!(rig.velocity.norm() < 0.1);
    assert_eq!(rig.report()["activity"], "none");
    assert_eq!(rig.asked("gimbal").last().map(String::as_str), Some("neutral"));
    rig.assert_smooth_since(gone_s);
}

#[test]
fn a_short_gap_in_the_track_is_flown_through() {
    let mut rig = Rig::with_track(40.0, 10.0);
    rig.track.as_mut().expect("is there").velocity.x = 2.0;
    let id = rig.observe(THE_TRACK, None, None);
    rig.run_until("on station", 60.0, |rig| rig.is_done(id));
    rig.run(3.0);
    let hidden = rig.track.take();
    rig.run(1.5);
    let mut back = hidden.expect("was there");
    back.position += back.velocity * 1.5;
    rig.track = Some(back);
    rig.run(1.0);
    assert_eq!(rig.report()["activity"], "observing");
    assert!((rig.distance_m(back) - 15.0).abs() < 2.5);
}

#[test]
fn any_other_flight_ends_it() {
    let commands = [
        VehicleCommand::Hold,
        VehicleCommand::GoTo {
            position: PositionNed::new(0.0, 0.0, -10.0),
            yaw_rad: None,
            speed_m_s: None,
        },
        VehicleCommand::Land,
        VehicleCommand::Return,
        VehicleCommand::StopObserving,
    ];
    for command in commands {
        let mut rig = Rig::with_track(40.0, 10.0);
        let observing = rig.observe(THE_TRACK, None, None);
        rig.run(1.0);
        let id = rig.command(command);
        rig.run(2.0);
        let name = command.name();
        assert_eq!(rig.refusal(observing), Some(Refusal::Superseded), "{name}");
        assert_eq!(rig.progress(id).first(), Some(&CommandProgress::Executing), "{name}");
        assert_eq!(rig.report()["activity"], "none", "{name}");
        assert_eq!(
            rig.asked("gimbal").last().map(String::as_str),
            Some("neutral"),
            "{name}"
        );
    }
}

#[test]
fn another_observation_takes_its_place() {
    let mut rig = Rig::with_track(40.0, 10.0);
    let first = rig.observe(THE_TRACK, None, None);
    rig.run(1.0);
    let second = rig.observe(place(-40.0, 0.0), Some(10.0), None);
    rig.run_until("on station", 60.0, |rig| rig.is_done(second));
    assert_eq!(rig.refusal(first), Some(Refusal::Superseded));
    assert_eq!(rig.report()["target"]["kind"], "place");
}

#[test]
fn a_region_is_looked_at_while_the_vehicle_does_something_else() {
    let mut rig = Rig::new(crate::Settings::default());
    let id = rig.command(VehicleCommand::LookAt {
        target: place(30.0, 30.0),
    });
    rig.run(3.0);
    assert_eq!(rig.progress(id), [CommandProgress::Executing, CommandProgress::Done]);
    assert_eq!(rig.state, FlightState::Holding);
    assert_eq!(rig.report()["activity"], "looking");
    assert_eq!(rig.report()["in_view"], true);
    let position = PositionNed::new(0.0, 40.0, -20.0);
    let go = rig.command(VehicleCommand::GoTo {
        position,
        yaw_rad: None,
        speed_m_s: None,
    });
    rig.run_until("there", 60.0, |rig| rig.is_done(go));
    assert_eq!(rig.report()["activity"], "looking");
    assert_eq!(rig.report()["in_view"], true);
    let stop = rig.command(VehicleCommand::StopObserving);
    rig.run(1.0);
    assert!(rig.is_done(stop));
    assert_eq!(rig.report()["activity"], "none");
}

#[test]
fn looking_at_something_needs_a_gimbal_or_a_nose() {
    let mut rig = Rig::new(crate::Settings::default());
    rig.origin = None;
    rig.tick();
    let blind = rig.command(VehicleCommand::LookAt {
        target: place(30.0, 0.0),
    });
    rig.run(0.1);
    assert_eq!(rig.refusal(blind), Some(Refusal::NoSwarmFrame));
    rig.gimbal = None;
    rig.inbox.push(super::coordination::gone(
        "gimbal",
        skein_plugin_sdk::domain::payload::PayloadKind::Gimbal,
    ));
    let by_nose = rig.command(VehicleCommand::LookAt {
        target: place(0.0, 30.0),
    });
    rig.run(4.0);
    assert!(rig.is_done(by_nose));
    assert!(
        (rig.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 0.05,
        "{}",
        rig.yaw_rad
    );
}

#[test]
fn a_gimbal_that_refuses_has_the_command_refused() {
    let mut rig = Rig::new(crate::Settings::default());
    let refusal = Refusal::NotSupported {
        detail: "it is stuck".to_owned(),
    };
    rig.gimbal.as_mut().expect("is there").refuses = Some(refusal.clone());
    let id = rig.command(VehicleCommand::LookAt {
        target: place(30.0, 0.0),
    });
    rig.run(1.0);
    assert_eq!(rig.refusal(id), Some(refusal));
    assert_eq!(rig.report()["activity"], "none");
}

#[test]
fn the_same_command_twice_is_one() {
    let mut rig = Rig::with_track(40.0, 10.0);
    let id = rig.observe(THE_TRACK, None, None);
    let again = rig.inbox.last().cloned().expect("is there");
    rig.inbox.push(again.clone());
    rig.run(1.0);
    rig.inbox.push(again);
    rig.run_until("on station", 60.0, |rig| rig.is_done(id));
    assert_eq!(rig.progress(id), [CommandProgress::Executing, CommandProgress::Done]);
}
