//! An operator's command outranks the formation: whoever is told to hold holds, and stays told.

use skein_domain::{FlightState, FormationRequest, PositionNed, Route, Shape, VehicleCommand, VehicleId};
use skein_runtime::Targets;
use skein_testkit::Swarm;
use skein_view::FleetSnapshot;
use std::time::Duration;

fn state(fleet: &FleetSnapshot, id: u16) -> FlightState {
    fleet
        .vehicles
        .iter()
        .find(|v| v.id == VehicleId(id))
        .expect("is known")
        .flight_state
}

async fn two_seconds(swarm: &Swarm) -> FleetSnapshot {
    let later = swarm.node().now().plus_seconds(2.0);
    swarm
        .until("two more seconds", Duration::ZERO, |fleet| fleet.time > later)
        .await
}

#[tokio::test(flavor = "multi_thread")]
async fn whoever_is_told_to_hold_holds_whatever_the_formation_does() {
    let swarm = Swarm::start(5).await;
    swarm.take_off(6.0).await;
    let node = swarm.node();
    node.set_formation(FormationRequest::new(Shape::Wedge, 5.0))
        .await
        .expect("is flown");
    swarm
        .until("everyone in the formation", Duration::from_secs(10), |fleet| {
            state(fleet, 1) == FlightState::Leading && (2..=5).all(|id| state(fleet, id) == FlightState::Following)
        })
        .await;
    let route = Route {
        waypoints: vec![PositionNed::new(80.0, 0.0, -6.0)],
        speed_m_s: 4.0,
        corner_radius_m: 8.0,
    };
    node.set_route(route).await.expect("is flown");

    // One is taken out: the others regroup, it stays out.
    let one = Targets::Vehicles(vec![VehicleId(3)]);
    assert_eq!(node.command(&one, VehicleCommand::Hold).await[0].refusal, None);
    let fleet = two_seconds(&swarm).await;
    assert_eq!(state(&fleet, 3), FlightState::Holding);
    assert_eq!(fleet.formation.expect("goes on").members.len(), 4);

    // All are held: nobody is called back by the regrouping of the others.
    swarm.command_all(VehicleCommand::Hold).await;
    swarm
        .until("the formation has ended", Duration::ZERO, |fleet| {
            fleet.formation.is_none()
        })
        .await;
    let fleet = two_seconds(&swarm).await;
    for id in 1..=5 {
        assert_eq!(state(&fleet, id), FlightState::Holding, "vehicle {id}");
    }
    let truth = swarm.truth_now().await;
    assert!(
        truth.vehicles.iter().all(|v| v.velocity.norm() < 0.5),
        "all stand still"
    );

    // And the operator calls them together again.
    let receipt = node
        .set_formation(FormationRequest::new(Shape::Wedge, 5.0))
        .await
        .expect("is flown");
    assert_eq!(receipt.members.len(), 5);
    swarm.stop().await;
}
