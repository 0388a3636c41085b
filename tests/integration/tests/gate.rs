//! What the safety gate refuses comes back to the asker with its reason, and nothing moves.

use skein_config::FenceSettings;
use skein_domain::{FlightState, FormationRequest, PositionNed, Refusal, Route, Shape, VehicleCommand, VehicleId};
use skein_runtime::Targets;
use skein_testkit::Swarm;

fn fenced(config: &mut skein_config::NodeConfig) {
    config.safety.fence = Some(FenceSettings {
        polygon_m: vec![[-40.0, -40.0], [40.0, -40.0], [40.0, 40.0], [-40.0, 40.0]],
        floor_m: -5.0,
        ceiling_m: 30.0,
    });
}

#[tokio::test(flavor = "multi_thread")]
async fn goals_outside_the_fence_are_refused_by_reason() {
    let swarm = Swarm::start_with(2, |config, _| fenced(config)).await;
    swarm.ready().await;
    let one = Targets::Vehicles(vec![VehicleId(1)]);
    let too_high = swarm
        .node()
        .command(&one, VehicleCommand::TakeOff { height_m: 60.0 })
        .await;
    assert!(
        matches!(too_high[0].refusal, Some(Refusal::OutsideFence { .. })),
        "{too_high:?}"
    );
    let nonsense = swarm
        .node()
        .command(&one, VehicleCommand::TakeOff { height_m: f64::NAN })
        .await;
    assert!(
        matches!(nonsense[0].refusal, Some(Refusal::InvalidValue { .. })),
        "{nonsense:?}"
    );
    let fleet = swarm.take_off(6.0).await;
    assert!(fleet.vehicles.iter().all(|v| v.flight_state == FlightState::Holding));
    let far = VehicleCommand::GoTo {
        position: PositionNed::new(100.0, 0.0, -6.0),
        yaw_rad: None,
        speed_m_s: None,
    };
    let receipts = swarm.node().command(&one, far).await;
    assert!(
        matches!(receipts[0].refusal, Some(Refusal::OutsideFence { .. })),
        "{receipts:?}"
    );
    let fast = VehicleCommand::GoTo {
        position: PositionNed::new(20.0, 0.0, -6.0),
        yaw_rad: None,
        speed_m_s: Some(50.0),
    };
    let receipts = swarm.node().command(&one, fast).await;
    assert!(
        matches!(receipts[0].refusal, Some(Refusal::TooFast { .. })),
        "{receipts:?}"
    );
    formations_and_routes_too(&swarm).await;
    swarm.stop().await;
}

/// What the coordinator is asked passes the same gate.
async fn formations_and_routes_too(swarm: &Swarm) {
    assert!(
        swarm
            .node()
            .set_formation(FormationRequest::new(Shape::Line, 0.5))
            .await
            .is_err(),
        "closer than vehicles may be"
    );
    swarm
        .node()
        .set_formation(FormationRequest::new(Shape::Line, 5.0))
        .await
        .expect("is flown");
    let route = Route {
        waypoints: vec![PositionNed::new(0.0, 90.0, -6.0)],
        speed_m_s: 5.0,
        corner_radius_m: 5.0,
    };
    assert!(matches!(
        swarm.node().set_route(route).await,
        Err(Refusal::OutsideFence { .. })
    ));
}
