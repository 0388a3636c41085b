//! What a newly heard vehicle becomes: adopted by rule, shown if none fits, taken in while others fly.

use skein_config::{AdoptionRule, EndpointSettings};
use skein_domain::{FlightState, Refusal, VehicleCommand, VehicleId};
use skein_runtime::Targets;
use skein_sim::{PortPlan, SimSettings, Simulation, VehicleStart};
use skein_testkit::Swarm;
use std::time::Duration;

#[tokio::test(flavor = "multi_thread")]
async fn a_vehicle_without_a_rule_is_shown_not_flown() {
    let swarm = Swarm::start_with(3, |config, _| {
        config.adopt = vec![AdoptionRule {
            system_ids: "1-2".parse().expect("is a set"),
            name: "scout-{system_id}".into(),
            ..AdoptionRule::default()
        }];
    })
    .await;
    let fleet = swarm
        .until("two adopted, one shown", Duration::ZERO, |fleet| {
            fleet.vehicles.len() == 2 && fleet.unadopted.len() == 1
        })
        .await;
    assert_eq!(fleet.vehicles[0].name, "scout-1");
    assert_eq!(fleet.unadopted[0].system_id.0, 3);
    assert!(fleet.unadopted[0].why.contains("rule"), "{}", fleet.unadopted[0].why);
    let receipts = swarm
        .node()
        .command(&Targets::Vehicles(vec![VehicleId(3)]), VehicleCommand::Arm)
        .await;
    assert_eq!(
        receipts[0].refusal,
        Some(Refusal::UnknownVehicle { vehicle: VehicleId(3) })
    );
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_system_ids_on_two_endpoints_become_different_vehicles() {
    let swarm = Swarm::start_with(2, |config, _| {
        config.endpoints.push(EndpointSettings {
            name: Some("second".into()),
            address: "udp-listen://127.0.0.1:0".into(),
        });
        let second = AdoptionRule {
            endpoint: Some("second".into()),
            vehicle_id_offset: 100,
            ..AdoptionRule::default()
        };
        config.adopt.insert(0, second);
    })
    .await;
    let address = swarm.node().endpoint_addresses()["second"];
    let settings = SimSettings {
        vehicles: 1,
        first_system_id: 7,
        ports: PortPlan::SendTo(address),
        ..SimSettings::default()
    };
    let other = Simulation::start(settings).expect("starts");
    let fleet = swarm
        .until("three vehicles", Duration::ZERO, |fleet| fleet.vehicles.len() == 3)
        .await;
    assert_eq!(fleet.vehicles.iter().map(|v| v.id.0).collect::<Vec<_>>(), [1, 2, 107]);
    other.stop();
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_vehicle_that_appears_in_flight_is_taken_in() {
    let swarm = Swarm::start(2).await;
    swarm.take_off(5.0).await;
    let start = VehicleStart {
        position: skein_domain::PositionNed::new(0.0, 20.0, 0.0),
        ..VehicleStart::default()
    };
    let system_id = swarm.simulation().add(start).expect("is added");
    let id = VehicleId(u16::from(system_id));
    swarm
        .until("the newcomer ready", Duration::ZERO, |fleet| {
            fleet
                .vehicles
                .iter()
                .any(|v| v.id == id && v.ready_to_arm == Some(true))
        })
        .await;
    let command = VehicleCommand::TakeOff { height_m: 5.0 };
    let receipts = swarm.node().command(&Targets::Vehicles(vec![id]), command).await;
    assert_eq!(receipts[0].refusal, None);
    swarm
        .until("the newcomer up", Duration::from_secs(20), |fleet| {
            fleet.vehicles.iter().all(|v| v.flight_state == FlightState::Holding)
        })
        .await;
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn two_vehicles_with_one_system_id_disturb_nobody_else() {
    let swarm = Swarm::start(2).await;
    swarm.ready().await;
    let start = VehicleStart {
        system_id: Some(2),
        position: skein_domain::PositionNed::new(0.0, 30.0, 0.0),
        ..VehicleStart::default()
    };
    swarm.simulation().add(start).expect("is added");
    let fleet = swarm
        .until("the clash told", Duration::ZERO, |fleet| {
            fleet.unadopted.iter().any(|u| u.system_id.0 == 2)
        })
        .await;
    assert!(
        fleet.unadopted[0].why.contains("system id"),
        "{}",
        fleet.unadopted[0].why
    );
    let command = VehicleCommand::TakeOff { height_m: 5.0 };
    let receipts = swarm
        .node()
        .command(&Targets::Vehicles(vec![VehicleId(1)]), command)
        .await;
    assert_eq!(receipts[0].refusal, None, "vehicle 1 has nothing to do with it");
    swarm
        .until("vehicle 1 up", Duration::from_secs(20), |fleet| {
            fleet
                .vehicles
                .iter()
                .any(|v| v.id == VehicleId(1) && v.flight_state == FlightState::Holding)
        })
        .await;
    swarm.stop().await;
}
