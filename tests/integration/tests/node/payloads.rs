//! Payloads on a flying vehicle: they come up, are commanded, are ended and come back with their state, are attached, detached and given
//! up; and the simulator's truth agrees.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use serde_json::json;
use skein_config::{AdoptionRule, Escalation, Isolation, PayloadRule};
use skein_domain::{FlightState, PositionNed, Refusal, VehicleCommand, VehicleId};
use skein_runtime::{Fault, Targets};
use skein_sim::PayloadPlan;
use skein_testkit::{LONGEST_GAP_S, Swarm, example_library};
use skein_view::ActorStatus;
use skein_view::{FleetSnapshot, PayloadSnapshot, Restored};
use std::time::Duration;

const ONE: VehicleId = VehicleId(1);

fn rule(name: &str, isolation: Isolation, config: serde_json::Value) -> PayloadRule {
    PayloadRule {
        name: name.into(),
        plugin: name.into(),
        isolation,
        transport: None,
        on_failure: Escalation::Hold,
        config,
    }
}

/// One vehicle that carries what is given, in the given isolation.
async fn carrying(model: &str, isolation: Isolation) -> Swarm {
    let payloads = vec![
        rule("gimbal", isolation, json!({})),
        rule("camera", isolation, json!({ "source": "synthetic" })),
        rule("radio", isolation, json!({})),
    ];
    let adopt = AdoptionRule {
        model: model.into(),
        model_isolation: isolation,
        payloads,
        ..AdoptionRule::default()
    };
    Swarm::start_with(1, move |config, sim| {
        config.adopt = vec![adopt];
        sim.payloads = PayloadPlan::all();
    })
    .await
}

fn payload<'f>(fleet: &'f FleetSnapshot, name: &str) -> Option<&'f PayloadSnapshot> {
    fleet.vehicles.first()?.payloads.iter().find(|p| p.name == name)
}

fn state(fleet: &FleetSnapshot, name: &str, key: &str) -> serde_json::Value {
    payload(fleet, name)
        .and_then(|p| p.state.as_ref())
        .and_then(|s| s.get(key))
        .cloned()
        .unwrap_or_default()
}

async fn all_connected(swarm: &Swarm) {
    let connected = |fleet: &FleetSnapshot| {
        ["gimbal", "camera", "radio"]
            .iter()
            .all(|name| state(fleet, name, "connected") == json!(true))
    };
    swarm
        .until("all payloads heard", Duration::from_secs(10), connected)
        .await;
}

async fn works_in(isolation: Isolation) {
    let swarm = carrying("generic-uav", isolation).await;
    all_connected(&swarm).await;
    let node = swarm.node();

    let down = json!({ "command": "angles", "pitch_rad": -0.8, "yaw_rad": 0.3 });
    assert_eq!(node.command_payload(ONE, "gimbal", &down).await.refusal, None);
    let truth = || swarm.simulation().truth().vehicles[0].gimbal.unwrap();
    swarm
        .until("the gimbal where it was told", Duration::from_secs(10), |_| {
            (truth().pitch_rad + 0.8).abs() < 0.05 && (truth().yaw_vehicle_rad - 0.3).abs() < 0.05
        })
        .await;

    let wrong = json!({ "command": "angles", "pitch_rad": "down", "yaw_rad": 0.0 });
    let refusal = node.command_payload(ONE, "gimbal", &wrong).await.refusal;
    assert!(matches!(refusal, Some(Refusal::InvalidValue { .. })), "{refusal:?}");
    let refusal = node.command_payload(ONE, "laser", &down).await.refusal;
    assert!(matches!(refusal, Some(Refusal::UnknownPayload { .. })), "{refusal:?}");

    swarm
        .until("a frame of the camera", Duration::from_secs(10), |fleet| {
            payload(fleet, "camera").is_some_and(|p| p.frame.as_ref().is_some_and(|f| f.sequence > 2))
        })
        .await;
    let url = format!("http://{}/api/v1/vehicles/1/payloads/camera/frame", swarm.web_address());
    let picture = reqwest::get(url).await.unwrap();
    assert_eq!(picture.headers()["content-type"], "image/png");
    assert!(picture.bytes().await.unwrap().starts_with(b"\x89PNG"));
    where_it_looks(&swarm).await;
    swarm
        .until("the radio's figures", Duration::from_secs(10), |fleet| {
            state(fleet, "radio", "rssi_dbm").is_number()
        })
        .await;
    swarm.stop().await;
}

