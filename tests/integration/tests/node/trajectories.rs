//! Trajectories flown through the API: from a common start through waypoints, planned anew while moving, put on a vehicle, left for a
//! command. Judged by what the simulator knows and by the setpoints.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use serde_json::{Value, json};
use skein_domain::{FlightState, NodeTime, PositionNed, VehicleCommand, VehicleId};
use skein_runtime::Targets;
use skein_testkit::{Swarm, eventually, patience};
use skein_view::FleetSnapshot;
use std::collections::BTreeMap;
use std::time::Duration;

/// A flight of some seconds, beyond our patience.
const FLIGHT: Duration = Duration::from_secs(90);
/// Whoever has come so far has set out, in metres. From rest a way begins with the third power of time: on a short one that is later.
const STARTED_M: f64 = 0.03;
/// Two snapshots may be made so much nearer to each other, or further apart, than the setpoints in them, in seconds: on a busy machine a vehicle's
/// period comes late. That a plan made anew goes on without a jump is shown beside the planner; here, that it is flown so.
const SKEW_S: f64 = 0.5;
/// A snapshot may hold a setpoint that is so much newer than the snapshot's time, in seconds.
const EARLY_S: f64 = 0.1;
/// A setpoint may be so much elsewhere than its motion leads, in metres: rounding, and a start from where the vehicle really holds.
const JUMP_M: f64 = 0.25;

async fn ask(swarm: &Swarm, method: &str, path: &str, body: Option<Value>) -> (u16, Value) {
    let url = format!("http://{}{path}", swarm.web_address());
    let mut request = reqwest::Client::new().request(method.parse().unwrap(), url);
    if let Some(body) = body {
        request = request.json(&body);
    }
    let answer = request.send().await.unwrap();
    let status = answer.status().as_u16();
    let text = answer.text().await.unwrap();
    (status, serde_json::from_str(&text).unwrap_or(Value::Null))
}

fn place(fleet: &FleetSnapshot, id: u16) -> PositionNed {
    let vehicle = fleet.vehicles.iter().find(|v| v.id == VehicleId(id)).unwrap();
    vehicle.kinematics.unwrap().position
}

/// A body that sends each of these vehicles along these offsets from a place.
fn request(ways: &[(u16, PositionNed, &[[f64; 3]])], more: Value) -> Value {
    let point = |from: &PositionNed, [north_m, east_m, down_m]: &[f64; 3]| json!({ "north_m": from.north_m + north_m, "east_m": from.east_m + east_m, "down_m": from.down_m + down_m });
    let vehicles: Vec<Value> = ways
        .iter()
        .map(|(id, from, way)| {
            let waypoints: Vec<Value> = way.iter().map(|by| point(from, by)).collect();
            json!({ "vehicle": id, "waypoints": waypoints })
        })
        .collect();
    let mut body = json!({ "vehicles": vehicles });
    for (key, value) in more.as_object().unwrap() {
        body[key] = value.clone();
    }
    body
}

/// Setpoints as they were seen, vehicle by vehicle, and what they must not do.
#[derive(Default)]
struct Setpoints {
    last: BTreeMap<VehicleId, (NodeTime, PositionNed)>,
    /// When all are to set out.
    start: NodeTime,
    first: BTreeMap<VehicleId, PositionNed>,
    started: BTreeMap<VehicleId, NodeTime>,
    smallest_distance_m: f64,
}

impl Setpoints {
    fn look(&mut self, swarm: &Swarm, fleet: &FleetSnapshot, max_speed_m_s: f64) {
        let truth_m = swarm.simulation().truth().smallest_distance_m().unwrap();
        self.smallest_distance_m = self.smallest_distance_m.min(truth_m);
        for vehicle in &fleet.vehicles {
            let Some(slot) = vehicle.slot else { continue };
            // A hold settles for a moment after the take-off: where it is shortly before the start is what counts.
            if fleet.time.seconds_since(self.start) < -0.5 {
                self.first.insert(vehicle.id, slot);
            }
            let gone_m = self.first.get(&vehicle.id).map_or(0.0, |first| first.distance_m(&slot));
            if gone_m > STARTED_M {
                self.started.entry(vehicle.id).or_insert(fleet.time);
            }
            if let Some((time, before)) = self.last.insert(vehicle.id, (fleet.time, slot)) {
                let (moved_m, dt_s) = (before.distance_m(&slot), fleet.time.seconds_since(time));
                assert!(
                    moved_m <= max_speed_m_s * (dt_s + SKEW_S) + JUMP_M,
                    "the setpoint of {} jumps {moved_m:.2} m in {dt_s:.3} s",
                    vehicle.id
                );
            }
        }
    }

