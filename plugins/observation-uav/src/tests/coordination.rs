//! Gimbal, camera and radio work together with the flight.

use super::rig::{Rig, THE_TRACK};
use crate::{OnObserving, OnRadioWarning, Settings};
use nalgebra::Vector3;
use skein_plugin_sdk::domain::exchange::{Event, PayloadReport};
use skein_plugin_sdk::domain::payload::{CameraState, CameraStream, GimbalCommand, PayloadKind, RadioState};
use skein_plugin_sdk::domain::{FlightState, SwarmFrame, VehicleCommand};

/// A payload is not running any more.
pub fn gone(name: &str, kind: PayloadKind) -> Event {
    Event::Payload(PayloadReport {
        name: name.to_owned(),
        kind,
        state_json: None,
    })
}

fn rig_with(settings: Settings) -> Rig {
    let mut rig = Rig::new(settings);
    rig.track = Some(super::rig::Mover {
        position: Vector3::new(30.0, 0.0, 0.0),
        velocity: Vector3::zeros(),
    });
    rig.camera = Some(CameraState {
        connected: true,
        ..CameraState::default()
    });
    rig.tick();
    rig
}

#[test]
fn the_gimbal_is_told_the_place_on_earth() {
    let mut rig = rig_with(Settings::default());
    rig.observe(THE_TRACK, None, None);
    rig.run(1.0);
    let told = &rig.gimbal.as_ref().expect("is there").told;
    let Some((_, GimbalCommand::PointAt { place })) = told.first() else {
        panic!("{told:?}")
    };
    let position = SwarmFrame::new(super::rig::ORIGIN).position(place);
    assert!(
        (position.vector() - Vector3::new(30.0, 0.0, 0.0)).norm() < 0.01,
        "{position:?}"
    );
    rig.run(60.0);
    let told = rig.gimbal.as_ref().expect("is there").told.len();
    assert_eq!(told, 1, "a target that stands is told once");
}

#[test]
fn a_gimbal_that_was_turned_away_or_restarted_is_told_again() {
    let mut rig = rig_with(Settings::default());
    rig.observe(THE_TRACK, None, None);
    rig.run(4.0);
    let gimbal = rig.gimbal.as_mut().expect("is there");
    gimbal.state.mode = Default::default();
    gimbal.state.place = None;
    rig.run(3.0);
    let gimbal = rig.gimbal.as_ref().expect("is there");
    assert_eq!(gimbal.told.len(), 2);
    assert!(gimbal.state.place.is_some());
}

#[test]
fn the_camera_does_what_is_configured_while_on_station() {
    for (camera, begin, end) in [
        (OnObserving::Record, "start_recording", "stop_recording"),
        (OnObserving::Pictures, "take_pictures", "stop_pictures"),
    ] {
        let mut rig = rig_with(Settings {
            camera,
            stream: true,
            ..Settings::default()
        });
        let id = rig.observe(THE_TRACK, None, None);
        rig.run(0.2);
        assert!(rig.asked("eye").is_empty(), "not on the way");
        rig.run_until("on station", 60.0, |rig| rig.is_done(id));
        rig.run(2.0);
        assert_eq!(rig.asked("eye"), [begin, "start_stream"]);
        rig.command(VehicleCommand::StopObserving);
        rig.run(1.0);
        assert_eq!(rig.asked("eye"), [begin, "start_stream", end, "stop_stream"]);
    }
}

#[test]
fn what_ran_already_is_not_ended() {
    let mut rig = rig_with(Settings {
        camera: OnObserving::Record,
        stream: true,
        ..Settings::default()
    });
    let stream = CameraStream {
        stream: 1,
        running: true,
        ..CameraStream::default()
    };
    rig.camera = Some(CameraState {
        connected: true,
        recording: true,
        streams: vec![stream],
        ..CameraState::default()
    });
    let id = rig.observe(THE_TRACK, None, None);
    rig.run_until("on station", 60.0, |rig| rig.is_done(id));
    rig.run(1.0);
    rig.command(VehicleCommand::Hold);
    rig.run(1.0);
    assert!(rig.asked("eye").is_empty(), "{:?}", rig.asked("eye"));
}

#[test]
fn the_radios_warning_is_told_once_and_heeded_as_configured() {
    let cases = [
        (OnRadioWarning::Tell, FlightState::GoingTo),
        (OnRadioWarning::Hold, FlightState::Holding),
        (OnRadioWarning::Return, FlightState::Returning),
    ];
    for (on_radio_warning, expected) in cases {
        let mut rig = rig_with(Settings {
            on_radio_warning,
            ..Settings::default()
        });
        let id = rig.observe(THE_TRACK, None, None);
        rig.run_until("on station", 60.0, |rig| rig.is_done(id));
        rig.radio = Some(RadioState {
            connected: true,
            out_of_range_in_s: Some(20.0),
            warning: true,
            ..RadioState::default()
        });
        rig.run(1.0);
        assert_eq!(rig.state, expected, "{on_radio_warning:?}");
        let told = rig
            .notices()
            .iter()
            .filter(|text| text.contains("wifi: about to leave its range in 20 s"))
            .count();
        assert_eq!(told, 1, "{on_radio_warning:?}");
        assert_eq!(rig.report()["radio_warning"], true);
    }
}

#[test]
fn a_gimbal_with_a_vocabulary_of_its_own_is_left_alone() {
    let mut rig = rig_with(Settings::default());
    rig.gimbal = None;
    rig.inbox.push(Event::Payload(PayloadReport {
        name: "gimbal".to_owned(),
        kind: PayloadKind::Gimbal,
        state_json: Some(r#"{"lamp": "on"}"#.to_owned()),
    }));
    let id = rig.observe(THE_TRACK, None, None);
    rig.run_until("on station", 60.0, |rig| rig.is_done(id));
    assert!(rig.asked("gimbal").is_empty());
}
