//! Several nodes as one swarm: each flies a vehicle, one coordinates, all are seen and commanded at any of them; another one takes over
//! when the coordinator is gone.

use skein_domain::fence::{AltitudeReference, BreachAction, FencePlan, FenceZone, ZoneKind, ZoneOutline};
use skein_domain::{FlightState, FormationRequest, NodeId, PositionNed, Route, Shape, VehicleCommand, VehicleId};
use skein_runtime::Targets;
use skein_testkit::{Flock, LONGEST_GAP_S, Member, eventually, patience};
use skein_view::FleetSnapshot;
use skein_view::LeaderStateKind;
use std::time::Duration;

/// The ground station: coordinates before all others, and flies nothing.
const GROUND: u8 = 9;

fn members() -> Vec<Member> {
    let vehicle = |node: u8| Member {
        node,
        priority: Some(10 + node),
        flies: true,
    };
    let mut members: Vec<Member> = (1..=4).map(vehicle).collect();
    members.push(Member {
        node: GROUND,
        priority: Some(200),
        flies: false,
    });
    members
}

fn coordinator(fleet: &FleetSnapshot) -> Option<NodeId> {
    let swarm = fleet.swarm.as_ref()?;
    swarm
        .term
        .filter(|_| swarm.leader_state == LeaderStateKind::Led)
        .map(|term| term.coordinator)
}

fn all_are(fleet: &FleetSnapshot, count: usize, states: &[FlightState]) -> bool {
    fleet.vehicles.len() == count && fleet.vehicles.iter().all(|v| states.contains(&v.flight_state))
}

async fn up(flock: &Flock) {
    let ready = |fleet: &FleetSnapshot| {
        coordinator(fleet).is_some()
            && fleet.vehicles.len() == 4
            && fleet
                .vehicles
                .iter()
                .all(|v| v.ready_to_arm == Some(true) && v.kinematics.is_some())
    };
    for node in flock.running() {
        flock
            .until(
                node,
                "all vehicles seen and ready, and a coordinator",
                Duration::from_secs(10),
                ready,
            )
            .await;
    }
    // Whoever was there first coordinates; the ground station only if it is asked to.
    let ground = NodeId(u64::from(GROUND));
    flock
        .node(1)
        .make_coordinator(ground)
        .await
        .expect("it takes the leadership");
    for node in flock.running() {
        let led = |fleet: &FleetSnapshot| coordinator(fleet) == Some(ground);
        flock
            .until(node, "the ground station coordinates", Duration::ZERO, led)
            .await;
    }
    // Each is asked by the node that flies it: what that has not heard yet it refuses.
    for node in flock.running() {
        let permits = |_: &FleetSnapshot| flock.node(node).preflight().is_green();
        flock
            .until(
                node,
                "its preflight report permits arming",
                Duration::from_secs(10),
                permits,
            )
            .await;
    }
    flock.judge();
    let receipts = flock
        .node(GROUND)
        .command(&Targets::All, VehicleCommand::TakeOff { height_m: 12.0 })
        .await;
    assert_eq!(receipts.len(), 4, "{receipts:?}");
    assert!(receipts.iter().all(|receipt| receipt.refusal.is_none()), "{receipts:?}");
    flock
        .until(GROUND, "all up", Duration::from_secs(40), |fleet| {
            all_are(fleet, 4, &[FlightState::Holding])
        })
        .await;
}

const IN_FORMATION: [FlightState; 2] = [FlightState::Following, FlightState::Leading];

/// Whoever coordinates has to see them all as free to fly in formation: it takes those that it sees.
async fn all_free(flock: &Flock, at: u8) {
    let leads = coordinator(&flock.node(at).snapshot()).expect("somebody coordinates");
    let leads = u8::try_from(leads.0).expect("a node of the flock");
    let free = |fleet: &FleetSnapshot| {
        let is_free = |v: &skein_view::VehicleSnapshot| {
            let ordered = v.failsafe.as_ref().is_some_and(|failsafe| failsafe.order.is_some());
            v.link.connected && v.flight_state.is_available_in_air() && !ordered
        };
        fleet.vehicles.len() == 4 && fleet.vehicles.iter().all(is_free)
    };
    let what = "all free for the coordinator";
    let seen = flock.until(leads, what, Duration::from_secs(10), free).await;
    // What it plans with is of the control period before the picture.
    let later = seen.time.plus_seconds(0.5);
    let still = move |fleet: &FleetSnapshot| fleet.time > later && free(fleet);
    flock.until(leads, what, Duration::from_secs(10), still).await;
}