    /// Watches every snapshot until it is as wanted.
    async fn until(&mut self, swarm: &Swarm, speed: f64, what: &str, wanted: impl Fn(&FleetSnapshot) -> bool) {
        let node = swarm.node();
        let mut seen = 0;
        eventually(patience() + FLIGHT, what, async || {
            let fleet = node.snapshot();
            if fleet.sequence == seen {
                return None;
            }
            seen = fleet.sequence;
            self.look(swarm, &fleet, speed);
            wanted(&fleet).then_some(())
        })
        .await;
    }
}

fn progress(swarm: &Swarm) -> Vec<Value> {
    let all = swarm.node().trajectories();
    all.iter().map(|t| serde_json::to_value(t).unwrap()).collect()
}

fn all_are(swarm: &Swarm, is: &str) -> bool {
    let all = progress(swarm);
    !all.is_empty() && all.iter().all(|t| t["progress"]["is"] == is)
}

#[tokio::test(flavor = "multi_thread")]
async fn three_fly_in_step_and_are_planned_anew_while_moving() {
    let swarm = Swarm::start_with(3, |_, sim| sim.spacing_m = 8.0).await;
    let holding = swarm.take_off(10.0).await;
    // Plans are made from the picture of a period, which may be the one before the last of them said that it holds.
    let later = holding.time.plus_seconds(0.5);
    let fleet = swarm
        .until("the next pictures", Duration::ZERO, |fleet| fleet.time > later)
        .await;
    let at: Vec<PositionNed> = (1..=3).map(|id| place(&fleet, id)).collect();
    refused_item_by_item(&swarm, &at).await;

    // The first has the longest way: the others pass their waypoints when it does.
    let ways: [(u16, PositionNed, &[[f64; 3]]); 3] = [
        (1, at[0], &[[40.0, 0.0, -4.0], [80.0, 6.0, 0.0]]),
        (2, at[1], &[[30.0, 2.0, 0.0], [60.0, 4.0, 2.0]]),
        (3, at[2], &[[0.0, -30.0, 0.0], [0.0, -50.0, 0.0]]),
    ];
    let start = json!({ "start": { "when": "in", "in_s": 3.0 }, "max_speed_m_s": 5.0 });
    let (status, plan) = ask(&swarm, "POST", "/api/v1/trajectories", Some(request(&ways, start))).await;
    assert_eq!(status, 202, "{plan}");
    let start = NodeTime(plan["start"].as_u64().unwrap());
    let passes_s: Vec<f64> = serde_json::from_value(plan["vehicles"][0]["passes_s"].clone()).unwrap();
    for vehicle in plan["vehicles"].as_array().unwrap() {
        assert!(vehicle["max_speed_m_s"].as_f64().unwrap() <= 5.0 + 1e-6, "{vehicle}");
        assert_eq!(vehicle["passes_s"], plan["vehicles"][0]["passes_s"], "in step");
    }
    let planned_m = plan["min_distance_m"].as_f64().unwrap();
    let mut setpoints = Setpoints {
        start,
        smallest_distance_m: f64::INFINITY,
        ..Setpoints::default()
    };
    let first_passed = start.plus_seconds(passes_s[0]);
    setpoints
        .until(&swarm, 5.0, "the first waypoints", |fleet| fleet.time >= first_passed)
        .await;
    let fleet = swarm.node().snapshot();
    for (id, from, way) in &ways {
        let waypoint = from.moved(way[0].into());
        let off_m = place(&fleet, *id).distance_m(&waypoint);
        let late_s = fleet.time.seconds_since(first_passed);
        assert!(
            off_m < 1.5 + 5.0 * late_s,
            "vehicle {id} passes its first waypoint {off_m:.1} m off"
        );
    }
    began_together(&setpoints, start);
    anew_while_moving(&swarm, &mut setpoints, planned_m).await;
    left_for_a_command(&swarm).await;
    swarm.stop().await;
}

