//! A track is kept in view from two sides by the vehicles that are best placed, and who is lost is relieved from beside its place.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use serde_json::{Value, json};
use skein_config::{AdoptionRule, Escalation, Isolation, PayloadRule};
use skein_domain::payload::Track;
use skein_domain::{PositionNed, VehicleId, VelocityNed};
use skein_runtime::NodeHandle;
use skein_sim::PayloadPlan;
use skein_testkit::{Swarm, eventually, patience};
use skein_view::{FleetSnapshot, VehicleSnapshot};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::time::Duration;
use tokio::task::JoinHandle;

const NUMBER: u64 = 4;
const PLACE: PositionNed = PositionNed::new(45.0, 5.0, -4.0);
const STAND_OFF_M: f64 = 15.0;
/// On the way to its side and there.
const FLOWN_WITHIN: Duration = Duration::from_secs(60);

async fn observers() -> Swarm {
    let rule = |name: &str| PayloadRule {
        name: name.into(),
        plugin: name.into(),
        isolation: Isolation::InProcess,
        transport: None,
        on_failure: Escalation::Hold,
        config: json!({}),
    };
    let adopt = AdoptionRule {
        model: "observation-uav".into(),
        payloads: vec![rule("gimbal")],
        ..AdoptionRule::default()
    };
    Swarm::start_with(3, move |config, sim| {
        config.swarm.origin = Some(sim.origin);
        config.adopt = vec![adopt];
        sim.payloads = PayloadPlan::all();
    })
    .await
}

/// Somebody who tells of the track until this is dropped.
struct Teller(JoinHandle<()>);

impl Teller {
    fn of(node: NodeHandle) -> Self {
        Self(tokio::spawn(async move {
            let mut every = tokio::time::interval(Duration::from_millis(100));
            loop {
                every.tick().await;
                let track = Track {
                    track: NUMBER,
                    position: PLACE,
                    velocity: VelocityNed::default(),
                    time: node.now(),
                    error_m: None,
                };
                node.set_tracks(vec![track]).unwrap();
            }
        }))
    }
}

impl Drop for Teller {
    fn drop(&mut self) {
        self.0.abort();
    }
}

async fn send(swarm: &Swarm, path: &str, body: Option<Value>) -> Value {
    let url = format!("http://{}/api/v1/tracks/{NUMBER}/{path}", swarm.web_address());
    let client = reqwest::Client::new();
    let request = match body {
        Some(body) => client.post(url).json(&body),
        None => client.get(url),
    };
    let answer = request.send().await.unwrap();
    assert_eq!(answer.status().as_u16(), 200);
    serde_json::from_str(&answer.text().await.unwrap()).unwrap()
}

/// Whether it says that it stands where it observes the track from.
fn observes(vehicle: &VehicleSnapshot) -> bool {
    let state = vehicle.model_state.clone().unwrap_or_default();
    state["activity"] == "observing" && state["target"]["track"] == NUMBER
}

fn bearing_rad(vehicle: &VehicleSnapshot) -> f64 {
    let way = vehicle.kinematics.unwrap().position.vector() - PLACE.vector();
    way.y.atan2(way.x)
}

/// The smaller angle between two bearings.
fn between(a: f64, b: f64) -> f64 {
    let off = (a - b).rem_euclid(TAU);
    off.min(TAU - off)
}

fn of(fleet: &FleetSnapshot, id: VehicleId) -> &VehicleSnapshot {
    fleet.vehicles.iter().find(|vehicle| vehicle.id == id).unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_track_is_kept_in_view_from_two_sides_though_one_vehicle_is_lost() {
    let swarm = observers().await;
    swarm.take_off(10.0).await;
    let _teller = Teller::of(swarm.node());
    let list = eventually(patience(), "the track", async || {
        swarm.node().observers_of(NUMBER).ok().map(|list| list.len())
    })
    .await;
    assert_eq!(list, 3);
    let proposals = send(&swarm, "observers", None).await;
    assert_eq!(proposals["observers"][0]["unfit"], Value::Null, "{proposals}");

    let answer = send(&swarm, "observe", Some(json!({ "stand_off_m": STAND_OFF_M }))).await;
    let asked: Vec<(VehicleId, f64)> = answer["asked"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| {
            assert_eq!(one["receipt"]["refusal"], Value::Null, "{answer}");
            let id = one["receipt"]["vehicle"].as_u64().unwrap();
            (VehicleId(id as u16), one["bearing_rad"].as_f64().unwrap())
        })
        .collect();
    assert_eq!(asked.len(), 2);
    assert!((between(asked[0].1, asked[1].1) - FRAC_PI_2).abs() < 1e-9);
    let on_station = |fleet: &FleetSnapshot| {
        let there = |(id, bearing): &(VehicleId, f64)| {
            let vehicle = of(fleet, *id);
            observes(vehicle) && between(bearing_rad(vehicle), *bearing) < 0.2
        };
        asked.iter().all(there)
    };
    swarm.until("both on their sides", FLOWN_WITHIN, on_station).await;

    let (lost, side) = asked[0];
    let relief = (1..=3)
        .map(VehicleId)
        .find(|id| asked.iter().all(|(by, _)| by != id))
        .unwrap();
    swarm.simulation().kill(lost.0 as u8).unwrap();
    let relieved = |fleet: &FleetSnapshot| {
        let vehicle = of(fleet, relief);
        observes(vehicle) && between(bearing_rad(vehicle), side) < 0.7
    };
    swarm
        .until("the third beside the place of the lost one", FLOWN_WITHIN, relieved)
        .await;
    let told = swarm.node().events_after(0);
    let text = format!("vehicle {relief} takes over");
    assert!(
        told.iter().any(|event| event.text.contains(&text)),
        "nobody says that {text}"
    );
    swarm.stop().await;
}