async fn form(flock: &Flock, at: u8, shape: Shape) {
    all_free(flock, at).await;
    let request = FormationRequest {
        leader: Some(VehicleId(1)),
        ..FormationRequest::new(shape, 6.0)
    };
    let receipt = flock.node(at).set_formation(request).await.expect("it is flown");
    assert_eq!(receipt.members.len(), 4, "{}", flock.told(at));
    let formed = |fleet: &FleetSnapshot| {
        all_are(fleet, 4, &IN_FORMATION)
            && fleet.formation.as_ref().is_some_and(|f| fleet.time > f.settled_at)
            && fleet
                .vehicles
                .iter()
                .all(|v| v.tracking_error_m.is_none_or(|m| m < 1.0))
    };
    flock.until(at, "formed", Duration::from_secs(30), formed).await;
}

async fn fly_route(flock: &Flock, route: Route) {
    flock.node(GROUND).set_route(route).await.expect("the leader flies it");
    let under_way = |fleet: &FleetSnapshot| {
        let leader = fleet.vehicles.iter().find(|v| v.is_leader);
        leader
            .and_then(|v| v.kinematics)
            .is_some_and(|k| k.velocity.norm() > 2.0)
    };
    flock
        .until(2, "the leader flies its route", Duration::from_secs(20), under_way)
        .await;
}

/// The coordinator's computer fails. Nobody stops, and another node goes on: gives which one. The best suited is the first to try, but on a machine
/// where its process waits for its turn another one may be quicker.
async fn lose_the_ground_station(flock: &mut Flock) -> NodeId {
    let before = flock
        .node(2)
        .swarm()
        .and_then(|swarm| swarm.term)
        .expect("a term")
        .number;
    flock.end(GROUND).await;
    let flock = &*flock;
    let successor = eventually(patience(), "all obey one of them", async || {
        let terms = [1, 2, 3, 4].map(|node| flock.node(node).swarm().and_then(|swarm| swarm.term));
        let [Some(first), ..] = terms else { return None };
        let agreed = terms.iter().all(|term| *term == Some(first));
        let is_other = first.coordinator != NodeId(u64::from(GROUND)) && first.number > before;
        (agreed && is_other).then_some(first.coordinator)
    })
    .await;
    let flies_on = |fleet: &FleetSnapshot| coordinator(fleet) == Some(successor) && all_are(fleet, 4, &IN_FORMATION);
    let what = format!("the formation flies on under node {successor}");
    for node in [1, 2, 3, 4] {
        flock.until(node, &what, Duration::from_secs(10), flies_on).await;
    }
    successor
}

/// It is back. It does not take the leadership from one that does it; only when it is asked.
async fn bring_the_ground_station_back(flock: &mut Flock, successor: NodeId) {
    let ground = NodeId(u64::from(GROUND));
    flock.begin(GROUND).await;
    let seen = |fleet: &FleetSnapshot| coordinator(fleet) == Some(successor) && fleet.vehicles.len() == 4;
    flock
        .until(GROUND, "the swarm, from the ground", Duration::from_secs(10), seen)
        .await;
    flock
        .node(2)
        .make_coordinator(ground)
        .await
        .expect("it takes the leadership");
    let back = |fleet: &FleetSnapshot| coordinator(fleet) == Some(ground) && all_are(fleet, 4, &IN_FORMATION);
    flock
        .until(1, "the ground station coordinates again", Duration::from_secs(10), back)
        .await;
}