/// What is against a plan is told, and nobody moves.
async fn refused_item_by_item(swarm: &Swarm, at: &[PositionNed]) {
    let crossing: [(u16, PositionNed, &[[f64; 3]]); 3] = [
        (1, at[0], &[[30.0, 0.0, 0.0]]),
        (2, at[0], &[[30.0, 0.5, 0.0]]),
        (3, at[2], &[[0.0, 20.0, 20.0]]),
    ];
    let (status, refused) = ask(
        swarm,
        "POST",
        "/api/v1/trajectories",
        Some(request(&crossing, json!({}))),
    )
    .await;
    assert_eq!(status, 409, "{refused}");
    let against = refused["error"]["detail"]["against"].as_array().unwrap();
    let told = |vehicle: u16, reason: &str| {
        let fits = |o: &&Value| o["vehicle"] == json!(vehicle) && o["refusal"]["reason"] == reason;
        against.iter().any(|o| fits(&o))
    };
    assert!(told(1, "too_close") && told(3, "invalid_value"), "{refused}");
    assert_eq!(progress(swarm), Vec::<Value>::new());
}

/// All set out at the start, and none before its time. How exactly they keep step is seen at the first waypoint.
fn began_together(setpoints: &Setpoints, start: NodeTime) {
    assert_eq!(setpoints.started.len(), 3, "all have set out");
    let after_s: Vec<f64> = setpoints
        .started
        .values()
        .map(|began| began.seconds_since(start))
        .collect();
    let earliest_s = after_s.iter().copied().fold(f64::INFINITY, f64::min);
    let latest_s = after_s.iter().copied().fold(0.0, f64::max);
    println!("set out {earliest_s:.2} to {latest_s:.2} s after the start");
    assert!(earliest_s > -EARLY_S, "one sets out {earliest_s} s before its time");
}

async fn anew_while_moving(swarm: &Swarm, setpoints: &mut Setpoints, planned_m: f64) {
    let moving = swarm.truth_now().await;
    let fastest = moving.vehicles.iter().map(|v| v.velocity.norm()).fold(0.0, f64::max);
    assert!(fastest > 1.5, "they are under way: {fastest} m/s");
    let fleet = swarm.node().snapshot();
    let from = |id: u16| place(&fleet, id);
    let ways: [(u16, PositionNed, &[[f64; 3]]); 3] = [
        (1, from(1), &[[30.0, -10.0, 0.0], [45.0, -25.0, 0.0]]),
        (2, from(2), &[[30.0, 0.0, 0.0], [45.0, 0.0, 0.0]]),
        (3, from(3), &[[5.0, -30.0, 0.0], [15.0, -45.0, 0.0]]),
    ];
    let body = request(&ways, json!({ "kind": "snap", "max_speed_m_s": 5.0 }));
    let (status, plan) = ask(swarm, "POST", "/api/v1/trajectories", Some(body)).await;
    assert_eq!(status, 202, "{plan}");
    let start = NodeTime(plan["start"].as_u64().unwrap());
    let over = start.plus_seconds(1.0);
    setpoints
        .until(swarm, 5.0, "the new trajectories", |fleet| fleet.time >= over)
        .await;
    let truth = swarm.truth_now().await;
    let slowest = truth
        .vehicles
        .iter()
        .map(|v| v.velocity.norm())
        .fold(f64::INFINITY, f64::min);
    println!("a second after the change the slowest goes {slowest:.1} m/s");
    assert!(slowest > 0.5, "nobody was stopped by the change: {slowest} m/s");
    setpoints
        .until(swarm, 5.0, "the end of all", |_| all_are(swarm, "flown"))
        .await;
    let fleet = swarm.node().snapshot();
    for (id, from, way) in &ways {
        let off_m = place(&fleet, *id).distance_m(&from.moved(way[1].into()));
        assert!(off_m < 1.0, "vehicle {id} arrives {off_m:.2} m off");
    }
    println!(
        "smallest distance {:.2} m, planned {planned_m:.2} m",
        setpoints.smallest_distance_m
    );
    assert!(setpoints.smallest_distance_m > 2.0, "{}", setpoints.smallest_distance_m);
}

