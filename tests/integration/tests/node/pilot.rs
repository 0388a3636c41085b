//! A human on the remote control always wins, and only an operator's command takes the vehicle back.

use skein_domain::{FlightMode, FlightState, FormationRequest, Shape, VehicleCommand, VehicleId};
use skein_runtime::Targets;
use skein_testkit::Swarm;
use std::time::Duration;

#[tokio::test(flavor = "multi_thread")]
async fn the_pilot_takes_a_vehicle_out_and_the_others_close_up() {
    let swarm = Swarm::start(4).await;
    swarm.take_off(6.0).await;
    swarm
        .node()
        .set_formation(FormationRequest::new(Shape::Line, 5.0))
        .await
        .expect("is flown");
    let following = |id: u16, fleet: &skein_view::FleetSnapshot| {
        fleet
            .vehicles
            .iter()
            .any(|v| v.id == VehicleId(id) && v.flight_state == FlightState::Following)
    };
    swarm
        .until("everyone follows", Duration::from_secs(10), |f| {
            (2..=4).all(|id| following(id, f))
        })
        .await;
    swarm
        .simulation()
        .pilot_mode(3, FlightMode::Position)
        .expect("has a remote control");
    let fleet = swarm
        .until("the pilot's vehicle is out of the formation", Duration::ZERO, |fleet| {
            let taken = fleet
                .vehicles
                .iter()
                .any(|v| v.id == VehicleId(3) && v.flight_state == FlightState::PilotControl);
            taken
                && fleet
                    .formation
                    .as_ref()
                    .is_some_and(|f| !f.members.contains(&VehicleId(3)))
        })
        .await;
    assert_eq!(fleet.formation.expect("goes on").members.len(), 3);
    nothing_is_streamed(&swarm).await;
    let receipts = swarm
        .node()
        .command(&Targets::Vehicles(vec![VehicleId(3)]), VehicleCommand::Hold)
        .await;
    assert_eq!(receipts[0].refusal, None);
    swarm
        .until("back under the swarm's control", Duration::ZERO, |fleet| {
            fleet
                .vehicles
                .iter()
                .any(|v| v.id == VehicleId(3) && v.flight_state == FlightState::Holding)
        })
        .await;
    swarm.stop().await;
}

/// Vehicle 3 gets no setpoint for two seconds, and the pilot's mode stands.
async fn nothing_is_streamed(swarm: &Swarm) {
    let before = swarm.truth_now().await.vehicle(3).expect("is simulated").setpoints;
    // Two seconds of flight in which a stream would show.
    let later = swarm.node().now().plus_seconds(2.0);
    swarm
        .until("two more seconds", Duration::ZERO, |fleet| fleet.time > later)
        .await;
    let truth = swarm.truth_now().await;
    let vehicle = truth.vehicle(3).expect("is simulated");
    assert_eq!(
        vehicle.setpoints, before,
        "nothing is streamed to a vehicle under a pilot's control"
    );
    assert_eq!(vehicle.mode, FlightMode::Position, "the pilot's mode stands");
}
