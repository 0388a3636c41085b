//! A formation that its members keep by the directions to their neighbours alone, asked for through the API, flown behind a leader
//! that moves, and judged by what the simulator knows.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use nalgebra::Vector3;
use serde_json::{Value, json};
use skein_sim::TruthFrame;
use skein_testkit::Swarm;
use std::collections::BTreeMap;
use std::time::Duration;

const VEHICLES: u8 = 5;
const SPACING_M: f64 = 7.0;
/// So far a member may be from its place while the leader sets out, turns and stops, in metres, and once it stands.
const MOVING_M: f64 = 3.0;
const STANDING_M: f64 = 1.0;

async fn put(swarm: &Swarm, path: &str, body: &Value) -> Value {
    let url = format!("http://{}{path}", swarm.web_address());
    let answer = reqwest::Client::new().put(url).json(body).send().await.unwrap();
    let (status, text) = (answer.status(), answer.text().await.unwrap());
    assert!(status.is_success(), "{path}: {status} {text}");
    serde_json::from_str(&text).unwrap()
}

/// Where each vehicle is from the leader, north, east and down.
fn shape(truth: &TruthFrame, leader: u8) -> BTreeMap<u8, Vector3<f64>> {
    let at = truth.vehicle(leader).unwrap().position.vector();
    let from_leader = |v: &skein_sim::VehicleTruth| (v.system_id, v.position.vector() - at);
    truth.vehicles.iter().map(from_leader).collect()
}

fn worst_m(of: &BTreeMap<u8, Vector3<f64>>, wanted: &BTreeMap<u8, Vector3<f64>>) -> f64 {
    let off = |(id, at): (&u8, &Vector3<f64>)| (at - wanted[id]).norm();
    of.iter().map(off).fold(0.0, f64::max)
}

/// The places that were planned: what the truth is held against.
fn planned(swarm: &Swarm) -> BTreeMap<u8, Vector3<f64>> {
    let formation = swarm.node().slots().unwrap();
    let heading_rad = formation.anchor.heading_rad;
    let mut places: BTreeMap<u8, Vector3<f64>> = formation
        .slots
        .iter()
        .map(|(id, slot)| (u8::try_from(id.0).unwrap(), slot.to.rotated(heading_rad)))
        .collect();
    places.insert(u8::try_from(formation.leader.unwrap().0).unwrap(), Vector3::zeros());
    places
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test integration`"]
async fn a_shape_kept_by_directions_stays_as_it_is_behind_a_leader_that_moves() {
    let swarm = Swarm::start_with(usize::from(VEHICLES), |_, sim| sim.spacing_m = SPACING_M).await;
    swarm.take_off(10.0).await;
    let body = json!({ "shape": "wedge", "spacing_m": SPACING_M, "leader": 1, "control": "bearings" });
    let receipt = put(&swarm, "/api/v1/formation", &body).await;
    assert_eq!(receipt["leader"], 1);
    swarm
        .until(
            "the members keep their places by themselves",
            Duration::from_secs(40),
            |fleet| fleet.formation.as_ref().is_some_and(|f| f.keeps_itself),
        )
        .await;
    let wanted = planned(&swarm);
    swarm
        .until("they are in their places", Duration::from_secs(30), |_| {
            worst_m(&shape(&swarm.simulation().truth(), 1), &wanted) < STANDING_M
        })
        .await;

    // Out and, after a corner, off to the side: directions do not turn with it.
    let leader = swarm.truth_now().await.vehicle(1).unwrap().position;
    let corner = |north: f64, east: f64| json!({ "north_m": leader.north_m + north, "east_m": leader.east_m + east, "down_m": leader.down_m });
    let route = json!({ "route": { "waypoints": [corner(40.0, 0.0), corner(40.0, 30.0)], "speed_m_s": 4.0, "corner_radius_m": 8.0 } });
    put(&swarm, "/api/v1/formation/route", &route).await;
    let worst = std::cell::Cell::new((0.0_f64, f64::INFINITY));
    swarm
        .until("the leader has come to the end", Duration::from_secs(60), |fleet| {
            let truth = swarm.simulation().truth();
            let (off_m, near_m) = worst.get();
            let now_m = truth.smallest_distance_m().unwrap();
            worst.set((off_m.max(worst_m(&shape(&truth, 1), &wanted)), near_m.min(now_m)));
            let formation = fleet.formation.as_ref().expect("it goes on");
            assert!(formation.keeps_itself, "by themselves all the way");
            formation.route_finished
        })
        .await;
    let (off_m, near_m) = worst.get();
    println!("worst {off_m:.2} m off its place while moving, {near_m:.2} m from each other");
    assert!(off_m < MOVING_M, "{off_m} m off its place");
    assert!(near_m > 3.0, "{near_m} m from each other");
    let truth = swarm.truth_now().await;
    let came_m = truth.vehicle(1).unwrap().position.horizontal_distance_m(&leader);
    assert!(came_m > 45.0, "the leader has moved {came_m} m");
    swarm
        .until("the shape is as it was", Duration::from_secs(30), |_| {
            worst_m(&shape(&swarm.simulation().truth(), 1), &wanted) < STANDING_M
        })
        .await;
    swarm.stop().await;
}
