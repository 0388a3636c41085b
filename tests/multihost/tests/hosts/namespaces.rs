//! The ground the flights stand on: what the hosts' network does to datagrams. No node takes part.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

use skein_tests_multihost::net::{Namespace, Network};
use skein_tests_multihost::relay::Quality;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Longest that an answer is waited for.
const ANSWER_WITHIN: Duration = Duration::from_millis(500);

fn socket(at: &Namespace) -> UdpSocket {
    let socket = at.within(|| UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 5000)).unwrap());
    socket.set_read_timeout(Some(ANSWER_WITHIN)).unwrap();
    socket
}

/// Sends datagrams of so many bytes one after the other from one host to another, waiting for each. Gives how long each was under way
/// that arrived.
fn arrivals(from: &UdpSocket, to: &UdpSocket, address: SocketAddr, count: u32, bytes: usize) -> Vec<Duration> {
    let mut buffer = vec![0; 2000];
    let one = |number: u32| {
        let mut datagram = vec![0; bytes];
        datagram[..4].copy_from_slice(&number.to_le_bytes());
        let sent = Instant::now();
        from.send_to(&datagram, address).unwrap();
        loop {
            to.recv_from(&mut buffer).ok()?;
            if buffer[..4] == number.to_le_bytes() {
                return Some(sent.elapsed());
            }
        }
    };
    (0..count).filter_map(one).collect()
}

#[test]
fn the_air_does_to_datagrams_what_it_is_told_to() {
    let network = Network::make(3, 1).unwrap();
    let [a, b, c] = network.hosts() else {
        panic!("three hosts")
    };
    let sockets = [a, b, c].map(socket);
    let at = [a, b, c].map(|host| SocketAddr::from((host.air, 5000)));
    let count = |from: usize, to: usize, of: u32| arrivals(&sockets[from], &sockets[to], at[to], of, 100).len();
    let air = network.relay();
    assert_eq!(count(0, 1, 50), 50, "a good air loses nothing");

    air.part(&[1]);
    assert_eq!(count(0, 1, 2), 0, "another part");
    assert_eq!(count(1, 2, 2), 2, "the same part");
    air.join();
    air.cut(2, 1, true);
    assert_eq!((count(0, 1, 2), count(1, 0, 2)), (2, 0), "one way only");
    air.join();

    let bad = Quality {
        delay_s: 0.02,
        loss: 0.3,
        ..Quality::default()
    };
    air.everywhere(bad);
    sockets[1].set_read_timeout(Some(Duration::from_millis(60))).unwrap();
    let came = arrivals(&sockets[0], &sockets[1], at[1], 100, 100);
    assert!((50..90).contains(&came.len()), "{} of 100 came", came.len());
    assert!(came.iter().all(|took| *took >= Duration::from_millis(20)), "{came:?}");
    air.everywhere(Quality::default());

    network.limit_rate(Some(256));
    let began = Instant::now();
    for _ in 0..10 {
        sockets[0].send_to(&[0; 1400], at[1]).unwrap();
    }
    let mut buffer = [0; 2000];
    sockets[1].set_read_timeout(Some(ANSWER_WITHIN)).unwrap();
    let through = (0..7).filter(|_| sockets[1].recv_from(&mut buffer).is_ok()).count();
    assert_eq!(through, 7, "the queue takes 300 ms of it");
    let least = Duration::from_secs_f64(4.0 * 1442.0 * 8.0 / 256_000.0);
    assert!(began.elapsed() > least, "10 kB at 256 kbit/s in {:?}", began.elapsed());
    network.limit_rate(None);
}

#[test]
fn groups_are_reached_over_the_air() {
    let network = Network::make(2, 1).unwrap();
    let group = Ipv4Addr::new(224, 0, 0, 224);
    let sockets = [0, 1].map(|i| socket(&network.hosts()[i]));
    for (socket, host) in sockets.iter().zip(network.hosts()) {
        socket.join_multicast_v4(&group, &host.air).unwrap();
    }
    let to = SocketAddr::from((group, 5000));
    assert_eq!(arrivals(&sockets[0], &sockets[1], to, 3, 100).len(), 3);
    network.relay().cut(1, 2, true);
    assert_eq!(arrivals(&sockets[0], &sockets[1], to, 2, 100).len(), 0);
}

#[test]
fn hosts_reach_each_other_over_the_air_alone_and_leave_nothing_behind() {
    let network = Network::make(2, 1).unwrap();
    let [a, b] = network.hosts() else { panic!("two hosts") };
    let sockets = [a, b].map(socket);
    network.relay().part(&[1]);
    let over_manage = SocketAddr::from((b.manage, 5000));
    assert_eq!(arrivals(&sockets[0], &sockets[1], over_manage, 2, 100).len(), 0);
    let mut held = a.command(Path::new("sleep"));
    let mut held = held.arg("1000").spawn().unwrap();
    drop(network);
    let ended = held.wait().unwrap();
    assert!(!ended.success(), "a program of the run does not outlive it");
    let left = Command::new("ip").args(["netns", "list"]).output().unwrap();
    assert!(!String::from_utf8_lossy(&left.stdout).contains("skein-mh-"));
}
