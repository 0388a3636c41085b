//! A red item of the preflight report keeps from arming until a permitted operator takes it upon himself, and that stands on record.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use serde_json::{Value, json};
use skein_config::OperatorSettings;
use skein_domain::{FlightState, ItemStatus, PreflightItem, Refusal, VehicleCommand, VehicleId};
use skein_runtime::Targets;
use skein_testkit::Swarm;
use skein_view::EventKind;
use std::time::Duration;

const ITEM: &str = "gnss_satellites";
const UP: VehicleCommand = VehicleCommand::TakeOff { height_m: 6.0 };

fn operator(name: &str, sha256: &str, may_override_preflight: bool) -> OperatorSettings {
    OperatorSettings {
        name: name.into(),
        token_sha256: sha256.into(),
        may_override_preflight,
        may_upgrade: false,
    }
}

/// More satellites are asked for than there are: red on every vehicle, and nothing else.
async fn start() -> Swarm {
    Swarm::start_with(2, |config, sim| {
        sim.spacing_m = 8.0;
        config.safety.preflight.min_satellites = 60;
        config.operators = vec![
            // Of "password".
            operator(
                "anna",
                "5e884898da28047151d0e56f8dc6292773603d0d6aabbdd62a11ef721d1542d8",
                true,
            ),
            // Of "secret".
            operator(
                "bert",
                "2bb80d537b1da3e38bd30361aa855686bde0eacd7162fef6a25fe97bf527a25b",
                false,
            ),
        ];
    })
    .await
}

/// The items that keep a vehicle from being armed.
fn red(swarm: &Swarm, vehicle: u16) -> Vec<PreflightItem> {
    let report = swarm.node().preflight();
    let of = report.vehicles.iter().find(|r| r.vehicle == Some(VehicleId(vehicle)));
    of.map_or_else(Vec::new, |r| r.blocking().cloned().collect())
}

async fn take_off(swarm: &Swarm, vehicle: u16) -> Option<Refusal> {
    let one = Targets::Vehicles(vec![VehicleId(vehicle)]);
    swarm.node().command(&one, UP).await[0].refusal.clone()
}

async fn overriding(swarm: &Swarm, secret: Option<&str>) -> (u16, Value) {
    let url = format!("http://{}/api/v1/preflight/overrides", swarm.web_address());
    let body = json!({ "vehicle": 1, "items": [ITEM], "reason": "an indoor test", "valid_s": 300.0 });
    let mut request = reqwest::Client::new().post(url).json(&body);
    if let Some(secret) = secret {
        request = request.header("authorization", format!("Bearer {secret}"));
    }
    let answer = request.send().await.unwrap();
    (answer.status().as_u16(), answer.json().await.unwrap())
}

fn recorded(swarm: &Swarm) -> Vec<(Option<VehicleId>, String)> {
    let events = swarm.node().events_after(0);
    let of = events.iter().filter(|e| matches!(e.kind, EventKind::Preflight));
    of.map(|e| (e.vehicle, e.text.clone())).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn only_a_permitted_operator_has_a_vehicle_armed_in_spite_of_a_red_item() {
    let swarm = start().await;
    swarm
        .until("nothing but the satellites is red", Duration::ZERO, |fleet| {
            let ready = fleet.vehicles.iter().filter(|v| v.ready_to_arm == Some(true)).count() == 2;
            let only = |id| matches!(red(&swarm, id).as_slice(), [item] if item.id == ITEM);
            let swarm_is_good = swarm.node().preflight().swarm.blocking().next().is_none();
            ready && only(1) && only(2) && swarm_is_good
        })
        .await;
    assert!(red(&swarm, 1)[0].may_be_overridden, "the report says that it may be");
    let refused = Some(Refusal::Preflight {
        items: vec![ITEM.into()],
    });
    assert_eq!(take_off(&swarm, 1).await, refused);

    // Not by nobody, not by one who may not.
    assert_eq!(overriding(&swarm, None).await.0, 401);
    let (status, not_permitted) = overriding(&swarm, Some("secret")).await;
    assert_eq!(
        (status, not_permitted["error"]["code"].as_str()),
        (403, Some("not_permitted"))
    );
    assert_eq!(take_off(&swarm, 1).await, refused, "nothing was overridden");
    assert_eq!(recorded(&swarm), []);

    let (status, given) = overriding(&swarm, Some("password")).await;
    assert_eq!((status, given["operator"].as_str()), (200, Some("anna")), "{given}");
    assert_eq!(take_off(&swarm, 1).await, None, "it is armed now");
    assert_eq!(take_off(&swarm, 2).await, refused, "the other was not spoken of");
    swarm
        .until("it flies", Duration::from_secs(30), |fleet| {
            fleet.vehicles[0].flight_state == FlightState::Holding
        })
        .await;
    assert!(!swarm.truth_now().await.vehicle(1).unwrap().touches_ground);
    on_record(&swarm);
    in_flight_nothing_is_asked_of_the_ground(&swarm);
    swarm.stop().await;
}

/// Who, why, which item, for which vehicle: when it was given, and when it was made use of.
fn on_record(swarm: &Swarm) {
    let recorded = recorded(swarm);
    let told = |says: &str| {
        let fits = |(vehicle, text): &&(Option<VehicleId>, String)| {
            *vehicle == Some(VehicleId(1))
                && [says, ITEM, "anna", "an indoor test"]
                    .iter()
                    .all(|part| text.contains(part))
        };
        recorded.iter().any(|e| fits(&e))
    };
    assert!(told("overridden by") && told("armed"), "{recorded:#?}");
    assert!(recorded.iter().all(|(_, text)| !text.contains("bert")), "{recorded:#?}");
}

fn in_flight_nothing_is_asked_of_the_ground(swarm: &Swarm) {
    let report = swarm.node().preflight().vehicles[0].clone();
    for id in ["on_ground", "not_moving"] {
        let item = report.items.iter().find(|i| i.id == id).unwrap();
        assert_eq!(item.status, ItemStatus::NotApplicable, "{item:?}");
    }
    let standing = swarm.node().preflight().vehicles[1].clone();
    let item = standing.items.iter().find(|i| i.id == "on_ground").unwrap();
    assert_eq!(item.status, ItemStatus::Green);
}
