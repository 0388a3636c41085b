//! The telemetry radio of a simulated vehicle, and the Wi-Fi of the computer the tests run on.

use crate::Radio;
use payload_mavlink::rig::{Rig, quiet};
use serde_json::json;
use skein_domain::{PositionNed, Refusal};
use skein_sim::{PayloadPlan, RadioSettings};
use std::time::{Duration, Instant};

fn rig(config: &str) -> Rig<Radio> {
    let plan = PayloadPlan {
        radio: Some(RadioSettings::default()),
        ..PayloadPlan::default()
    };
    let mut rig = Rig::new(&quiet(plan), config, PositionNed::new(300.0, -400.0, 0.0), 0.0);
    rig.home = PositionNed::default();
    rig
}

#[test]
fn its_figures_are_those_of_the_radio() {
    let mut rig = rig("{}");
    rig.run(20.0);
    let state = rig.state();
    let truth = rig.vehicle.truth().radio.expect("it carries a radio");
    assert_eq!(
        (&state["connected"], &state["source"]),
        (&json!(true), &json!("radio_status")),
        "{state}"
    );
    // The scale has steps of half a decibel, and the shadow wanders on.
    assert!(
        (state["rssi_dbm"].as_f64().unwrap() - truth.signal_dbm).abs() < 1.5,
        "{state} {truth:?}"
    );
    // The report is the ground station's radio's: its end has the more noise, and is the weaker one.
    let noise = RadioSettings::default().ground_noise_dbm;
    assert!((state["noise_dbm"].as_f64().unwrap() - noise).abs() < 0.5, "{state}");
    let snr = state["rssi_dbm"].as_f64().unwrap() - noise;
    assert!((state["snr_db"].as_f64().unwrap() - snr).abs() < 0.5, "{state}");
    assert_eq!(state["distance_m"], 500.0);
    assert!(state["range_m"].as_f64().unwrap() > 500.0, "{state}");
    assert_eq!(state["warning"], false);
    rig.replay();
    rig.mute = true;
    rig.run(7.0);
    let state = rig.state();
    assert_eq!(
        (&state["connected"], &state["rssi_dbm"]),
        (&json!(false), &json!(null)),
        "{state}"
    );
}

#[test]
fn a_telemetry_radio_cannot_be_set_from_here() {
    let mut rig = rig("{}");
    for command in [
        json!({"command": "set_channel", "channel": 3}),
        json!({"command": "set_power", "power_dbm": 20.0}),
    ] {
        let id = rig.command(&command.to_string());
        assert!(
            matches!(rig.ended(id), Some(Err(Refusal::NotSupported { .. }))),
            "{command}"
        );
    }
}

/// A name no interface has: whatever this computer has, the plugin must say that this is not there.
#[test]
fn a_wifi_interface_that_is_not_there_is_a_fault() {
    let mut rig = rig(r#"{"source": "nl80211", "interface": "none-such"}"#);
    let begun = Instant::now();
    while rig.state()["fault"].as_str().is_none_or(str::is_empty) {
        assert!(begun.elapsed() < Duration::from_secs(20), "{}", rig.state());
        rig.run(0.2);
        std::thread::yield_now();
    }
    assert_eq!(rig.state()["connected"], false);
    let id = rig.command(r#"{"command": "set_channel", "channel": 6}"#);
    assert_eq!(rig.ended(id), None);
    while rig.ended(id).is_none() {
        assert!(begun.elapsed() < Duration::from_secs(20), "{}", rig.state());
        rig.run(0.2);
        std::thread::yield_now();
    }
    assert!(
        matches!(rig.ended(id), Some(Err(Refusal::NotSupported { .. }))),
        "{:?}",
        rig.ended(id)
    );
    let id = rig.command(r#"{"command": "set_channel", "channel": 15}"#);
    assert!(matches!(rig.ended(id), Some(Err(Refusal::InvalidValue { .. }))));
    let id = rig.command(r#"{"command": "set_power", "power_dbm": 90.0}"#);
    assert!(matches!(rig.ended(id), Some(Err(Refusal::InvalidValue { .. }))));
}

#[test]
fn what_an_instance_had_begun_ends_with_it() {
    let mut rig = rig(r#"{"source": "nl80211", "interface": "none-such"}"#);
    let id = rig.command(r#"{"command": "set_channel", "channel": 6}"#);
    rig.restart();
    rig.run(0.5);
    assert!(
        matches!(rig.ended(id), Some(Err(Refusal::NotRunning { .. }))),
        "{:?}",
        rig.ended(id)
    );
}