#[tokio::test(flavor = "multi_thread")]
async fn four_vehicles_on_four_computers_fly_as_one_swarm_and_another_node_takes_over() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut flock = Flock::start(&members(), folder.path().to_owned(), |_| ()).await;
    up(&flock).await;
    form(&flock, GROUND, Shape::Wedge).await;
    let waypoints = vec![PositionNed::new(60.0, 0.0, -12.0), PositionNed::new(60.0, 60.0, -12.0)];
    let route = Route {
        waypoints,
        speed_m_s: 4.0,
        corner_radius_m: 8.0,
    };
    fly_route(&flock, route).await;
    let successor = lose_the_ground_station(&mut flock).await;
    let end = |fleet: &FleetSnapshot| fleet.formation.as_ref().is_some_and(|f| f.route_finished);
    flock
        .until(4, "the end of the route", Duration::from_secs(60), end)
        .await;
    // Asked at a node that does not coordinate.
    form(&flock, 2, Shape::Line).await;
    bring_the_ground_station_back(&mut flock, successor).await;
    form(&flock, GROUND, Shape::Wedge).await;

    let receipts = flock.node(3).command(&Targets::All, VehicleCommand::Land).await;
    assert!(receipts.iter().all(|receipt| receipt.refusal.is_none()), "{receipts:?}");
    let down = |fleet: &FleetSnapshot| fleet.vehicles.iter().all(|v| !v.armed);
    flock.until(GROUND, "all landed", Duration::from_secs(60), down).await;
    assert!(flock.nearest().distance_m > 2.0, "{}", flock.nearest());
    println!("nearest {}", flock.nearest());
    for node in [1, 2, 3, 4] {
        let truth = flock.simulation(node).truth();
        let gaps = truth.vehicles.iter().map(|v| v.offboard_gap_sender_max_s);
        let gap_s = gaps.fold(0.0, f64::max);
        assert!(gap_s < LONGEST_GAP_S, "vehicle {node}: {gap_s} s without a setpoint");
    }
    flock.stop().await;
}

/// Asks a node's API about a vehicle's payloads.
async fn payloads(flock: &Flock, node: u8, vehicle: u8) -> (u16, String) {
    let address = flock.web_address(node);
    let url = format!("http://{address}/api/v1/vehicles/{vehicle}/payloads");
    let answer = reqwest::get(url).await.expect("an answer");
    (answer.status().as_u16(), answer.text().await.expect("a body"))
}

