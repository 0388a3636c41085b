//! Links between clocks that do not agree, and over a link that fills up.

use super::*;
use crate::budget::BudgetSettings;
use crate::bus::{Bus, BusSettings, Event, pump};
use crate::envelope::SwarmKey;
use crate::latest::Key;
use crate::local::{Hub, Local};
use crate::radio::{Air, AirSettings, Radio};

const A: (NodeId, Boot) = (NodeId(1), Boot(1));
const B: (NodeId, Boot) = (NodeId(2), Boot(2));

fn links() -> Links {
    Links::new(LinkSettings::default(), 100_000.0, NodeTime(0))
}

/// Reports to and fro for a while; B's clock is ahead by 1234.5 s, each way takes its own time. Gives what A knows of B.
fn exchanged(there_s: f64, back_s: impl Fn(u32) -> f64) -> Link {
    const AHEAD_S: f64 = 1234.5;
    let (mut a, mut b) = (links(), links());
    for step in 0..20 {
        let now_s = f64::from(step);
        let report = a.report(NodeTime::from_seconds(now_s), 1000, 0).unwrap();
        let at_b = NodeTime::from_seconds(now_s + there_s + AHEAD_S);
        b.take(at_b, B, A.0, A.1, &report);
        let answered_s = now_s + there_s + 0.1;
        let report = b.report(NodeTime::from_seconds(answered_s + AHEAD_S), 1000, 0).unwrap();
        let at_a = NodeTime::from_seconds(answered_s + back_s(step));
        a.take(at_a, A, B.0, B.1, &report);
    }
    a.known().next().unwrap().1
}

#[test]
fn round_trip_and_offset_are_found_whatever_the_clocks_say() {
    let link = exchanged(0.02, |_| 0.02);
    assert!((link.round_trip_s - 0.04).abs() < 1e-5 && (link.offset_s - 1234.5).abs() < 1e-5);
    // Ways of different length are what can't be known: the error says so.
    let link = exchanged(0.01, |_| 0.05);
    let error_s = (link.offset_s - 1234.5).abs();
    assert!(
        (error_s - 0.02).abs() < 1e-5 && error_s <= link.offset_error_s,
        "{link:?}"
    );
    // One quick round trip of the last eight is enough.
    let link = exchanged(0.01, |step| if step == 15 { 0.01 } else { 0.3 });
    assert!((link.offset_s - 1234.5).abs() < 1e-5, "{link:?}");
}

#[test]
fn what_is_lost_on_the_way_is_counted() {
    // Of ten datagrams to all between two reports so many come; a quarter of the reports does not come either.
    let after = |come: u64, seconds: u32| {
        let (mut a, mut b) = (links(), links());
        for step in 0..seconds * 2 {
            let now = NodeTime::from_seconds(f64::from(step) * 0.5);
            let sent = u64::from(step) * 11;
            let told = b.report(now, 1000, sent).unwrap();
            let echoed = a.report(now, 1000, 0).unwrap();
            b.take(now, B, A.0, A.1, &echoed);
            if step % 4 != 3 {
                a.count_for_all(B.0, B.1);
                a.take(now, A, B.0, B.1, &told);
            }
            for _ in 0..come {
                a.count_for_all(B.0, B.1);
            }
        }
        a.known().next().unwrap().1.loss.unwrap()
    };
    let (whole, half, none) = (after(10, 60), after(5, 60), after(0, 60));
    assert!(whole < 0.05, "{whole}");
    assert!((half - (1.0 - 5.75 / 11.0)).abs() < 0.04, "{half}");
    assert!((none - (1.0 - 0.75 / 11.0)).abs() < 0.04, "{none}");
}

