//! Two transports as one pass the suite, and what is urgent goes on without a gap when one of two radios dies.

use super::*;
use crate::bus::{Bus, BusSettings, Event, pump};
use crate::conformance::{self, Rig};
use crate::envelope::{Boot, SwarmKey};
use crate::latest::Key;
use crate::local::{Hub, Local};
use crate::radio::{Air, AirSettings, Link, Radio};
use std::collections::BTreeSet;

const A: NodeId = NodeId(1);
const B: NodeId = NodeId(2);

type Radios = Redundant<Radio<Local>, Radio<Local>>;

/// Two airs of their own: what is in one is not in the other.
struct TwoAirs {
    hubs: [Hub; 2],
    airs: [Air; 2],
    now: NodeTime,
}

impl TwoAirs {
    fn new(settings: AirSettings) -> Self {
        Self {
            hubs: Default::default(),
            airs: [Air::new(settings, 1), Air::new(settings, 2)],
            now: NodeTime(0),
        }
    }
}

impl Rig for TwoAirs {
    type Transport = Radios;

    fn join(&mut self, node: NodeId) -> Radios {
        let [first, second] = [0, 1].map(|index: usize| self.airs[index].radio(self.hubs[index].join(node)));
        Redundant::new(first, second).unwrap()
    }

    fn step(&mut self) -> NodeTime {
        self.now = self.now.plus_seconds(0.01);
        self.now
    }
}

/// Each of its own delay and losses.
const POOR: AirSettings = AirSettings {
    range_m: f64::INFINITY,
    path_loss_exponent: 2.5,
    fade_db: 1.5,
    bits_per_s: 2e6,
    overhead_bytes: 40,
    longest_wait_s: 1.0,
    loss: 0.1,
    delay_s: 0.02,
    jitter_s: 0.02,
    doubles: 0.05,
};

#[test]
fn the_suite_is_passed_over_both() {
    conformance::all(|| TwoAirs::new(AirSettings::default()));
    conformance::all(|| TwoAirs::new(POOR));
}

#[test]
fn the_suite_is_passed_while_one_is_dead() {
    for dead in 0..2 {
        conformance::all(|| {
            let rig = TwoAirs::new(AirSettings::default());
            rig.airs[dead].divide(&[]);
            rig
        });
    }
}

/// Down while it says so; otherwise as what is in it.
struct Breaks {
    inner: Local,
    down: Arc<Mutex<bool>>,
}

impl Transport for Breaks {
    fn node(&self) -> NodeId {
        self.inner.node()
    }

    fn largest_bytes(&self) -> usize {
        self.inner.largest_bytes()
    }

    fn send(&mut self, now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        if *self.down.lock() {
            return Err(SendError::Down("unplugged".to_owned()));
        }
        self.inner.send(now, to, class, bytes)
    }

    fn receive(&mut self, now: NodeTime) -> Option<Datagram> {
        self.inner.receive(now)
    }

    fn wake_on_arrival(&mut self, wake: Wake) {
        self.inner.wake_on_arrival(wake);
    }

    fn overflowed(&self) -> u64 {
        self.inner.overflowed()
    }
}

#[test]
fn one_that_is_down_is_no_error_and_is_tried_again() {
    let hubs: [Hub; 2] = Default::default();
    let downs: [Arc<Mutex<bool>>; 2] = Default::default();
    let [first, second] = [0, 1].map(|index: usize| Breaks {
        inner: hubs[index].join(A),
        down: Arc::clone(&downs[index]),
    });
    let (mut at_first, mut at_second) = (hubs[0].join(B), hubs[1].join(B));
    let mut both = Redundant::new(first, second).unwrap();
    let ways = both.ways();
    let at = |seconds: f64| NodeTime::from_seconds(seconds);
    let mut send = |seconds: f64, class| {
        let sent = both.send(at(seconds), To::One(B), class, b"x");
        let came = [at_first.receive(at(seconds)), at_second.receive(at(seconds))];
        (sent, came.map(|came| came.is_some()))
    };
    assert_eq!(send(0.0, Class::Command), (Ok(()), [true, true]));
    assert_eq!(send(0.1, Class::Bulk), (Ok(()), [true, false]));
    *downs[0].lock() = true;
    assert_eq!(send(1.0, Class::Query), (Ok(()), [false, true]));
    assert_eq!(
        send(1.1, Class::Bulk),
        (Ok(()), [false, true]),
        "bulk goes where it can"
    );
    let [one, other] = ways.now();
    assert!(!one.up && other.up);
    assert_eq!(one.down_because.as_deref(), Some("the transport is down: unplugged"));
    assert_eq!(other.sent.datagrams, [1, 0, 1, 0, 1]);
    *downs[0].lock() = false;
    assert_eq!(
        send(1.3, Class::State),
        (Ok(()), [false, true]),
        "it is not tried at once"
    );
    assert_eq!(send(1.6, Class::State), (Ok(()), [true, true]));
    assert!(ways.now()[0].up);
    *downs[0].lock() = true;
    *downs[1].lock() = true;
    let (sent, _) = send(3.0, Class::Command);
    assert!(matches!(sent, Err(SendError::Down(_))), "{sent:?}");
}