/// A command takes a vehicle out; ending the rest makes them hold.
async fn left_for_a_command(swarm: &Swarm) {
    let fleet = swarm.node().snapshot();
    let ways: [(u16, PositionNed, &[[f64; 3]]); 3] = [
        (1, place(&fleet, 1), &[[40.0, 0.0, 0.0]]),
        (2, place(&fleet, 2), &[[40.0, 0.0, 0.0]]),
        (3, place(&fleet, 3), &[[40.0, 0.0, 0.0]]),
    ];
    let (status, plan) = ask(swarm, "POST", "/api/v1/trajectories", Some(request(&ways, json!({})))).await;
    assert_eq!(status, 202, "{plan}");
    let over = NodeTime(plan["start"].as_u64().unwrap()).plus_seconds(2.5);
    swarm.until("they fly", FLIGHT, |fleet| fleet.time > over).await;
    let one = Targets::Vehicles(vec![VehicleId(2)]);
    assert_eq!(swarm.node().command(&one, VehicleCommand::Hold).await[0].refusal, None);
    swarm
        .until("the commanded one has left", FLIGHT, |_| {
            let all = progress(swarm);
            all[1]["progress"] == json!({ "is": "ended", "why": "commanded otherwise" })
                && all[0]["progress"]["is"] == "flying"
        })
        .await;
    let (status, ended) = ask(swarm, "DELETE", "/api/v1/trajectories", None).await;
    assert_eq!((status, ended), (200, json!({ "vehicles": [1, 3] })));
    swarm
        .until("all hold", FLIGHT, |fleet| {
            fleet.vehicles.iter().all(|v| v.flight_state == FlightState::Holding)
        })
        .await;
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test integration`"]
async fn a_route_is_put_on_the_vehicle_that_flies_it() {
    let swarm = Swarm::start_with(2, |_, sim| sim.spacing_m = 8.0).await;
    let fleet = swarm.take_off(8.0).await;
    let from = place(&fleet, 1);
    let way: &[[f64; 3]] = &[[20.0, 0.0, 0.0], [20.0, 20.0, -3.0], [0.0, 20.0, 0.0]];
    let body = request(&[(1, from, way)], json!({ "upload": true }));
    let (status, plan) = ask(&swarm, "POST", "/api/v1/trajectories", Some(body)).await;
    assert_eq!(status, 202, "{plan}");
    swarm
        .until("the autopilot holds the route", FLIGHT, |_| {
            progress(&swarm)[0]["upload"]["is"] == "held"
        })
        .await;
    let points = progress(&swarm)[0]["upload"]["points"].as_u64().unwrap();
    let truth = swarm.truth_now().await;
    let held = truth.vehicle(1).unwrap().mission.clone();
    assert_eq!(held.len() as u64, points, "every point is there");
    assert!(
        truth.vehicle(2).unwrap().mission.is_empty(),
        "nobody else was given one"
    );
    let frame = fleet.frame.unwrap();
    let end = frame.position(held.last().unwrap());
    let off_m = end.distance_m(&from.moved(way[2].into()));
    assert!(off_m < 0.2, "it ends {off_m:.2} m beside the last waypoint");
    // Each waypoint lies on one of the legs' ends.
    for by in way {
        let waypoint = from.moved((*by).into());
        let near = held.iter().any(|at| frame.position(at).distance_m(&waypoint) < 0.2);
        assert!(near, "{by:?} is not among the points");
    }
    swarm
        .until("it has flown it", FLIGHT, |_| all_are(&swarm, "flown"))
        .await;
    swarm.stop().await;
}
