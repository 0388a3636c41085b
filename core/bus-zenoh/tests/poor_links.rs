//! Zenoh over links that lose datagrams, and beside one that stands still: through relays of this host, in real time.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use skein_bus::transport::{Class, To, Transport};
use skein_bus_zenoh::{Zenoh, ZenohSettings};
use skein_domain::{NodeId, NodeTime};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::process::Command;
use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

/// How long anything may take: far longer than it does.
const PATIENCE: Duration = Duration::from_secs(60);
/// What has not come by then is taken for lost.
const LOST_AFTER: Duration = Duration::from_millis(200);

/// One that is free; none is given twice, and none that the system gives to whoever connects.
fn free_port() -> u16 {
    static GIVEN: AtomicU16 = AtomicU16::new(0);
    loop {
        let offset = std::process::id() % 100 * 20 + u32::from(GIVEN.fetch_add(1, Ordering::Relaxed));
        let port = 30_000 + u16::try_from(offset % 2_000).unwrap();
        if TcpListener::bind(("127.0.0.1", port)).is_ok() && UdpSocket::bind(("127.0.0.1", port)).is_ok() {
            return port;
        }
    }
}

fn open(node: u64, swarm: &str, listen: String, connect: Vec<String>) -> Zenoh {
    let settings = ZenohSettings {
        listen: vec![listen],
        connect,
        ..ZenohSettings::default()
    };
    Zenoh::open(swarm, NodeId(node), &settings).unwrap()
}

/// Carries datagrams to `to` and back, and loses three of ten each way, chosen by `seed`.
fn lossy_relay(to: u16, mut seed: u64, ends: Arc<AtomicBool>) -> u16 {
    let outer = UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = outer.local_addr().unwrap().port();
    let mut inner: BTreeMap<SocketAddr, UdpSocket> = BTreeMap::new();
    outer.set_nonblocking(true).unwrap();
    std::thread::spawn(move || {
        let mut lost = move || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) % 10 < 3
        };
        let mut buffer = [0; 65536];
        while !ends.load(Ordering::Acquire) {
            while let Ok((length, from)) = outer.recv_from(&mut buffer) {
                let socket = inner.entry(from).or_insert_with(|| {
                    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
                    socket.set_nonblocking(true).unwrap();
                    socket
                });
                if !lost() {
                    let _sent = socket.send_to(&buffer[..length], ("127.0.0.1", to));
                }
            }
            for (back, socket) in &inner {
                while let Ok((length, _)) = socket.recv_from(&mut buffer) {
                    if !lost() {
                        let _sent = outer.send_to(&buffer[..length], back);
                    }
                }
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    });
    port
}

