//! Vehicles steered by hand: over the API as the dashboard does it, over another node, and the leader of a formation.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use futures_util::{SinkExt, StreamExt};
use parking_lot::Mutex;
use serde_json::{Value, json};
use skein_domain::{
    FlightMode, FlightState, FormationRequest, PositionNed, Refusal, Shape, Stick, VehicleCommand, VehicleId,
};
use skein_runtime::{NodeHandle, Targets};
use skein_testkit::{Flock, Member, Swarm};
use skein_view::{FleetSnapshot, LeaderStateKind};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio_tungstenite::tungstenite::Message;

/// As often as the dashboard says a stick.
const EVERY: Duration = Duration::from_millis(50);

/// A hand on a stick, at a console of its own. It is said as long as there is one.
struct Hand {
    stick: watch::Sender<Option<(u16, Stick)>>,
    errors: Arc<Mutex<Vec<Value>>>,
    task: JoinHandle<()>,
}

impl Hand {
    async fn at(swarm: &Swarm, console: &str) -> Self {
        let url = format!("ws://{}/api/v1/stream?console={console}", swarm.web_address());
        let (mut stream, _) = tokio_tungstenite::connect_async(url).await.unwrap();
        let (stick, held) = watch::channel::<Option<(u16, Stick)>>(None);
        let errors = Arc::new(Mutex::new(Vec::new()));
        let heard = errors.clone();
        let task = tokio::spawn(async move {
            let mut every = tokio::time::interval(EVERY);
            loop {
                tokio::select! {
                    _ = every.tick() => {
                        let Some((vehicle, stick)) = *held.borrow() else { continue };
                        let text = json!({
                            "type": "stick", "vehicle": vehicle, "forward_m_s": stick.forward_m_s, "right_m_s": stick.right_m_s,
                            "up_m_s": stick.up_m_s, "yaw_rate_rad_s": stick.yaw_rate_rad_s,
                        });
                        if stream.send(Message::text(text.to_string())).await.is_err() {
                            return;
                        }
                    }
                    message = stream.next() => match message {
                        Some(Ok(Message::Text(text))) => {
                            let said: Value = serde_json::from_str(&text).unwrap();
                            if said["type"] == "error" {
                                heard.lock().push(said["error"].clone());
                            }
                        }
                        Some(Ok(_)) => {}
                        _ => return,
                    },
                }
            }
        });
        Self { stick, errors, task }
    }

    fn holds(&self, vehicle: u16, stick: Stick) {
        self.stick.send_replace(Some((vehicle, stick)));
    }

    fn lets_go(&self) {
        self.stick.send_replace(None);
    }

    fn was_told(&self, code: &str) -> bool {
        self.errors.lock().iter().any(|error| error["code"] == code)
    }
}

impl Drop for Hand {
    fn drop(&mut self) {
        self.task.abort();
    }
}

fn forward(forward_m_s: f64) -> Stick {
    Stick {
        forward_m_s,
        ..Stick::default()
    }
}

async fn post(swarm: &Swarm, console: &str, path: &str, body: Value) -> Value {
    let url = format!("http://{}{path}", swarm.web_address());
    let request = reqwest::Client::new()
        .post(url)
        .header("skein-console", console)
        .json(&body);
    let answer = request.send().await.unwrap();
    assert!(answer.status().is_success(), "{path}: {}", answer.status());
    answer.json().await.unwrap()
}

async fn steer(swarm: &Swarm, console: &str, vehicle: u16) -> Value {
    let body = json!({ "targets": { "vehicles": [vehicle] }, "command": { "command": "steer" } });
    let answer = post(swarm, console, "/api/v1/commands", body).await;
    answer["receipts"][0]["refusal"].clone()
}

fn vehicle(fleet: &FleetSnapshot, id: u16) -> &skein_view::VehicleSnapshot {
    fleet.vehicles.iter().find(|v| v.id == VehicleId(id)).expect("is known")
}