#[test]
fn transports_of_two_nodes_are_not_one() {
    let refused = Redundant::new(Hub::default().join(A), Hub::default().join(B)).map(|_| ());
    assert_eq!(refused, Err(DifferentNodes(A, B)));
}

/// What came to B, and when.
#[derive(Default)]
struct Came {
    states: Vec<(f64, u32)>,
    commands: Vec<(f64, u32)>,
    bulk: Vec<f64>,
}

/// The two nodes for twenty seconds: a state ten times a second, a command five times, 100 kB at five seconds and at twelve. `happens` to the airs at eight seconds.
fn flown(happens: impl Fn(&[Air; 2])) -> (Came, [Way; 2], u64) {
    let mut rig = TwoAirs::new(POOR);
    let key = SwarmKey::derive("geese", b"sixteen bytes or more").unwrap();
    let mut nodes = [A, B].map(|node| {
        let bus = Bus::new(BusSettings::default(), key.clone(), node, Boot(node.0), NodeTime(0));
        (bus, rig.join(node))
    });
    let ways = nodes[0].1.ways();
    let mut came = Came::default();
    for step in 1..=2000_u32 {
        let now = rig.step();
        let [(a, over_a), (b, over_b)] = &mut nodes;
        if step == 800 {
            happens(&rig.airs);
        }
        if step.is_multiple_of(10) {
            a.tell(now, Key(1), step.to_be_bytes().to_vec()).unwrap();
            b.tell(now, Key(1), step.to_be_bytes().to_vec()).unwrap();
        }
        if step.is_multiple_of(20) && step < 1900 {
            a.post(now, B, step.to_be_bytes().to_vec()).unwrap();
        }
        if step == 500 || step == 1200 {
            a.send(now, B, vec![step as u8; 100_000]).unwrap();
        }
        pump(a, over_a, now).unwrap();
        let number = |bytes: &[u8]| u32::from_be_bytes(bytes.try_into().unwrap());
        for event in pump(b, over_b, now).unwrap() {
            match event {
                Event::State { value, .. } => came.states.push((now.as_seconds(), number(&value))),
                Event::Command { body, .. } => came.commands.push((now.as_seconds(), number(&body))),
                Event::Bulk { .. } => came.bulk.push(now.as_seconds()),
                _ => {}
            }
        }
    }
    (came, ways.now(), nodes[1].0.refused().replayed)
}

fn longest_gap_s(came: &[(f64, u32)]) -> f64 {
    let gaps = came.windows(2).map(|pair| pair[1].0 - pair[0].0);
    gaps.fold(0.0, f64::max)
}

fn nothing_is_there_twice(came: &Came) {
    for seen in [&came.states, &came.commands] {
        let different: BTreeSet<u32> = seen.iter().map(|(_, number)| *number).collect();
        assert_eq!(different.len(), seen.len(), "something was delivered twice");
        assert!(seen.windows(2).all(|pair| pair[0].1 < pair[1].1), "out of order");
    }
}

#[test]
fn nothing_comes_twice_and_bulk_goes_over_the_first() {
    let (came, [first, second], dropped) = flown(|_| {});
    nothing_is_there_twice(&came);
    assert!(dropped > 200, "the second copies came, and were dropped: {dropped}");
    assert_eq!((came.commands.len(), came.bulk.len()), (94, 2));
    let bulk = Class::Bulk as usize;
    assert!(first.sent.bytes[bulk] > 200_000 && second.sent.bytes[bulk] == 0);
    assert!(first.up && second.up && first.last_came > Some(NodeTime(19_000_000)));
}

/// Whatever ends at eight seconds: no state is late by more than a lost one makes it over a single radio, every command comes, and bulk goes on.
fn goes_on(what: &str, happens: impl Fn(&[Air; 2])) {
    let (before, ..) = flown(|_| {});
    let (came, [first, second], _) = flown(happens);
    nothing_is_there_twice(&came);
    let [usual_s, states_s, commands_s] =
        [&before.states, &came.states, &came.commands].map(|seen| longest_gap_s(seen));
    println!(
        "{what}: longest gap of states {states_s:.2} s (nothing dead: {usual_s:.2} s), of commands {commands_s:.2} s; bulk at {:?}",
        came.bulk
    );
    // Three in succession are lost over one radio once in a thousand.
    assert!(states_s < 0.5 && commands_s < 0.6);
    assert_eq!(came.commands.len(), 94);
    assert_eq!(came.bulk.len(), 2, "{:?}", came.bulk);
    assert!(
        first.up && second.up,
        "that nobody is reached does not mean that it is down"
    );
}

#[test]
fn what_is_urgent_goes_on_when_the_first_dies() {
    goes_on("the first dead", |airs| airs[0].divide(&[]));
    goes_on("the second dead", |airs| airs[1].divide(&[]));
    let cut = Link {
        cut: true,
        ..Link::default()
    };
    goes_on("the first dead there", |airs| airs[0].set_link(A, B, cut));
    goes_on("the first dead back", |airs| airs[0].set_link(B, A, cut));
    goes_on("the first dead there, the second back", |airs| {
        airs[0].set_link(A, B, cut);
        airs[1].set_link(B, A, cut);
    });
}