/// Of every pair of nodes, both hear both what is for them and what is for all, though any word of Zenoh itself may be lost.
#[test]
fn who_loses_three_of_ten_datagrams_is_still_heard() {
    let ends = Arc::new(AtomicBool::new(false));
    let mut nodes = Vec::new();
    for pair in 0..8_u64 {
        let swarm = format!("pair-{pair}-{}", std::process::id());
        let ports = [free_port(), free_port()];
        for (node, port) in [(1, ports[0]), (2, ports[1])] {
            let other = ports[usize::from(node == 1)];
            let relay = lossy_relay(other, pair * 2 + node, Arc::clone(&ends));
            let (listen, connect) = (format!("udp/127.0.0.1:{port}"), format!("udp/127.0.0.1:{relay}"));
            nodes.push(open(node, &swarm, listen, vec![connect]));
        }
    }
    let begun = Instant::now();
    let mut heard = vec![(0, 0); nodes.len()];
    while heard.iter().any(|(one, all)| *one < 20 || *all < 20) {
        assert!(begun.elapsed() < PATIENCE, "{heard:?}");
        let now = NodeTime::from_seconds(begun.elapsed().as_secs_f64());
        for (node, (one, all)) in nodes.iter_mut().zip(&mut heard) {
            let other = NodeId(3 - node.node().0);
            node.send(now, To::One(other), Class::Command, b"you").unwrap();
            node.send(now, To::All, Class::State, b"all").unwrap();
            while let Some(datagram) = node.receive(now) {
                *(if datagram.class == Class::State {
                    &mut *all
                } else {
                    &mut *one
                }) += 1;
            }
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    println!("all heard after {:.1} s", begun.elapsed().as_secs_f64());
    ends.store(true, Ordering::Release);
}

/// Carries a stream to `to` and back, until it `stands`: then it neither reads nor closes, as a node does that is out of reach.
fn relay_that_stops(to: u16, stands: &Arc<AtomicBool>) -> u16 {
    let outer = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = outer.local_addr().unwrap().port();
    let stands = Arc::clone(stands);
    std::thread::spawn(move || {
        for one in outer.incoming() {
            let (Ok(one), Ok(other)) = (one, TcpStream::connect(("127.0.0.1", to))) else {
                continue;
            };
            let ways = [(one.try_clone().unwrap(), other.try_clone().unwrap()), (other, one)];
            for (mut from, mut into) in ways {
                let stands = Arc::clone(&stands);
                std::thread::spawn(move || {
                    let mut buffer = [0; 16384];
                    while let Ok(length) = from.read(&mut buffer) {
                        while stands.load(Ordering::Acquire) {
                            std::thread::sleep(Duration::from_millis(10));
                        }
                        if length == 0 || into.write_all(&buffer[..length]).is_err() {
                            return;
                        }
                    }
                });
            }
        }
    });
    port
}

/// In a process of its own, which begins as one must whose links are TCP.
#[test]
fn who_stands_still_holds_nobody_up() {
    let (name, value) = skein_bus_zenoh::RUNTIMES;
    if std::env::var(name).is_err() {
        let mut child = Command::new(std::env::current_exe().unwrap());
        let child = child.args(["--exact", "who_stands_still_holds_nobody_up", "--nocapture"]);
        assert!(child.env(name, value).status().unwrap().success());
        return;
    }
    let stands = Arc::new(AtomicBool::new(false));
    let (port_a, port_b, port_c) = (free_port(), free_port(), free_port());
    let swarm = format!("still-{}", std::process::id());
    let at = |port: u16| format!("tcp/127.0.0.1:{port}");
    let relay = relay_that_stops(port_a, &stands);
    let mut a = open(1, &swarm, at(port_a), Vec::new());
    let mut b = open(2, &swarm, at(port_b), vec![at(relay)]);
    let mut c = open(3, &swarm, at(port_c), vec![at(port_a)]);
    let begun = Instant::now();
    let clock = || NodeTime::from_seconds(begun.elapsed().as_secs_f64());
    let mut heard = BTreeSet::new();
    while heard.len() < 2 {
        assert!(begun.elapsed() < PATIENCE, "{heard:?}");
        a.send(clock(), To::All, Class::State, b"here").unwrap();
        std::thread::sleep(Duration::from_millis(10));
        for node in [&mut b, &mut c] {
            if node.receive(clock()).is_some() {
                heard.insert(node.node());
            }
        }
    }
    while c.receive(clock()).is_some() {}
    stands.store(true, Ordering::Release);
    // More than sockets and queues hold. The next ten go out when the last have come, or are taken for lost: a machine that stands still for
    // a moment makes it slower and loses nothing.
    let (mut sent, mut got, mut lost, mut longest) = (0, 0, 0, Duration::ZERO);
    for _ in 0..1000 {
        for _ in 0..10 {
            let before = Instant::now();
            a.send(clock(), To::All, Class::Bulk, &[7; 1300]).unwrap();
            longest = longest.max(before.elapsed());
            sent += 1;
        }
        let waits = Instant::now();
        while got + lost < sent && waits.elapsed() < LOST_AFTER {
            std::thread::sleep(Duration::from_millis(2));
            got += std::iter::from_fn(|| c.receive(clock()))
                .filter(|datagram| datagram.class == Class::Bulk)
                .count();
        }
        lost = sent - got;
        assert!(lost <= 200, "{lost} of {sent} have not come");
    }
    println!(
        "{got} of {sent} came to the one beside it; the longest sending took {} us",
        longest.as_micros()
    );
    assert!(got * 100 >= sent * 98, "{got} of {sent}");
    // It ends while one is out of reach and not yet taken for gone.
    let (ended, end) = mpsc::channel();
    std::thread::spawn(move || {
        drop(a);
        ended.send(()).unwrap();
    });
    assert!(end.recv_timeout(PATIENCE).is_ok(), "it does not end");
}
