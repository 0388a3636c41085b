//! Killing a plugin, a vehicle's actor or the coordinator in flight: the setpoints go on, the state comes back.

use skein_domain::{FlightMode, FlightState, FormationRequest, Shape, VehicleId};
use skein_runtime::Fault;
use skein_testkit::{LONGEST_GAP_S, Swarm};
use skein_view::FleetSnapshot;
use std::time::Duration;

async fn in_a_wedge(vehicles: usize) -> Swarm {
    let swarm = Swarm::start(vehicles).await;
    swarm.take_off(6.0).await;
    let request = FormationRequest::new(Shape::Wedge, 5.0);
    swarm.node().set_formation(request).await.expect("is flown");
    swarm
        .until("everyone in its slot", Duration::from_secs(15), settled)
        .await;
    swarm
}

fn settled(fleet: &FleetSnapshot) -> bool {
    let in_slot = |v: &&skein_view::VehicleSnapshot| {
        v.is_leader || (v.flight_state == FlightState::Following && v.tracking_error_m.is_some_and(|m| m < 0.6))
    };
    fleet.formation.as_ref().is_some_and(|f| fleet.time > f.settled_at)
        && fleet.vehicles.iter().filter(|v| !in_slot(v)).count() == 0
}

/// What must be so after every fault: nobody left OFFBOARD, nobody went without setpoints, the formation stands.
async fn undisturbed(swarm: &Swarm, what: &str) {
    swarm.until(what, Duration::from_secs(5), settled).await;
    let truth = swarm.truth_now().await;
    for vehicle in &truth.vehicles {
        assert_eq!(
            vehicle.mode,
            FlightMode::Offboard,
            "system id {} after {what}",
            vehicle.system_id
        );
        let gap_s = vehicle.offboard_gap_sender_max_s;
        assert!(
            gap_s <= LONGEST_GAP_S,
            "system id {}: {gap_s:.3} s without a setpoint ({what})",
            vehicle.system_id
        );
        assert!(!vehicle.failsafe);
    }
}

async fn restarted(swarm: &Swarm, what: &str, incarnation: impl Fn(&FleetSnapshot) -> u32) {
    swarm.until(what, Duration::ZERO, |fleet| incarnation(fleet) > 1).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_is_killed_the_formation_flies_on() {
    let swarm = in_a_wedge(4).await;
    let node = swarm.node();
    let model = |fleet: &FleetSnapshot, i: usize| fleet.vehicles[i].model.incarnation.0;
    let actor = |fleet: &FleetSnapshot, i: usize| fleet.vehicles[i].actor.incarnation.0;

    node.inject_fault(Fault::PluginPanic {
        vehicle: VehicleId(2),
        payload: None,
    })
    .await
    .expect("is permitted");
    restarted(&swarm, "the follower's model started again", |f| model(f, 1)).await;
    undisturbed(&swarm, "a follower's model panicked").await;

    node.inject_fault(Fault::PluginPanic {
        vehicle: VehicleId(1),
        payload: None,
    })
    .await
    .expect("is permitted");
    restarted(&swarm, "the leader's model started again", |f| model(f, 0)).await;
    undisturbed(&swarm, "the leader's model panicked").await;

    node.inject_fault(Fault::PluginHang {
        vehicle: VehicleId(3),
        payload: None,
    })
    .await
    .expect("is permitted");
    restarted(&swarm, "the hanging model replaced", |f| model(f, 2)).await;
    undisturbed(&swarm, "a follower's model hung").await;

    node.inject_fault(Fault::VehicleActor { vehicle: VehicleId(4) })
        .await
        .expect("is permitted");
    restarted(&swarm, "the vehicle's actor started again", |f| actor(f, 3)).await;
    undisturbed(&swarm, "a vehicle's actor was killed").await;

    node.inject_fault(Fault::Coordinator).await.expect("is permitted");
    restarted(&swarm, "the coordinator started again", |f| {
        f.actors
            .iter()
            .find(|a| a.name == "coordinator")
            .map_or(0, |a| a.incarnation.0)
    })
    .await;
    undisturbed(&swarm, "the coordinator was killed").await;
    assert!(node.snapshot().formation.is_some(), "its successor knows the formation");
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_model_that_fails_for_ever_is_given_up_and_its_autopilot_holds() {
    let swarm = Swarm::start(2).await;
    swarm.take_off(6.0).await;
    let vehicle = VehicleId(2);
    let given_up = |fleet: &FleetSnapshot| fleet.vehicles[1].flight_state == FlightState::Faulted;
    // The policy allows eight failures in a minute.
    for round in 0..12u32 {
        if given_up(&swarm.node().snapshot()) {
            break;
        }
        let before = swarm.node().snapshot().vehicles[1].model.incarnation.0;
        swarm
            .node()
            .inject_fault(Fault::PluginPanic { vehicle, payload: None })
            .await
            .expect("is permitted");
        swarm
            .until(&format!("failure {round} seen"), Duration::from_secs(5), |fleet| {
                let model = &fleet.vehicles[1].model;
                given_up(fleet) || (model.incarnation.0 > before && model.status == skein_view::ActorStatus::Running)
            })
            .await;
    }
    swarm
        .until("the autopilot holds", Duration::ZERO, |fleet| {
            given_up(fleet) && fleet.vehicles[1].mode == FlightMode::Hold
        })
        .await;
    let truth = swarm.truth_now().await;
    assert_eq!(
        truth.vehicle(1).expect("is simulated").mode,
        FlightMode::Offboard,
        "the other one flies on"
    );
    swarm.stop().await;
}