#[test]
fn loss_is_of_late_and_of_this_run_only() {
    let mut a = links();
    let report = |at: f64, sent: Option<u64>| Report {
        told: NodeTime::from_seconds(at),
        echoes: vec![Echo {
            node: A.0,
            boot: A.1,
            told: NodeTime::from_seconds(at),
            held_us: 0,
            queued_us: 0,
        }],
        sent_to_all: sent,
    };
    let loss = |a: &Links| a.known().next().unwrap().1.loss;
    let mut hear = |at: f64, boot: Boot, sent: Option<u64>, come: u64| {
        for _ in 0..come {
            a.count_for_all(B.0, boot);
        }
        let now = NodeTime::from_seconds(at);
        a.take(now, A, B.0, boot, &report(at, sent));
        loss(&a)
    };
    // Who does not tell how much was sent has lost nothing that is known of.
    assert_eq!(hear(0.0, B.1, None, 0), None);
    assert_eq!(hear(1.0, B.1, Some(100), 3), None);
    assert_eq!(hear(2.0, B.1, Some(200), 50), Some(0.5));
    // Overtaken.
    assert_eq!(hear(2.1, B.1, Some(150), 0), Some(0.5));
    for step in 0..25 {
        let at = 3.0 + f64::from(step);
        hear(at, B.1, Some(300 + step as u64 * 100), 100);
    }
    assert_eq!(hear(28.0, B.1, Some(2800), 100), Some(0.0));
    // Begun anew it counts anew.
    assert_eq!(hear(29.0, Boot(9), Some(7), 0), None);
    assert_eq!(hear(30.0, Boot(9), Some(17), 10), Some(0.0));
}

#[test]
fn who_was_slowed_down_and_is_heard_by_nobody_is_not_slow_for_ever() {
    let mut a = links();
    let echo = |held_us: u64, told: NodeTime, queued_us: u64| Echo {
        node: A.0,
        boot: A.1,
        told,
        held_us,
        queued_us,
    };
    let at = |step: u32| NodeTime::from_seconds(10.0 + f64::from(step) * 0.5);
    let mut rates = Vec::new();
    for step in 0..80 {
        let told = at(step).plus_seconds(-0.1);
        // at first B says that what A sends waits for a second, then it does not hear A any more
        let echoes = if step < 40 {
            vec![echo(0, told, 1_000_000)]
        } else {
            Vec::new()
        };
        a.take(
            at(step),
            A,
            B.0,
            B.1,
            &Report {
                told,
                echoes,
                sent_to_all: None,
            },
        );
        a.adapt(at(step), 2000.0, 1);
        rates.push(a.rates().all_bytes_per_s);
    }
    assert!(rates[39] <= 1000.0, "slowed down: {}", rates[39]);
    assert!(rates[79] > 10_000.0, "and up again: {}", rates[79]);
}

#[test]
fn a_way_that_has_become_longer_is_not_taken_for_a_full_one_for_long() {
    let (mut a, mut b) = (links(), links());
    let way_s = |now_s: f64| if now_s < 20.0 { 0.02 } else { 0.25 };
    let mut overfull_s = 0.0;
    for step in 0..120_u32 {
        let now_s = f64::from(step) * 0.5;
        let at = |seconds: f64| NodeTime::from_seconds(seconds);
        let report = a.report(at(now_s), 1000, 0).unwrap();
        b.take(at(now_s + way_s(now_s)), B, A.0, A.1, &report);
        let report = b.report(at(now_s + 0.25), 1000, 0).unwrap();
        a.take(at(now_s + 0.25 + way_s(now_s)), A, B.0, B.1, &report);
        let queued_s = a.known().next().map_or(0.0, |(_, link)| link.queued_s);
        overfull_s += if queued_s > 0.2 { 0.5 } else { 0.0 };
        assert!(now_s < 42.0 || queued_s < 0.05, "{queued_s} s at {now_s} s");
    }
    assert!((1.0..21.0).contains(&overfull_s), "{overfull_s}");
}

#[test]
fn of_an_earlier_run_nothing_counts() {
    let (mut a, mut b) = (links(), links());
    let report = a.report(NodeTime::from_seconds(1.0), 1000, 0).unwrap();
    b.take(NodeTime::from_seconds(2.0), B, A.0, A.1, &report);
    let report = b.report(NodeTime::from_seconds(2.1), 1000, 0).unwrap();
    let again = (A.0, Boot(9));
    a.take(NodeTime::from_seconds(1.2), again, B.0, B.1, &report);
    assert_eq!(a.known().count(), 0);
}

