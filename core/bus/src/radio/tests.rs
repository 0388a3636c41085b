//! The simulated radio does what its settings say, the same each time; and the suite is passed behind a bad one.

use super::*;
use crate::conformance::{self, Rig};
use crate::local::{Hub, Local};

const A: NodeId = NodeId(1);
const B: NodeId = NodeId(2);
const C: NodeId = NodeId(3);

struct Behind {
    hub: Hub,
    air: Air,
    now: NodeTime,
}

impl Behind {
    fn new(settings: AirSettings, seed: u64) -> Self {
        Self {
            hub: Hub::default(),
            air: Air::new(settings, seed),
            now: NodeTime(0),
        }
    }
}

impl Rig for Behind {
    type Transport = Radio<Local>;

    fn join(&mut self, node: NodeId) -> Radio<Local> {
        self.air.radio(self.hub.join(node))
    }

    fn step(&mut self) -> NodeTime {
        self.now = self.now.plus_seconds(0.01);
        self.now
    }
}

/// Loses 30 %, takes a fifth of a second and a twentieth more or less, doubles a tenth, at 2 Mbit/s for all together.
const BAD: AirSettings = AirSettings {
    range_m: f64::INFINITY,
    path_loss_exponent: 2.5,
    fade_db: 1.5,
    bits_per_s: 2e6,
    overhead_bytes: 40,
    longest_wait_s: 1.0,
    loss: 0.3,
    delay_s: 0.2,
    jitter_s: 0.1,
    doubles: 0.1,
};

#[test]
fn the_suite_is_passed_behind_a_perfect_radio() {
    conformance::all(|| Behind::new(AirSettings::default(), 1));
}

#[test]
fn the_suite_is_passed_behind_a_bad_radio() {
    for seed in 1..=20 {
        println!("seed {seed}");
        conformance::all(|| Behind::new(BAD, seed));
    }
}

fn arrivals(at: &mut Radio<Local>, now: NodeTime) -> Vec<Vec<u8>> {
    std::iter::from_fn(|| at.receive(now))
        .map(|datagram| datagram.bytes)
        .collect()
}

/// Sends a thousand datagrams, one every 10 ms; gives the steps at which B and C got which.
fn thousand(rig: &mut Behind) -> Vec<(usize, NodeId, u16)> {
    let (mut a, mut b, mut c) = (rig.join(A), rig.join(B), rig.join(C));
    let mut got = Vec::new();
    for step in 0..1100_u16 {
        let now = rig.step();
        if step < 1000 {
            a.send(now, To::All, Class::State, &step.to_be_bytes()).unwrap();
        }
        let _own = a.receive(now);
        for receiver in [&mut b, &mut c] {
            for bytes in arrivals(receiver, now) {
                got.push((
                    usize::from(step),
                    receiver.node(),
                    u16::from_be_bytes([bytes[0], bytes[1]]),
                ));
            }
        }
    }
    got
}

fn share(got: &[(usize, NodeId, u16)], at: NodeId) -> f64 {
    let numbers: std::collections::BTreeSet<u16> = got
        .iter()
        .filter(|(_, node, _)| *node == at)
        .map(|(.., number)| *number)
        .collect();
    numbers.len() as f64 / 1000.0
}

#[test]
fn the_same_seed_gives_the_same_and_another_one_does_not() {
    let run = |seed| thousand(&mut Behind::new(BAD, seed));
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
}

#[test]
fn loss_delay_jitter_and_doubles_are_as_they_are_set() {
    let got = thousand(&mut Behind::new(BAD, 5));
    for at in [B, C] {
        assert!((share(&got, at) - 0.7).abs() < 0.05, "{}", share(&got, at));
    }
    let late: Vec<usize> = got
        .iter()
        .map(|(step, _, number)| step - usize::from(*number))
        .collect();
    assert!(late.iter().all(|steps| (20..=31).contains(steps)), "0.2 to 0.3 s");
    let overtaken = got
        .windows(2)
        .filter(|pair| pair[0].1 == pair[1].1 && pair[0].2 > pair[1].2)
        .count();
    assert!(overtaken > 100, "{overtaken}");
    let doubles = got.len() as f64 / (share(&got, B) + share(&got, C)) / 1000.0 - 1.0;
    assert!((doubles - 0.1).abs() < 0.04, "{doubles}");
}

