//! One fault after the other in flights of a ground station and five vehicles, each on a host of its own. What is expected of each
//! stands in the README beside this crate. Whatever happens: the distance between vehicles is kept, everyone stays inside of the fence,
//! and no vehicle whose own node runs is without setpoints for longer than 200 ms.

use reqwest::Method;
use serde_json::json;
use skein_domain::Shape;
use skein_tests_multihost::field::{Field, GROUND, stranger, usual};
use skein_tests_multihost::host::{LogLine, Plan, Transport, now_s};
use skein_tests_multihost::mission::Mission;
use skein_tests_multihost::relay::Quality;

/// Found each other and chosen a coordinator within this, in seconds; in a bad air the longer one.
const TOGETHER_S: f64 = 30.0;
const TOGETHER_IN_BAD_AIR_S: f64 = 60.0;
/// The vehicle whose node coordinates at first: the best suited.
const COORDINATOR: u8 = 2;
/// Where Zenoh's links are.
const ZENOH_PORT: u16 = 7447;
/// A transport over which nothing has come for so long has failed, in seconds.
const WAY_SILENT_S: f64 = 3.0;
/// Another one.
const VEHICLE: u8 = 5;
const ALL: [u8; 6] = [1, 2, 3, 4, 5, 6];
const BAD_AIR: Quality = Quality {
    loss: 0.3,
    delay_s: 0.2,
    jitter_s: 0.05,
    doubled: 0.0,
    overtaken: 0.0,
};

/// The usual swarm, in contact, up, and in a line.
async fn in_the_air(seed: u64) -> Field {
    in_the_air_with(seed, usual()).await
}

async fn in_the_air_with(seed: u64, plans: Vec<Plan>) -> Field {
    let mut field = Field::start(seed, plans);
    field.led_by(COORDINATOR, &ALL, TOGETHER_S).await;
    let mut mission = Mission::new(&mut field, GROUND);
    mission.take_off().await;
    mission.form_up(Shape::Line).await;
    field
}

/// What every flight ends with: back over the field in another shape, down, and judged.
async fn home(mut field: Field, gateway: u8, vehicles: Vec<u8>, flight: &str) {
    let others = without_all(&field.vehicles(), &vehicles);
    come_home(Mission::of(&mut field, gateway, vehicles)).await;
    field.end(flight, &others).await;
}

/// The same by an operator at the ground station who asks again.
async fn home_in_bad_air(mut field: Field, vehicles: Vec<u8>, flight: &str) {
    let others = without_all(&field.vehicles(), &vehicles);
    come_home(Mission::of(&mut field, GROUND, vehicles).in_bad_air()).await;
    field.end(flight, &others).await;
}

async fn come_home(mut mission: Mission<'_>) {
    mission.form_up(Shape::Wedge).await;
    mission.land().await;
}

fn without_all(all: &[u8], these: &[u8]) -> Vec<u8> {
    all.iter().copied().filter(|n| !these.contains(n)).collect()
}

fn without(all: &[u8], one: u8) -> Vec<u8> {
    without_all(all, &[one])
}

