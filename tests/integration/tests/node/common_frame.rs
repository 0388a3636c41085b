//! Every vehicle has its own origin: a formation holds when they are 50 m apart and at different heights.

use skein_domain::{FormationRequest, HeadingRequest, PositionNed, Shape};
use skein_sim::{TruthFrame, VehicleStart};
use skein_testkit::Swarm;
use std::time::Duration;

/// Where the vehicles start: 50 m apart, on ground of different heights.
fn starts() -> Vec<VehicleStart> {
    [(0.0, 0.0, 0.0), (50.0, 0.0, -4.0), (0.0, 50.0, 3.0), (50.0, 50.0, -9.0)]
        .map(|(north, east, down)| VehicleStart {
            position: PositionNed::new(north, east, down),
            ..VehicleStart::default()
        })
        .to_vec()
}

fn position(truth: &TruthFrame, system_id: u8) -> PositionNed {
    truth.vehicle(system_id).expect("is simulated").position
}

#[tokio::test(flavor = "multi_thread")]
async fn a_formation_holds_whatever_each_vehicle_calls_its_origin() {
    let swarm = Swarm::start_with(4, |_, sim| sim.starts = starts()).await;
    let fleet = swarm.take_off(15.0).await;
    let truth = swarm.truth_now().await;
    for vehicle in &truth.vehicles {
        let origin = vehicle.local_origin;
        assert!(
            vehicle.system_id == 1 || origin.norm() > 40.0,
            "the origins must differ for this test to show anything: {origin:?}"
        );
    }
    assert!(fleet.frame.is_some());
    let request = FormationRequest {
        heading: HeadingRequest::Fixed { heading_deg: 0.0 },
        ..FormationRequest::new(Shape::Line, 6.0)
    };
    let receipt = swarm.node().set_formation(request).await.expect("is flown");
    let extra = Duration::from_secs_f64(receipt.duration_s);
    let fleet = swarm
        .until("everyone in its slot", extra, |fleet| {
            let followers = fleet.vehicles.iter().filter(|v| !v.is_leader);
            fleet.formation.as_ref().is_some_and(|f| fleet.time > f.settled_at)
                && followers
                    .into_iter()
                    .all(|v| v.tracking_error_m.is_some_and(|m| m < 0.4))
        })
        .await;
    let truth = swarm.truth_now().await;
    // Any of them may lead.
    let leader = fleet.vehicles.iter().find(|v| v.is_leader).expect("one leads");
    let leader = position(&truth, leader.system_id.0);
    let mut places: Vec<f64> = (1..=4).map(|id| position(&truth, id).east_m - leader.east_m).collect();
    places.sort_by(f64::total_cmp);
    for (place, wanted) in places.iter().zip([-6.0, 0.0, 6.0, 12.0]) {
        assert!((place - wanted).abs() < 0.8, "east of the leader: {places:?}");
    }
    for id in 1..=4 {
        let at = position(&truth, id);
        assert!(
            (at.north_m - leader.north_m).abs() < 0.8,
            "vehicle {id} is not in line: {at:?}, leader {leader:?}"
        );
        assert!(
            (at.down_m - leader.down_m).abs() < 0.8,
            "vehicle {id} is not level: {at:?}, leader {leader:?}"
        );
    }
    swarm.stop().await;
}