/// Fences that are set at one node hold at all of them.
async fn fences_everywhere(flock: &Flock) {
    let pond = FenceZone {
        name: "pond".into(),
        kind: ZoneKind::Exclusion,
        outline: ZoneOutline::LocalCircle {
            centre_m: [80.0, 80.0],
            radius_m: 15.0,
        },
        floor_m: None,
        ceiling_m: None,
        altitude_reference: AltitudeReference::default(),
        action: BreachAction::default(),
    };
    let plan = FencePlan {
        zones: vec![pond],
        ..FencePlan::default()
    };
    flock.node(2).set_fences(plan.clone()).await.expect("they are set");
    for node in flock.running() {
        let handle = flock.node(node);
        skein_testkit::eventually(skein_testkit::patience(), "the fences everywhere", async || {
            (handle.fences().plan == plan).then_some(())
        })
        .await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_vehicle_is_asked_and_guarded_wherever_an_operator_sits() {
    let folder = tempfile::tempdir().expect("a folder");
    let flock = Flock::start(&members(), folder.path().to_owned(), |config| {
        if let Some(rule) = config.adopt.first_mut() {
            rule.payloads = vec![skein_config::PayloadRule {
                name: "radio".into(),
                plugin: "radio".into(),
                isolation: skein_config::Isolation::InProcess,
                transport: None,
                on_failure: skein_config::Escalation::Degrade,
                config: serde_json::json!({}),
            }];
        }
    })
    .await;
    let ready = |fleet: &FleetSnapshot| {
        coordinator(fleet).is_some() && fleet.vehicles.len() == 4 && fleet.vehicles.iter().all(|v| v.home.is_some())
    };
    let what = "all vehicles seen";
    flock.until(GROUND, what, Duration::from_secs(10), ready).await;
    let whole = |fleet: &FleetSnapshot| {
        let nodes = fleet.swarm.as_ref().map_or(&[][..], |swarm| &swarm.nodes[..]);
        nodes.len() == 4 && nodes.iter().all(|node| node.loss.is_some_and(|loss| loss < 0.001))
    };
    let what = "nothing is lost on the way from any node";
    flock.until(GROUND, what, Duration::from_secs(20), whole).await;
    // What only the vehicle's own node knows comes from there.
    let (status, text) = payloads(&flock, GROUND, 3).await;
    assert!(status == 200 && text.contains("\"radio\""), "{status} {text}");
    let reports = flock.node(GROUND).preflight_everywhere().await;
    assert_eq!(reports.vehicles.iter().filter_map(|r| r.vehicle).count(), 4);
    fences_everywhere(&flock).await;
    // The emergency stop reaches vehicles of other nodes.
    let key = flock.node(GROUND).unlock_emergency_stop().key;
    let receipts = flock
        .node(GROUND)
        .emergency_stop(&key, &Targets::All)
        .await
        .expect("is unlocked");
    assert!(
        receipts.len() == 4 && receipts.iter().all(|r| r.refusal.is_none()),
        "{receipts:?}"
    );
    let stopped = |fleet: &FleetSnapshot| fleet.vehicles.iter().all(|v| v.stopped);
    flock
        .until(GROUND, "all stopped", Duration::from_secs(5), stopped)
        .await;
    flock.stop().await;
}

/// Where the vehicles of these nodes really are, and how fast.
fn speeds_m_s(flock: &Flock, nodes: &[u8]) -> Vec<f64> {
    let speed = |node: &u8| {
        flock
            .simulation(*node)
            .truth()
            .vehicles
            .iter()
            .map(|v| v.velocity.norm())
            .fold(0.0, f64::max)
    };
    nodes.iter().map(speed).collect()
}

/// The part that misses the coordinator has one of its own, which it agrees about, and stands. That is the best of it, unless the
/// machine kept that one from running when it mattered.
async fn hold_apart(flock: &Flock, part: &[u8]) -> u8 {
    let of_part = |fleet: &FleetSnapshot| {
        let by = coordinator(fleet)?;
        part.iter().copied().find(|node| NodeId(u64::from(*node)) == by)
    };
    let stand = |fleet: &FleetSnapshot, by: Option<u8>| {
        let here = |id: u16| part.iter().any(|node| u16::from(*node) == id);
        let mut own = fleet.vehicles.iter().filter(|v| here(v.id.0));
        let stands = own
            .all(|v| v.flight_state == FlightState::Holding && v.kinematics.is_some_and(|k| k.velocity.norm() < 0.5));
        let agreed = of_part(fleet).filter(|of_part| by.is_none_or(|by| by == *of_part));
        stands && agreed.is_some()
    };
    let what = "a coordinator of their own, and all hold";
    let mut by = None;
    for node in part {
        let seen = flock
            .until(*node, what, Duration::from_secs(10), |fleet| stand(fleet, by))
            .await;
        by = of_part(&seen);
    }
    by.expect("it was waited for")
}

/// All of them in one formation, led by this node.
async fn together(flock: &Flock, by: u8) {
    let together = |fleet: &FleetSnapshot| {
        let settled = |f: &skein_view::FormationSnapshot| f.members.len() == 4 && fleet.time > f.settled_at;
        let all = fleet.formation.as_ref().is_some_and(settled);
        all && all_are(fleet, 4, &IN_FORMATION) && coordinator(fleet) == Some(NodeId(u64::from(by)))
    };
    for node in flock.running() {
        flock
            .until(node, "one formation again", Duration::from_secs(40), together)
            .await;
    }
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test integration`"]
async fn a_swarm_that_comes_apart_keeps_its_distances_and_flies_on_when_it_is_together_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let flock = Flock::start(&members(), folder.path().to_owned(), |_| ()).await;
    up(&flock).await;
    form(&flock, GROUND, Shape::Wedge).await;
    let route = Route {
        waypoints: vec![PositionNed::new(150.0, 0.0, -12.0)],
        speed_m_s: 3.0,
        corner_radius_m: 8.0,
    };
    fly_route(&flock, route).await;

    // The ground station and two vehicles here, two there.
    flock.part(&[3, 4]);
    let first = hold_apart(&flock, &[3, 4]).await;
    // The others still hear their coordinator: they keep their places and fly on.
    let alone = move |fleet: &FleetSnapshot| {
        let here = fleet.formation.as_ref().is_some_and(|f| f.members.len() == 2);
        here && coordinator(fleet) == Some(NodeId(u64::from(GROUND)))
    };
    flock
        .until(GROUND, "the others fly on", Duration::from_secs(20), alone)
        .await;
    assert!(speeds_m_s(&flock, &[3, 4]).iter().all(|v| *v < 1.0));

    flock.join();
    together(&flock, first).await;

    // The coordinator has the ground station on its side, but no other vehicle: those who miss it could think that only its computer failed.
    flock.part(&[first, GROUND]);
    let others: Vec<u8> = (1..=4).filter(|node| *node != first).collect();
    let second = hold_apart(&flock, &others).await;
    assert!(speeds_m_s(&flock, &others).iter().all(|v| *v < 1.0));
    flock.join();
    together(&flock, second).await;
    assert!(flock.nearest().distance_m > 2.0, "{}", flock.nearest());
    println!("nearest {}", flock.nearest());
    flock.stop().await;
}

/// A vehicle's node is cut off from all others and together with them again; its vehicle holds meanwhile, and is taken back.
async fn cut_off(flock: &Flock, node: u8) {
    flock.part(&[node]);
    let vehicle = VehicleId(u16::from(node));
    let alone = move |fleet: &FleetSnapshot| {
        let own = fleet.vehicles.iter().find(|v| v.id == vehicle);
        let cut_off = fleet.swarm.as_ref().is_some_and(|swarm| swarm.cut_off);
        let stands = |v: &skein_view::VehicleSnapshot| v.kinematics.is_some_and(|k| k.velocity.norm() < 0.5);
        cut_off && own.is_some_and(|v| v.flight_state == FlightState::Holding && stands(v))
    };
    let what = "who hears nobody holds";
    flock.until(node, what, Duration::from_secs(10), alone).await;
    let without = |fleet: &FleetSnapshot| {
        coordinator(fleet) == Some(NodeId(u64::from(GROUND)))
            && fleet.formation.as_ref().is_some_and(|f| f.members.len() == 3)
    };
    let what = "the others close up";
    flock.until(GROUND, what, Duration::from_secs(20), without).await;
    assert!(speeds_m_s(flock, &[node]).iter().all(|v| *v < 1.0));
    flock.join();
    let with = |fleet: &FleetSnapshot| {
        fleet.formation.as_ref().is_some_and(|f| f.members.len() == 4) && all_are(fleet, 4, &IN_FORMATION)
    };
    let what = "it is taken back";
    flock.until(GROUND, what, Duration::from_secs(30), with).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_node_that_is_cut_off_holds_and_is_taken_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let flock = Flock::start(&members(), folder.path().to_owned(), |_| ()).await;
    up(&flock).await;
    form(&flock, GROUND, Shape::Wedge).await;
    cut_off(&flock, 3).await;

    // Now the leader's node coordinates, and is cut off while it flies a route: the others do not know that it stops.
    let first = |fleet: &FleetSnapshot| coordinator(fleet) == Some(NodeId(1));
    flock
        .node(1)
        .make_coordinator(NodeId(1))
        .await
        .expect("it takes the leadership");
    let what = "the leader's node coordinates";
    flock.until(GROUND, what, Duration::from_secs(10), first).await;
    form(&flock, GROUND, Shape::Wedge).await;
    let route = Route {
        waypoints: vec![PositionNed::new(150.0, 0.0, -12.0)],
        speed_m_s: 3.0,
        corner_radius_m: 8.0,
    };
    fly_route(&flock, route).await;
    cut_off(&flock, 1).await;
    assert!(flock.nearest().distance_m > 2.0, "{}", flock.nearest());
    println!("nearest {}", flock.nearest());
    flock.stop().await;
}
