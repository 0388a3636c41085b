//! A swarm that has landed flies again: after a landing out of OFFBOARD the autopilot shows OFFBOARD again and would not arm.

use skein_domain::{FlightMode, FlightState, PositionNed, VehicleCommand};
use skein_testkit::Swarm;
use skein_view::FleetSnapshot;
use std::time::Duration;

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test integration`"]
async fn who_has_landed_is_ready_to_fly_again() {
    let swarm = Swarm::start_with(2, |_, sim| sim.spacing_m = 8.0).await;
    for height_m in [5.0, 7.0] {
        // Waits until all are ready and nothing in the preflight report is red.
        swarm.take_off(height_m).await;
        // By setpoints, so that it is OFFBOARD they land out of.
        let at = |fleet: &FleetSnapshot| fleet.vehicles.iter().all(|v| v.mode == FlightMode::Offboard);
        let first = swarm.node().snapshot().vehicles[0].clone();
        let place = first.kinematics.expect("it is known where it is").position;
        let up = VehicleCommand::GoTo {
            position: PositionNed::new(place.north_m, place.east_m, place.down_m - 1.0),
            yaw_rad: None,
            speed_m_s: None,
        };
        let one = skein_runtime::Targets::Vehicles(vec![first.id]);
        let receipts = swarm.node().command(&one, up).await;
        assert_eq!(receipts[0].refusal, None, "{receipts:?}");
        swarm.until("flying by setpoints", Duration::from_secs(10), at).await;
        swarm.command_all(VehicleCommand::Land).await;
        let down = |fleet: &FleetSnapshot| fleet.vehicles.iter().all(|v| v.flight_state == FlightState::Idle);
        let landed = swarm.until("all landed", Duration::from_secs(30), down).await;
        for vehicle in &landed.vehicles {
            assert_eq!((vehicle.armed, vehicle.mode), (false, FlightMode::Hold), "{vehicle:?}");
        }
    }
    swarm.stop().await;
}
