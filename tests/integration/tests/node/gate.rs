//! What the safety gate refuses comes back to the asker with its reason, and nothing moves.

use skein_config::FenceSettings;
use skein_coordination::ReferenceReport;
use skein_domain::{
    FlightState, FormationAnchor, FormationRequest, HeadingRequest, PositionNed, Refusal, Route, Shape, VehicleCommand,
    VehicleId,
};
use skein_runtime::Targets;
use skein_testkit::Swarm;
use skein_view::FleetSnapshot;
use std::time::Duration;

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

const CAR: &str = "car";

/// What the formation follows is somewhere north, and is told of as often as anybody looks.
fn tell_car(swarm: &Swarm, north_m: f64) {
    let report = ReferenceReport {
        position: PositionNed::new(north_m, 0.0, -8.0),
        velocity: None,
        heading_rad: None,
    };
    swarm.node().tell_reference(CAR, report).expect("is taken");
}

/// How far north the swarm is on the mean and its northernmost, in metres.
fn north_m(fleet: &FleetSnapshot) -> (f64, f64) {
    let all: Vec<f64> = fleet
        .vehicles
        .iter()
        .map(|v| v.kinematics.expect("has a position").position.north_m)
        .collect();
    let northernmost_m = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (all.iter().sum::<f64>() / all.len() as f64, northernmost_m)
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test integration`"]
async fn a_formation_waits_at_the_fence_for_the_reference_that_left_it() {
    let swarm = Swarm::start_with(3, |config, _| fenced(config)).await;
    swarm.ready().await;
    swarm.take_off(8.0).await;
    tell_car(&swarm, 0.0);
    let column = FormationRequest {
        anchor: FormationAnchor::Reference { name: CAR.into() },
        heading: HeadingRequest::Fixed { heading_deg: 0.0 },
        ..FormationRequest::new(Shape::Column, 6.0)
    };
    swarm.node().set_formation(column).await.expect("is flown");
    let flight = Duration::from_secs(60);
    let told = |text: &str| swarm.node().events_after(0).iter().any(|e| e.text.contains(text));
    swarm
        .until("the formation at the fence", flight, |fleet| {
            tell_car(&swarm, 90.0);
            let (_, northernmost_m) = north_m(fleet);
            assert!(northernmost_m < 40.0, "{northernmost_m} m north");
            told("the formation waits") && northernmost_m > 30.0
        })
        .await;
    swarm
        .until("the formation about its reference again", flight, |fleet| {
            tell_car(&swarm, 5.0);
            told("no longer waits") && (north_m(fleet).0 - 5.0).abs() < 1.0
        })
        .await;
    swarm.stop().await;
}