#[test]
fn distance_decides_and_at_the_range_half_arrives() {
    let settings = AirSettings {
        range_m: 1000.0,
        ..AirSettings::default()
    };
    let share_at = |distance_m: f64| {
        let mut rig = Behind::new(settings, 9);
        let place = |north_m: f64| PositionNed {
            north_m,
            ..PositionNed::default()
        };
        rig.air.place(B, place(distance_m));
        rig.air.place(C, place(-distance_m));
        let got = thousand(&mut rig);
        (share(&got, B) + share(&got, C)) / 2.0
    };
    let shares = [300.0, 800.0, 1000.0, 1250.0, 3000.0].map(share_at);
    assert!(shares[0] > 0.99 && shares[4] < 0.01, "{shares:?}");
    assert!(
        (shares[2] - 0.5).abs() < 0.05 && shares[1] > 0.75 && shares[3] < 0.25,
        "{shares:?}"
    );
}

#[test]
fn a_link_may_be_worse_one_way_and_a_divided_swarm_hears_only_its_part() {
    let mut rig = Behind::new(AirSettings::default(), 2);
    let (mut a, mut b, mut c) = (rig.join(A), rig.join(B), rig.join(C));
    let cut = Link {
        cut: true,
        ..Link::default()
    };
    let mut heard = |rig: &mut Behind| {
        let now = rig.step();
        for radio in [&mut a, &mut b, &mut c] {
            radio.send(now, To::All, Class::State, &[radio.node().0 as u8]).unwrap();
        }
        let now = rig.step();
        [&mut a, &mut b, &mut c].map(|radio| {
            let mut from: Vec<u8> = arrivals(radio, now).concat();
            from.sort_unstable();
            from
        })
    };
    assert_eq!(heard(&mut rig), [vec![2, 3], vec![1, 3], vec![1, 2]]);
    rig.air.set_link(A, B, cut);
    assert_eq!(heard(&mut rig), [vec![2, 3], vec![3], vec![1, 2]]);
    rig.air.mend();
    rig.air.divide(&[&[A, C], &[B]]);
    assert_eq!(heard(&mut rig), [vec![3], vec![], vec![1]]);
    rig.air.mend();
    assert_eq!(heard(&mut rig), [vec![2, 3], vec![1, 3], vec![1, 2]]);
}

#[test]
fn all_share_the_airtime_and_what_would_wait_too_long_is_dropped() {
    let settings = AirSettings {
        bits_per_s: 80_000.0,
        overhead_bytes: 0,
        longest_wait_s: 0.5,
        ..AirSettings::default()
    };
    let mut rig = Behind::new(settings, 2);
    let (mut a, mut b) = (rig.join(A), rig.join(B));
    let now = rig.step();
    // Each takes 20 ms: two nodes fill half a second with 26 of them.
    for _ in 0..20 {
        a.send(now, To::One(B), Class::Bulk, &[0; 200]).unwrap();
        b.send(now, To::One(A), Class::Bulk, &[0; 200]).unwrap();
    }
    assert_eq!((rig.air.used().sent, rig.air.used().dropped), (26, 14));
    let (mut last, mut count) = (now, 0);
    for _ in 0..100 {
        let now = rig.step();
        let got = arrivals(&mut a, now).len() + arrivals(&mut b, now).len();
        count += got;
        last = if got > 0 { now } else { last };
    }
    assert_eq!(count, 26);
    let took_s = last.seconds_since(now);
    assert!((took_s - 0.52).abs() < 0.03, "{took_s}");
}

#[test]
fn it_says_when_something_in_the_air_arrives() {
    let settings = AirSettings {
        delay_s: 0.2,
        ..AirSettings::default()
    };
    let mut rig = Behind::new(settings, 2);
    let (mut a, mut b) = (rig.join(A), rig.join(B));
    assert_eq!(a.due(), None);
    a.send(NodeTime::from_seconds(1.0), To::One(B), Class::State, b"x")
        .unwrap();
    let due = a.due().unwrap();
    assert_eq!(due, NodeTime::from_seconds(1.2));
    let early = NodeTime(due.0 - 1);
    assert!(a.receive(early).is_none() && b.receive(early).is_none());
    assert!(a.receive(due).is_none() && b.receive(due).is_some());
}
