//! Everybody is called soon and later seldom, one at a time.

use super::{PACE, PUT_OFF, Rounds};
use crate::Peer;
use std::collections::BTreeMap;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::time::Duration;

fn host(last: u8) -> Peer {
    Peer {
        address: Ipv4Addr::new(10, 0, 0, last),
        port: None,
    }
}

/// All calls until then, with their times.
fn calls(rounds: &mut Rounds, until: Duration) -> Vec<(Duration, SocketAddrV4)> {
    let (mut now, mut calls) = (Duration::ZERO, Vec::new());
    while now < until {
        match rounds.call(now) {
            Some(called) => calls.push((now, called)),
            None => assert!(rounds.next() > now, "it would be asked again at once"),
        }
        now = now.max(rounds.next());
    }
    calls
}

#[test]
fn everybody_is_called_at_once_but_not_at_the_same_moment() {
    let peers: Vec<Peer> = (1..=6).map(host).collect();
    for drawn in [0.0, 0.5, 1.0] {
        let mut rounds = Rounds::new(&peers, 0, drawn, |_| false);
        let calls = calls(&mut rounds, Duration::from_secs(1));
        let (first, last) = (calls[0].0, calls[191].0);
        assert_eq!(first, PUT_OFF.mul_f64(drawn));
        assert!(last < Duration::from_secs(1));
        assert!(calls.windows(2).all(|two| two[1].0 >= two[0].0 + PACE));
        // The first ones of every host before the second ones of any.
        assert!(calls[..6].iter().all(|(_, at)| at.port() == 7410));
    }
}

#[test]
fn later_the_likely_ones_are_called_often_and_the_others_each_minute() {
    let mut rounds = Rounds::new(&[host(1)], 0, 0.0, |_| false);
    let minute = Duration::from_secs(60);
    let calls = calls(&mut rounds, 21 * minute);
    let mut of = BTreeMap::<u16, u32>::new();
    for (_, at) in calls.iter().filter(|(when, _)| *when >= minute) {
        *of.entry(at.port()).or_default() += 1;
    }
    assert_eq!(of.len(), 32);
    for (port, count) in of {
        let expected = if port < 7418 { 240 } else { 20 };
        assert!(count.abs_diff(expected) <= 1, "{port}: {count}");
    }
}

#[test]
fn who_is_named_twice_is_called_once_and_itself_never() {
    let named = Peer {
        port: Some(7412),
        ..host(1)
    };
    let own = SocketAddrV4::new(host(1).address, 7410);
    let mut rounds = Rounds::new(&[host(1), named, host(1)], 0, 0.0, |place| *place == own);
    let calls = calls(&mut rounds, Duration::from_millis(900));
    assert_eq!(calls.len(), 31);
    assert!(calls.iter().all(|(_, at)| *at != own));
}
