//! DDS over loopback passes the suite of every transport, in real time.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use skein_bus::conformance::{self, Rig};
use skein_bus::transport::{Class, SendError, To, Transport};
use skein_bus_dds::{Dds, OpenError};
use skein_dds::DdsSettings;
use skein_domain::{NodeId, NodeTime};
use std::process::Command;
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::{Duration, Instant};

/// A domain of this host, and a swarm of its own in it.
struct Loopback {
    begun: Instant,
    swarm: String,
    settings: DdsSettings,
}

impl Loopback {
    fn new() -> Self {
        static GIVEN: AtomicU16 = AtomicU16::new(0);
        // The domains of one process are its own, as far as there are enough of them; swarms are in any case.
        let number = GIVEN.fetch_add(1, Ordering::Relaxed);
        let process = std::process::id();
        let domain_id = u16::try_from((process * 17 + u32::from(number)) % 100).unwrap() + 1;
        Self {
            begun: Instant::now(),
            swarm: format!("test-{process}-{number}"),
            settings: DdsSettings {
                domain_id,
                ..DdsSettings::default()
            },
        }
    }
}

impl Rig for Loopback {
    type Transport = Dds;

    fn join(&mut self, node: NodeId) -> Dds {
        Dds::open(&self.swarm, node, skein_dds::join(&self.settings).unwrap()).unwrap()
    }

    fn step(&mut self) -> NodeTime {
        // DDS lives in real time: a step is a short wait in it. Scenes wait for what they want to see, not for a time.
        std::thread::sleep(Duration::from_millis(5));
        NodeTime::from_seconds(self.begun.elapsed().as_secs_f64())
    }
}

#[test]
fn the_suite_is_passed_on_loopback() {
    conformance::all_at_once(Loopback::new);
}

#[test]
fn a_swarm_does_not_hear_another_one_at_the_same_place() {
    let mut rig = Loopback::new();
    let mut a = rig.join(NodeId(1));
    let mut b = rig.join(NodeId(2));
    rig.swarm = format!("{}-another", rig.swarm);
    let mut other = rig.join(NodeId(3));
    let mut got = 0;
    for _ in 0..2000 {
        let now = rig.step();
        a.send(now, To::All, Class::State, b"here").unwrap();
        got += usize::from(b.receive(now).is_some());
        assert_eq!(other.receive(now), None);
        if got > 50 {
            return;
        }
    }
    panic!("only {got} arrived");
}

/// Datagrams that the system has thrown away so far, for whichever program: a buffer was full, or what waited for the kernel itself, since who empties it did not
/// get the processor in time. These counters only rise; those of sockets go with their sockets.
fn thrown_away() -> usize {
    let read = |path| std::fs::read_to_string(path).unwrap();
    let udp = read("/proc/net/snmp");
    let mut lines = udp.lines().filter(|line| line.starts_with("Udp: "));
    let (names, values) = (lines.next().unwrap(), lines.next().unwrap());
    let counted = names.split_whitespace().zip(values.split_whitespace());
    let lost = counted.filter(|(name, _)| ["RcvbufErrors", "SndbufErrors", "MemErrors"].contains(name));
    let of_sockets: usize = lost.map(|(_, value)| value.parse::<usize>().unwrap()).sum();
    let waiting = read("/proc/net/softnet_stat");
    let dropped = |line: &str| usize::from_str_radix(line.split_whitespace().nth(1)?, 16).ok();
    of_sockets + waiting.lines().filter_map(dropped).sum::<usize>()
}

/// As far as the system lets it: a datagram of best effort is lost where its buffer is full, and the bus asks for it again.
#[test]
fn a_burst_does_not_wait_and_comes_whole() {
    const BURST: usize = 400;
    let mut rig = Loopback::new();
    let mut a = rig.join(NodeId(1));
    let mut b = rig.join(NodeId(2));
    let mut begun = rig.step();
    while b.receive(begun).is_none() {
        a.send(begun, To::All, Class::Query, b"there?").unwrap();
        begun = rig.step();
    }
    let before = thrown_away();
    for number in 0..BURST {
        a.send(begun, To::All, Class::Bulk, &[number as u8; 1300]).unwrap();
    }
    let mut got = 0;
    for _ in 0..1000 {
        let now = rig.step();
        while let Some(datagram) = b.receive(now) {
            got += usize::from(datagram.class == Class::Bulk);
        }
        if got + thrown_away() - before >= BURST {
            return;
        }
    }
    panic!(
        "only {got} arrived, and the system threw away {}",
        thrown_away() - before
    );
}

/// A laptop that slept, a container that was paused, a program that was stopped at the terminal: it goes on where it was.
#[test]
fn who_was_stopped_for_a_moment_hears_and_is_heard_again() {
    let mut rig = Loopback::new();
    let mut a = rig.join(NodeId(1));
    let mut b = rig.join(NodeId(2));
    let mut hear_each_other = |rig: &mut Loopback| {
        let (mut at_a, mut at_b) = (0, 0);
        // what had been sent before is let through first
        for _ in 0..4000 {
            let now = rig.step();
            a.send(now, To::All, Class::State, b"here").unwrap();
            b.send(now, To::All, Class::State, b"here").unwrap();
            at_a += usize::from(a.receive(now).is_some());
            at_b += usize::from(b.receive(now).is_some());
            if at_a.min(at_b) > 100 {
                return;
            }
        }
        panic!("{at_a} and {at_b} arrived");
    };
    hear_each_other(&mut rig);
    let process = std::process::id();
    let pause = format!("kill -STOP {process}; sleep 0.3; kill -CONT {process}");
    let mut paused = Command::new("sh").args(["-c", &pause]).spawn().unwrap();
    assert!(paused.wait().unwrap().success());
    hear_each_other(&mut rig);
}

#[test]
fn an_id_that_is_none_is_refused() {
    let participant = skein_dds::join(&Loopback::new().settings).unwrap();
    let refused = Dds::open("a/b", NodeId(1), participant).map(|_| ()).unwrap_err();
    assert_eq!(refused, OpenError::SwarmId("a/b".to_owned()));
}

#[test]
fn whoever_leaves_comes_back_with_the_same_participant() {
    let rig = Loopback::new();
    let open = |participant: &rustdds::DomainParticipant, node| {
        Dds::open(&rig.swarm, NodeId(node), participant.clone()).unwrap()
    };
    let (first, second) = (skein_dds::join(&rig.settings), skein_dds::join(&rig.settings));
    let (first, second) = (first.unwrap(), second.unwrap());
    let mut b = open(&second, 2);
    for _ in 0..3 {
        let mut a = open(&first, 1);
        let mut heard = (false, false);
        for _ in 0..2000 {
            let now = NodeTime::from_seconds(rig.begun.elapsed().as_secs_f64());
            a.send(now, To::All, Class::State, b"a").unwrap();
            b.send(now, To::All, Class::State, b"b").unwrap();
            std::thread::sleep(Duration::from_millis(5));
            heard.0 |= a.receive(now).is_some();
            heard.1 |= b.receive(now).is_some();
            if heard == (true, true) {
                break;
            }
        }
        assert_eq!(heard, (true, true));
        drop(a);
        while b.receive(NodeTime::default()).is_some() {}
    }
}

#[test]
fn what_is_too_large_is_refused() {
    let mut rig = Loopback::new();
    let mut a = rig.join(NodeId(1));
    let now = rig.step();
    let most = a.largest_bytes();
    let sent = a.send(now, To::All, Class::Bulk, &vec![0; most + 1]);
    assert_eq!(sent, Err(SendError::TooLarge { bytes: most + 1, most }));
}