#[tokio::test(flavor = "multi_thread")]
async fn undisturbed() {
    let mut field = in_the_air(1).await;
    let mut mission = Mission::new(&mut field, GROUND);
    let (leader, to) = mission.set_out(40.0, 20.0).await;
    mission.arrives(leader, to).await;
    mission.stands_as(Shape::Line).await;
    let vehicles = field.vehicles();
    home(field, GROUND, vehicles, "undisturbed").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn over_dds() {
    let mut plans = usual();
    for plan in &mut plans {
        plan.transport = Transport::Dds;
    }
    let mut field = Field::start(2, plans);
    field.led_by(COORDINATOR, &ALL, TOGETHER_S).await;
    let mut mission = Mission::new(&mut field, GROUND);
    mission.take_off().await;
    let vehicles = field.vehicles();
    home(field, GROUND, vehicles, "over DDS").await;
}

/// Whether a host's transports take what it sends and something has come over them lately, in the order of its configuration.
async fn ways(field: &Field, host: u8) -> Vec<bool> {
    let swarm = field.host(host).operator().swarm().await;
    let works =
        |way: &serde_json::Value| way["up"] == true && way["heard_s"].as_f64().is_some_and(|s| s < WAY_SILENT_S);
    swarm["ways"]
        .as_array()
        .map_or_else(Vec::new, |ways| ways.iter().map(works).collect())
}

#[tokio::test(flavor = "multi_thread")]
async fn one_of_two_transports_fails_and_the_other_one_carries_on() {
    let mut plans = usual();
    for plan in &mut plans {
        plan.transport = Transport::Both;
    }
    let mut field = Field::start(15, plans);
    field.led_by(COORDINATOR, &ALL, TOGETHER_S).await;
    let term = field.host(GROUND).operator().swarm().await["term"].clone();
    let mut mission = Mission::new(&mut field, GROUND);
    mission.take_off().await;
    mission.form_up(Shape::Line).await;
    for host in ALL {
        let both = async |field: &mut Field| ways(field, host).await == [true, true];
        field
            .until("something comes over both transports", TOGETHER_S, both)
            .await;
    }
    let mut mission = Mission::new(&mut field, GROUND);
    let (leader, to) = mission.set_out(40.0, 20.0).await;
    field.pass(2.0).await;
    field.air().close_port(ZENOH_PORT);
    for host in ALL {
        let second = async |field: &mut Field| ways(field, host).await == [false, true];
        field.until("one transport is silent", TOGETHER_S, second).await;
    }
    let mut mission = Mission::new(&mut field, GROUND);
    mission.arrives(leader, to).await;
    mission.stands_as(Shape::Line).await;
    field.led_by(COORDINATOR, &ALL, TOGETHER_S).await;
    let now = field.host(GROUND).operator().swarm().await["term"].clone();
    assert_eq!(now, term, "nobody was missed");
    field.air().open_ports();
    let vehicles = field.vehicles();
    home(field, GROUND, vehicles, "one of two transports fails").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_coordinator_is_cut_off_and_comes_back() {
    let mut field = in_the_air(16).await;
    let mut mission = Mission::new(&mut field, GROUND);
    mission.set_out(40.0, 20.0).await;
    field.pass(2.0).await;
    field.air().part(&[COORDINATOR]);
    let rest = without(&ALL, COORDINATOR);
    field.led_by(COORDINATOR + 1, &rest, TOGETHER_S).await;
    // it stops where it is; the others fly on, unseen by it
    let stands = async |field: &mut Field| field.places(&[COORDINATOR]).iter().all(|(_, v)| v.norm() < 0.5);
    field.until("it stands", TOGETHER_S, stands).await;
    field.pass(8.0).await;
    assert!(stands(&mut field).await, "it is standing still");
    field.air().join();
    field.one_swarm(&ALL, TOGETHER_S).await;
    let vehicles = field.vehicles();
    home(field, GROUND, vehicles, "coordinator cut off").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_coordinator_is_killed_on_the_way() {
    let mut field = in_the_air(3).await;
    let mut mission = Mission::new(&mut field, GROUND);
    mission.set_out(40.0, 20.0).await;
    field.pass(2.0).await;
    field.host_mut(COORDINATOR).kill().await;
    let rest = without(&ALL, COORDINATOR);
    let successor = field.one_swarm(&rest, TOGETHER_S).await;
    assert_eq!(successor, COORDINATOR + 1, "the best suited that is left");
    field.pass(5.0).await;
    let vehicles = without(&field.vehicles(), COORDINATOR);
    home(field, GROUND, vehicles, "coordinator killed").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_vehicles_node_is_killed_and_comes_back_with_its_old_state() {
    let mut field = in_the_air(4).await;
    let old = field.host(VEHICLE).state();
    let mut mission = Mission::new(&mut field, GROUND);
    mission.set_out(40.0, 20.0).await;
    field.pass(2.0).await;
    field.host_mut(VEHICLE).kill().await;
    field.one_swarm(&without(&ALL, VEHICLE), TOGETHER_S).await;
    // the others have a new coordinator, and so a new term, before it is back with the old one
    let ask = json!({ "node": COORDINATOR + 1 });
    let answer = field.host(GROUND).operator();
    let answer = answer.ask(Method::POST, "/api/v1/swarm/coordinator", Some(ask)).await;
    assert!(answer.is_success(), "{answer:?}");
    field.host(VEHICLE).put_back(&old);
    field.host_mut(VEHICLE).restart();
    assert_eq!(field.one_swarm(&ALL, TOGETHER_S).await, COORDINATOR + 1);
    field.pass(3.0).await;
    let vehicles = without(&field.vehicles(), VEHICLE);
    let mut mission = Mission::of(&mut field, GROUND, vehicles);
    mission.form_up(Shape::Wedge).await;
    // the vehicle that was alone is taken up again and comes down with the others
    let mut mission = Mission::new(&mut field, GROUND);
    mission.land().await;
    field.end("vehicle node killed, old state", &[]).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn nodes_are_killed_and_back_at_once_and_their_vehicles_fly_on_with_the_others() {
    let mut plans = usual();
    plans.iter_mut().for_each(|plan| plan.resume = "fly_on");
    let mut field = in_the_air_with(15, plans).await;
    let ways = [(40.0, 20.0), (-40.0, 0.0), (40.0, -20.0), (-40.0, 0.0)];
    // back before the others miss it, and after that; a member's and the coordinator's, whose vehicle leads
    let ends = [(VEHICLE, 0.2), (VEHICLE, 3.0), (COORDINATOR, 0.2), (COORDINATOR, 3.0)];
    for ((north_m, east_m), (node, away_s)) in ways.into_iter().zip(ends) {
        let mut mission = Mission::new(&mut field, GROUND);
        mission.set_out(north_m, east_m).await;
        field.pass(2.0).await;
        field.host_mut(node).kill().await;
        field.pass(away_s).await;
        field.host_mut(node).restart();
        field.one_swarm(&ALL, TOGETHER_S).await;
        let mut mission = Mission::new(&mut field, GROUND);
        mission.stands_as(Shape::Line).await;
        println!("node {node}, away for {away_s} s: in the line again");
    }
    for node in [VEHICLE, COORDINATOR] {
        let said = field.host(node).said();
        assert_eq!(said.matches("1 of 1 vehicles taken back").count(), 2, "{said}");
    }
    let vehicles = field.vehicles();
    home(field, GROUND, vehicles, "nodes killed and back at once").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_ground_station_is_killed() {
    let mut field = in_the_air(5).await;
    let mut mission = Mission::new(&mut field, GROUND);
    let (leader, to) = mission.set_out(40.0, 20.0).await;
    field.pass(2.0).await;
    field.host_mut(GROUND).kill().await;
    let mut mission = Mission::new(&mut field, VEHICLE);
    mission.arrives(leader, to).await;
    mission.stands_as(Shape::Line).await;
    assert_eq!(field.one_swarm(&without(&ALL, GROUND), TOGETHER_S).await, COORDINATOR);
    let vehicles = field.vehicles();
    // the operator goes on at the gateway of a vehicle
    home(field, VEHICLE, vehicles, "ground station killed").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn three_on_each_side_and_together_again() {
    let mut field = in_the_air(6).await;
    let (near, far) = ([GROUND, 2, 3], [4, 5, 6]);
    field.air().part(&near);
    let one = field.one_swarm(&near, TOGETHER_S).await;
    let other = field.one_swarm(&far, TOGETHER_S).await;
    assert_eq!(
        (one, other),
        (COORDINATOR, 4),
        "each part has the best suited of its own"
    );
    field.pass(10.0).await;
    field.air().join();
    field.one_swarm(&ALL, TOGETHER_S).await;
    let vehicles = field.vehicles();
    home(field, GROUND, vehicles, "partition 3|3").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_part_without_a_majority_goes_on_with_what_it_has() {
    let mut plans = usual();
    for plan in &mut plans {
        plan.apart = "majority";
    }
    let mut field = Field::start(7, plans);
    field.led_by(COORDINATOR, &ALL, TOGETHER_S).await;
    let mut mission = Mission::new(&mut field, GROUND);
    mission.take_off().await;
    mission.form_up(Shape::Line).await;
    field.air().part(&[5, 6]);
    assert_eq!(field.one_swarm(&[1, 2, 3, 4], TOGETHER_S).await, COORDINATOR);
    field.pass(5.0).await;
    for number in [5, 6] {
        assert!(!field.host(number).operator().acts().await, "two of six choose nobody");
    }
    field.air().join();
    field.one_swarm(&ALL, TOGETHER_S).await;
    let vehicles = field.vehicles();
    home(field, GROUND, vehicles, "two of six apart").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_link_goes_one_way_only() {
    let mut field = in_the_air(8).await;
    // the coordinator is not heard by one vehicle; the others pass its pulses on
    field.air().cut(COORDINATOR, VEHICLE, true);
    field.pass(10.0).await;
    let obeyed = field.host(VEHICLE).operator().swarm().await;
    assert_eq!(obeyed["leader_state"], "led", "{obeyed}");
    field.air().join();
    field.one_swarm(&ALL, TOGETHER_S).await;
    let vehicles = field.vehicles();
    home(field, GROUND, vehicles, "one-way link").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_third_is_lost_and_the_rest_is_late() {
    let mut field = in_the_air(9).await;
    field.air().everywhere(BAD_AIR);
    let mut mission = Mission::new(&mut field, GROUND).in_bad_air();
    let (_, to) = mission.set_out(40.0, 0.0).await;
    mission.whoever_leads_arrives(to).await;
    field.one_swarm(&ALL, TOGETHER_IN_BAD_AIR_S).await;
    let vehicles = field.vehicles();
    home_in_bad_air(field, vehicles, "30 % loss, 200 ms, jitter").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_radio_is_slow() {
    let mut plans = usual();
    for plan in &mut plans {
        // 32 kB/s of uplink; what is for all goes to each of the five others by itself, with the headers of three layers
        plan.max_bytes_per_s = Some(24_000.0);
    }
    let mut field = Field::start(10, plans);
    field.network().limit_rate(Some(256));
    field.one_swarm(&ALL, TOGETHER_IN_BAD_AIR_S).await;
    let mut mission = Mission::new(&mut field, GROUND);
    mission.take_off().await;
    mission.form_up(Shape::Line).await;
    let (leader, to) = mission.set_out(40.0, 0.0).await;
    mission.arrives(leader, to).await;
    let vehicles = field.vehicles();
    home(field, GROUND, vehicles, "256 kbit/s").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn datagrams_come_twice_and_overtake_each_other() {
    let mut field = in_the_air(11).await;
    field.air().everywhere(Quality {
        delay_s: 0.01,
        jitter_s: 0.04,
        doubled: 0.3,
        overtaken: 0.3,
        loss: 0.0,
    });
    let mut mission = Mission::new(&mut field, GROUND);
    let (leader, to) = mission.set_out(40.0, 0.0).await;
    mission.arrives(leader, to).await;
    let vehicles = field.vehicles();
    home(field, GROUND, vehicles, "doubled and overtaken").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn clocks_are_stepped_by_five_seconds_in_flight() {
    let mut plans = usual();
    for number in [COORDINATOR, VEHICLE] {
        plans[usize::from(number) - 1].steppable_clock = true;
    }
    let mut field = Field::start(12, plans);
    field.led_by(COORDINATOR, &ALL, TOGETHER_S).await;
    let mut mission = Mission::new(&mut field, GROUND);
    mission.take_off().await;
    mission.form_up(Shape::Line).await;
    let (leader, to) = mission.set_out(40.0, 0.0).await;
    field.pass(2.0).await;
    field.host(COORDINATOR).step_clock(5);
    field.host(VEHICLE).step_clock(-5);
    let mut mission = Mission::new(&mut field, GROUND);
    mission.arrives(leader, to).await;
    mission.stands_as(Shape::Line).await;
    mission.ask_formation(Shape::Grid).await;
    field.pass(0.5).await;
    let late = |line: &LogLine| line.seconds_after(now_s()).is_some_and(|s| s > 2.0);
    assert!(
        field.host(COORDINATOR).lines().iter().any(late),
        "its clock was stepped"
    );
    assert_eq!(field.one_swarm(&ALL, TOGETHER_S).await, COORDINATOR, "nothing changes");
    let vehicles = field.vehicles();
    home(field, GROUND, vehicles, "clocks stepped by 5 s").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stranger_is_not_heard() {
    let mut plans = usual();
    plans.push(stranger());
    let mut field = Field::start(13, plans);
    let coordinator = field.one_swarm(&ALL, TOGETHER_S).await;
    assert!(ALL.contains(&coordinator), "not the stranger");
    let swarm = field.host(GROUND).operator().swarm().await;
    assert_eq!(
        swarm["nodes"].as_array().map(Vec::len),
        Some(5),
        "the other five: {swarm}"
    );
    let fleet = field.host(7).operator().fleet().await;
    assert_eq!(
        fleet["vehicles"].as_array().map(Vec::len),
        Some(1),
        "its own only: {fleet}"
    );
    let mut mission = Mission::new(&mut field, GROUND);
    mission.vehicles = vec![2, 3, 4, 5, 6];
    mission.take_off().await;
    home(field, GROUND, vec![2, 3, 4, 5, 6], "stranger").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn everything_at_once() {
    let mut field = in_the_air(14).await;
    field.air().everywhere(Quality {
        loss: 0.1,
        delay_s: 0.05,
        jitter_s: 0.05,
        doubled: 0.1,
        overtaken: 0.1,
    });
    let mut mission = Mission::new(&mut field, GROUND);
    mission.set_out(40.0, 20.0).await;
    field.pass(2.0).await;
    field.air().part(&[GROUND, 2, 3]);
    field.pass(1.0).await;
    field.host_mut(COORDINATOR).kill().await;
    field.one_swarm(&[GROUND, 3], TOGETHER_IN_BAD_AIR_S).await;
    field.one_swarm(&[4, 5, 6], TOGETHER_IN_BAD_AIR_S).await;
    field.air().join();
    let rest = without(&ALL, COORDINATOR);
    field.one_swarm(&rest, TOGETHER_IN_BAD_AIR_S).await;
    let vehicles = without(&field.vehicles(), COORDINATOR);
    home_in_bad_air(field, vehicles, "bad air, partition, coordinator killed").await;
}