fn place(fleet: &FleetSnapshot, id: u16) -> PositionNed {
    vehicle(fleet, id).kinematics.expect("it is known where it is").position
}

fn speed_m_s(fleet: &FleetSnapshot, id: u16) -> f64 {
    vehicle(fleet, id).kinematics.map_or(0.0, |k| k.velocity.norm())
}

async fn seconds(swarm: &Swarm, seconds: f64) -> FleetSnapshot {
    let later = swarm.node().now().plus_seconds(seconds);
    let extra = Duration::from_secs_f64(seconds);
    swarm
        .until("some seconds more", extra, |fleet| fleet.time > later)
        .await
}

#[tokio::test(flavor = "multi_thread")]
async fn a_vehicle_goes_where_the_stick_points_and_stands_when_it_is_let_go() {
    let swarm = Swarm::start(2).await;
    let up = swarm.take_off(8.0).await;
    let (hand, other) = (Hand::at(&swarm, "hand").await, Hand::at(&swarm, "other").await);
    let console = json!({ "id": "hand", "name": "Hand" });
    let take = json!({ "targets": { "vehicles": [1] }, "console": console, "action": { "action": "take" } });
    post(&swarm, "hand", "/api/v1/control", take).await;

    // A stick for who is not steered is refused, and moves nothing.
    hand.holds(1, forward(3.0));
    swarm
        .until("told that it is not steered", Duration::ZERO, |_| {
            hand.was_told("wrong_state")
        })
        .await;
    assert!(
        !steer(&swarm, "other", 1).await.is_null(),
        "it is under another's control"
    );
    assert_eq!(steer(&swarm, "hand", 1).await, Value::Null);
    let flies = |fleet: &FleetSnapshot| speed_m_s(fleet, 1) > 2.5;
    let flown = swarm.until("flies by hand", Duration::from_secs(10), flies).await;
    assert_eq!(vehicle(&flown, 1).flight_state, FlightState::GoingTo);
    let kinematics = vehicle(&flown, 1).kinematics.expect("is known");
    let ahead = kinematics.velocity.north_m_s * kinematics.yaw_rad.cos()
        + kinematics.velocity.east_m_s * kinematics.yaw_rad.sin();
    assert!(ahead > 2.4, "forward is along its nose: {kinematics:?}");
    assert!(place(&flown, 2).distance_m(&place(&up, 2)) < 1.0, "nobody else moves");

    // Another console's stick is refused, and changes nothing.
    other.holds(1, forward(-3.0));
    swarm
        .until("the other is refused", Duration::ZERO, |_| {
            other.was_told("no_control_authority")
        })
        .await;
    other.lets_go();

    hand.lets_go();
    let stands = |fleet: &FleetSnapshot| speed_m_s(fleet, 1) < 0.2;
    let stood = swarm.until("stands", Duration::from_secs(10), stands).await;
    let later = seconds(&swarm, 2.0).await;
    assert!(
        place(&later, 1).distance_m(&place(&stood, 1)) < 0.8,
        "it stands where it came to a stand"
    );
    assert!(
        place(&later, 1).distance_m(&place(&up, 1)) > 2.0,
        "and not where it came from"
    );

    // It can be taken up again for a while, and is over when nobody does.
    hand.holds(1, forward(2.0));
    swarm
        .until("flies again", Duration::from_secs(10), |fleet| {
            speed_m_s(fleet, 1) > 1.5
        })
        .await;
    hand.lets_go();
    let holds = |fleet: &FleetSnapshot| vehicle(fleet, 1).flight_state == FlightState::Holding;
    swarm.until("holds", Duration::from_secs(15), holds).await;
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_leader_that_is_steered_takes_its_formation_along() {
    let swarm = Swarm::start(3).await;
    swarm.take_off(8.0).await;
    let request = FormationRequest {
        leader: Some(VehicleId(1)),
        ..FormationRequest::new(Shape::Wedge, 5.0)
    };
    swarm.node().set_formation(request).await.expect("it is flown");
    let formed = |fleet: &FleetSnapshot| {
        let settled = fleet.formation.as_ref().is_some_and(|f| fleet.time > f.settled_at);
        settled
            && [2, 3]
                .iter()
                .all(|id| vehicle(fleet, *id).flight_state == FlightState::Following)
    };
    let before = swarm.until("formed", Duration::from_secs(30), formed).await;
    let hand = Hand::at(&swarm, "hand").await;
    assert_eq!(steer(&swarm, "hand", 1).await, Value::Null);
    hand.holds(1, forward(2.5));
    let moved = |fleet: &FleetSnapshot| (1..=3).all(|id| place(fleet, id).distance_m(&place(&before, id)) > 8.0);
    let flown = swarm
        .until("all of them went along", Duration::from_secs(20), moved)
        .await;
    assert_eq!(vehicle(&flown, 1).flight_state, FlightState::Leading);
    assert_eq!(
        flown.formation.as_ref().map(|f| f.members.len()),
        Some(3),
        "nobody left"
    );
    hand.lets_go();
    let stands = |fleet: &FleetSnapshot| (1..=3).all(|id| speed_m_s(fleet, id) < 0.3);
    let stood = swarm.until("all stand", Duration::from_secs(20), stands).await;
    assert_eq!(vehicle(&stood, 1).flight_state, FlightState::Leading);
    swarm.stop().await;
}

/// How far it is from the middle of the fence, along the axis on which it is farther, in metres.
fn out_m(fleet: &FleetSnapshot, id: u16) -> f64 {
    let place = place(fleet, id);
    place.north_m.abs().max(place.east_m.abs())
}

#[tokio::test(flavor = "multi_thread")]
async fn no_stick_leads_over_a_fence() {
    const FENCE_M: f64 = 30.0;
    let swarm = Swarm::start_with(1, |config, _| {
        let (low, high) = (-FENCE_M, FENCE_M);
        config.safety.fence = Some(skein_config::FenceSettings {
            polygon_m: vec![[low, low], [high, low], [high, high], [low, high]],
            floor_m: -5.0,
            ceiling_m: 30.0,
        });
    })
    .await;
    swarm.take_off(8.0).await;
    let hand = Hand::at(&swarm, "hand").await;
    assert_eq!(steer(&swarm, "hand", 1).await, Value::Null);
    hand.holds(1, forward(6.0));
    let inside = |fleet: &FleetSnapshot| {
        let out_m = out_m(fleet, 1);
        assert!(out_m < FENCE_M, "{out_m} m out");
        out_m
    };
    let flight = Duration::from_secs(30);
    swarm
        .until("fast towards the fence", flight, |fleet| {
            inside(fleet) < FENCE_M && speed_m_s(fleet, 1) > 4.0
        })
        .await;
    // The stick is held on: it comes to a stand at the fence, and is still steered.
    let stands = |fleet: &FleetSnapshot| inside(fleet) > FENCE_M / 2.0 && speed_m_s(fleet, 1) < 0.3;
    swarm.until("stands at the fence", flight, stands).await;
    let later = swarm.node().now().plus_seconds(4.0);
    let still = swarm
        .until("some seconds more", flight, |fleet| {
            inside(fleet) < FENCE_M && fleet.time > later
        })
        .await;
    assert!(speed_m_s(&still, 1) < 0.5, "{} m/s", speed_m_s(&still, 1));
    hand.holds(1, forward(-3.0));
    let from_m = out_m(&still, 1);
    swarm
        .until("comes back", flight, |fleet| inside(fleet) < from_m - 5.0)
        .await;
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_pilot_takes_a_vehicle_out_of_the_hand_that_steers_it() {
    let swarm = Swarm::start(1).await;
    swarm.take_off(8.0).await;
    let hand = Hand::at(&swarm, "hand").await;
    assert_eq!(steer(&swarm, "hand", 1).await, Value::Null);
    hand.holds(1, forward(2.0));
    let flies = |fleet: &FleetSnapshot| speed_m_s(fleet, 1) > 1.5;
    swarm.until("flies by hand", Duration::from_secs(10), flies).await;
    swarm
        .simulation()
        .pilot_mode(1, FlightMode::Position)
        .expect("has a remote control");
    let taken = |fleet: &FleetSnapshot| vehicle(fleet, 1).flight_state == FlightState::PilotControl;
    swarm.until("the pilot has it", Duration::ZERO, taken).await;
    let before = swarm.truth_now().await.vehicle(1).expect("is simulated").setpoints;
    // The stick is held all the time.
    swarm
        .until("told that it is not steered", Duration::ZERO, |_| {
            hand.was_told("wrong_state")
        })
        .await;
    let later = seconds(&swarm, 2.0).await;
    assert_eq!(vehicle(&later, 1).flight_state, FlightState::PilotControl);
    let truth = swarm.truth_now().await;
    let flown = truth.vehicle(1).expect("is simulated");
    assert_eq!((flown.setpoints, flown.mode), (before, FlightMode::Position));
    swarm.stop().await;
}

/// Says a stick over a node until it is told to stop.
fn says(node: NodeHandle, vehicle: VehicleId, stick: Stick) -> (JoinHandle<()>, Arc<Mutex<Option<Refusal>>>) {
    let last = Arc::new(Mutex::new(None));
    let told = last.clone();
    let task = tokio::spawn(async move {
        let mut every = tokio::time::interval(EVERY);
        loop {
            every.tick().await;
            *told.lock() = node.stick(None, vehicle, stick).err();
        }
    });
    (task, last)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_vehicle_of_another_node_is_steered_over_the_swarm() {
    let members = [1, 2].map(|node| Member {
        node,
        priority: Some(node),
        flies: node == 1,
    });
    let folder = tempfile::tempdir().unwrap();
    let flock = Flock::start(&members, folder.path().to_owned(), |_| ()).await;
    let id = VehicleId(1);
    let ready = |fleet: &FleetSnapshot| {
        let known =
            |v: &skein_view::VehicleSnapshot| v.id == id && v.ready_to_arm == Some(true) && v.kinematics.is_some();
        let led = fleet
            .swarm
            .as_ref()
            .is_some_and(|swarm| swarm.leader_state == LeaderStateKind::Led);
        led && fleet.vehicles.iter().any(known)
    };
    flock.until(1, "ready", Duration::from_secs(20), ready).await;
    flock
        .until(2, "the other's vehicle is known", Duration::from_secs(20), ready)
        .await;
    let (ground, one) = (flock.node(2), Targets::Vehicles(vec![id]));
    // Its autopilot is ready a little before its node has checked all that it checks.
    skein_testkit::eventually(skein_testkit::patience(), "taken off", async || {
        let receipts = ground.command(&one, VehicleCommand::TakeOff { height_m: 6.0 }).await;
        (receipts[0].refusal.is_none()).then_some(())
    })
    .await;
    let holds = |fleet: &FleetSnapshot| vehicle(fleet, 1).flight_state == FlightState::Holding;
    flock.until(2, "up", Duration::from_secs(40), holds).await;

    let (task, last) = says(flock.node(2), id, forward(2.0));
    let refused = |_: &FleetSnapshot| matches!(*last.lock(), Some(Refusal::WrongState { .. }));
    flock
        .until(
            2,
            "told by the other node that it is not steered",
            Duration::from_secs(5),
            refused,
        )
        .await;
    let receipts = ground.command(&one, VehicleCommand::Steer).await;
    assert_eq!(receipts[0].refusal, None);
    let flies = |fleet: &FleetSnapshot| speed_m_s(fleet, 1) > 1.6;
    flock.until(1, "flies by hand", Duration::from_secs(10), flies).await;
    assert_eq!(*last.lock(), None);
    task.abort();
    let stands = |fleet: &FleetSnapshot| speed_m_s(fleet, 1) < 0.2;
    flock.until(1, "stands", Duration::from_secs(10), stands).await;
    flock.stop().await;
}