#[test]
fn with_too_little_room_all_have_their_turn() {
    let mut a = links();
    let empty = Report {
        told: NodeTime(0),
        echoes: Vec::new(),
        sent_to_all: None,
    };
    for node in 10..30 {
        a.take(NodeTime(5), A, NodeId(node), Boot(1), &empty);
    }
    let mut seen = std::collections::BTreeSet::new();
    for step in 1..=4 {
        let report = a
            .report(
                NodeTime::from_seconds(f64::from(step) * 2.0),
                COUNT_BYTES + 5 * ECHO_BYTES,
                0,
            )
            .unwrap();
        seen.extend(report.echoes.iter().map(|echo| echo.node));
        assert!(minicbor::to_vec(&report).unwrap().len() <= 5 * ECHO_BYTES + 16);
    }
    assert_eq!(seen.len(), 20);
}

/// Six nodes whose places are told ten times a second share 256 kbit/s; one sends bulk as fast as it may. Gives how old places are when they
/// arrive, sorted, and how much of the bulk has come after a minute.
fn slow_radio(adapts: bool) -> (Vec<f64>, usize) {
    let air = AirSettings {
        bits_per_s: 256_000.0,
        delay_s: 0.005,
        loss: 0.05,
        ..AirSettings::default()
    };
    let air = Air::new(air, 4);
    let hub = Hub::default();
    let never = LinkSettings {
        full_after_s: f64::INFINITY,
        overfull_after_s: f64::INFINITY,
        ..LinkSettings::default()
    };
    let settings = BusSettings {
        links: if adapts { LinkSettings::default() } else { never },
        budget: BudgetSettings {
            bytes_per_s: 100_000.0,
            burst_bytes: 6000.0,
        },
        ..BusSettings::default()
    };
    let mut nodes: Vec<(Bus, Radio<Local>)> = (1..=6)
        .map(|node| {
            let key = SwarmKey::derive("geese", b"sixteen bytes or more").unwrap();
            let bus = Bus::new(settings, key, NodeId(node), Boot(node), NodeTime(0));
            (bus, air.radio(hub.join(NodeId(node))))
        })
        .collect();
    let (mut ages, mut things) = (Vec::new(), 0);
    for step in 1..=6000_u64 {
        let now = NodeTime(step * 10_000);
        for (index, (bus, radio)) in nodes.iter_mut().enumerate() {
            if step % 10 == index as u64 {
                let mut place = now.0.to_be_bytes().to_vec();
                place.resize(40, 0);
                bus.tell(now, Key(1), place).unwrap();
            }
            if index == 0 {
                let _one_at_a_time = bus.send(now, NodeId(2), vec![0; 10_000]);
            }
            for event in pump(bus, radio, now).unwrap() {
                match event {
                    Event::State { value, .. } if step > 2000 => {
                        let told = u64::from_be_bytes(value[..8].try_into().unwrap());
                        ages.push(now.seconds_since(NodeTime(told)));
                    }
                    Event::Bulk { .. } => things += 1,
                    _ => {}
                }
            }
        }
    }
    ages.sort_by(f64::total_cmp);
    (ages, things)
}

#[test]
fn on_a_full_link_a_node_slows_down_until_state_is_in_time_again() {
    let at = |ages: &[f64], share: f64| ages[((ages.len() - 1) as f64 * share) as usize];
    let (plain, things) = slow_radio(false);
    let (adapted, adapted_things) = slow_radio(true);
    for (name, ages, things) in [
        ("as fast as it may", &plain, things),
        ("adapted", &adapted, adapted_things),
    ] {
        println!(
            "256 kbit/s, six nodes, one sends bulk {name}: places are {:.0} ms old (p50), {:.0} ms (p99), {} came; {things} things of 10 kB",
            at(ages, 0.5) * 1e3,
            at(ages, 0.99) * 1e3,
            ages.len()
        );
    }
    assert!(at(&adapted, 0.5) < 0.1 && at(&adapted, 0.5) * 3.0 < at(&plain, 0.5));
    assert!(adapted_things * 4 > things, "the link is used all the same");
}