/// What the API says of where the camera looks is what the gimbal does in truth.
async fn where_it_looks(swarm: &Swarm) {
    let url = format!("http://{}/api/v1/cameras/views", swarm.web_address());
    // Pictures come a little behind what they show.
    let what = "the newest picture is of where the gimbal points";
    skein_testkit::eventually(skein_testkit::patience(), what, async || {
        let answer: serde_json::Value = reqwest::get(&url).await.unwrap().json().await.unwrap();
        let [view] = answer["views"].as_array().unwrap().as_slice() else {
            panic!("one camera, one view: {answer}");
        };
        assert_eq!(
            (&view["vehicle"], &view["payload"]),
            (&json!(1), &json!("camera")),
            "{view}"
        );
        assert_eq!(view["known_from"], json!("frame"), "{view}");
        assert!(view["pose"]["field_of_view_rad"].as_f64() > Some(0.1), "{view}");
        let pitch_rad = swarm.simulation().truth().vehicles[0].gimbal.unwrap().pitch_rad;
        ((view["pose"]["pitch_rad"].as_f64().unwrap() - pitch_rad).abs() < 0.1 && pitch_rad < -0.7).then_some(())
    })
    .await;
}

#[tokio::test(flavor = "multi_thread")]
async fn payloads_work_in_the_nodes_process() {
    works_in(Isolation::InProcess).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn payloads_work_in_child_processes() {
    works_in(Isolation::Child).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_ended_payload_comes_back_with_its_state() {
    for isolation in [Isolation::InProcess, Isolation::Child] {
        let swarm = carrying("generic-uav", isolation).await;
        all_connected(&swarm).await;
        let node = swarm.node();
        let down = json!({ "command": "angles", "pitch_rad": -0.6, "yaw_rad": 0.0 });
        assert_eq!(node.command_payload(ONE, "gimbal", &down).await.refusal, None);
        let told = |fleet: &FleetSnapshot| state(fleet, "gimbal", "wanted_pitch_rad");
        let before = swarm
            .until("the gimbal's aim", Duration::ZERO, |fleet| told(fleet).is_number())
            .await;
        let fault = Fault::PluginKill {
            vehicle: ONE,
            payload: Some("gimbal".into()),
        };
        node.inject_fault(fault).await.unwrap();
        let after = swarm
            .until("the gimbal's plugin back", Duration::ZERO, |fleet| {
                payload(fleet, "gimbal").is_some_and(|p| p.plugin.restarts == 1 && p.state.is_some())
            })
            .await;
        assert_eq!(told(&before), told(&after), "in {isolation:?}");
        let restart = node.restarts().pop().unwrap();
        assert_eq!(
            (restart.name.as_str(), restart.restored),
            ("payload-1-gimbal", Restored::Exactly)
        );
        swarm.stop().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_payload_that_fails_too_often_degrades_its_vehicle_and_stops_it_until_reset() {
    let swarm = carrying("generic-uav", Isolation::InProcess).await;
    swarm.take_off(6.0).await;
    let node = swarm.node();
    let far = VehicleCommand::GoTo {
        position: PositionNed::new(400.0, 0.0, -8.0),
        yaw_rad: None,
        speed_m_s: Some(3.0),
    };
    node.command(&Targets::All, far).await;
    let given_up =
        |fleet: &FleetSnapshot| payload(fleet, "radio").is_some_and(|p| p.plugin.status == ActorStatus::GivenUp);
    while !given_up(&node.snapshot()) {
        let fault = Fault::PluginPanic {
            vehicle: ONE,
            payload: Some("radio".into()),
        };
        node.inject_fault(fault).await.unwrap();
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let fleet = swarm
        .until("the vehicle holding, degraded", Duration::from_secs(5), |fleet| {
            fleet.vehicles[0].flight_state == FlightState::Holding && !fleet.vehicles[0].degraded.is_empty()
        })
        .await;
    assert!(
        payload(&fleet, "radio").unwrap().state.is_none(),
        "what it said is not true any more"
    );
    node.restart_plugin(ONE, Some("radio")).unwrap();
    swarm
        .until("the radio back after the reset", Duration::from_secs(10), |fleet| {
            fleet.vehicles[0].degraded.is_empty() && state(fleet, "radio", "connected") == json!(true)
        })
        .await;
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn payloads_are_attached_and_detached_in_flight() {
    let swarm = Swarm::start_with(3, |_, sim| sim.payloads = PayloadPlan::all()).await;
    swarm.take_off(5.0).await;
    let node = swarm.node();
    let gimbal = rule("gimbal", Isolation::Child, json!({}));
    node.attach_payload(ONE, gimbal.clone()).await.unwrap();
    swarm
        .until("the gimbal heard", Duration::from_secs(10), |fleet| {
            state(fleet, "gimbal", "connected") == json!(true)
        })
        .await;
    assert!(
        node.attach_payload(ONE, gimbal).await.is_err(),
        "there is one of that name"
    );
    let wrong = rule("camera", Isolation::InProcess, json!({ "source": "crystal ball" }));
    let refusal = node.attach_payload(ONE, wrong).await.unwrap_err();
    assert!(refusal.to_string().contains("config"), "{refusal}");
    node.detach_payload(ONE, "gimbal".into()).await.unwrap();
    // The first of its kind in the node's own process loads a library there.
    let camera = rule("camera", Isolation::InProcess, json!({ "source": "synthetic" }));
    node.attach_payload(ONE, camera).await.unwrap();
    node.detach_payload(ONE, "camera".into()).await.unwrap();
    swarm
        .until("the gimbal gone", Duration::ZERO, |fleet| {
            fleet.vehicles[0].payloads.is_empty()
        })
        .await;
    // Nobody went without setpoints for it, neither its own vehicle nor another one.
    for vehicle in &swarm.truth_now().await.vehicles {
        let gap_s = vehicle.offboard_gap_sender_max_s;
        assert!(gap_s < LONGEST_GAP_S, "{gap_s:.3} s without a setpoint");
    }
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_detector_sees_every_frame_its_camera_gives_wherever_each_of_them_runs() {
    let plugins = tempfile::tempdir().unwrap();
    let library = example_library("fixture-frame-counter", "frame_counter");
    std::fs::copy(library, plugins.path().join("libframe_counter.so")).unwrap();
    for (camera, detector) in [
        (Isolation::InProcess, Isolation::InProcess),
        (Isolation::InProcess, Isolation::Child),
        (Isolation::Child, Isolation::Child),
    ] {
        let directory = plugins.path().to_owned();
        let swarm = Swarm::start_with(1, move |config, sim| {
            config.plugins.directories.push(directory);
            config.adopt[0].payloads = vec![
                rule("camera", camera, json!({ "source": "synthetic" })),
                rule("frame-counter", detector, json!({})),
            ];
            sim.payloads = PayloadPlan::all();
        })
        .await;
        let seen = |fleet: &FleetSnapshot, key: &str| state(fleet, "frame-counter", key).as_f64().unwrap_or(0.0);
        let fleet = swarm
            .until("the detector's tenth frame", Duration::from_secs(20), |fleet| {
                seen(fleet, "frames") >= 10.0
            })
            .await;
        assert_eq!(seen(&fleet, "missing"), 0.0, "{camera:?} to {detector:?}");
        // Sky and grass: neither a buffer of zeros nor one of noise.
        assert!(
            (40.0..220.0).contains(&seen(&fleet, "mean")),
            "{}",
            seen(&fleet, "mean")
        );
        swarm.stop().await;
    }
}
