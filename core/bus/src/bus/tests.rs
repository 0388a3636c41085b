//! One node's end: priorities, budget, figures, and what is not understood.

use super::*;
use crate::transport::CLASSES;

const A: NodeId = NodeId(1);
const B: NodeId = NodeId(2);

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn bus(node: NodeId, bytes_per_s: f64) -> Bus {
    let budget = BudgetSettings {
        bytes_per_s,
        burst_bytes: 6000.0,
    };
    let settings = BusSettings {
        budget,
        ..BusSettings::default()
    };
    let key = SwarmKey::derive("geese", b"sixteen bytes or more").unwrap();
    Bus::new(settings, key, node, Boot(node.0 + 100), at(0.0))
}

/// Carries everything between the two at once, until there is nothing more.
fn carry(now: NodeTime, a: &mut Bus, b: &mut Bus) -> Vec<Event> {
    let mut events = Vec::new();
    loop {
        let (there, back) = (a.next(now), b.next(now));
        if there.is_none() && back.is_none() {
            return events;
        }
        events.extend(there.into_iter().flat_map(|sent| b.take(now, &sent.bytes)));
        events.extend(back.into_iter().flat_map(|sent| a.take(now, &sent.bytes)));
    }
}

fn met() -> (Bus, Bus) {
    let (mut a, mut b) = (bus(A, 1e6), bus(B, 1e6));
    a.tell(at(0.0), Key(0), vec![1]).unwrap();
    carry(at(0.0), &mut a, &mut b);
    assert!(a.run_of(B).is_some() && b.run_of(A).is_some());
    (a, b)
}

#[test]
fn the_most_urgent_goes_first_and_bulk_last() {
    let (mut a, _) = met();
    let now = at(1.5);
    a.send(now, B, vec![0; 5000]).unwrap();
    a.send_video(now, B, 1, true, &[4; 20]);
    a.ask(now, B, vec![1], 1.0).unwrap();
    a.tell(now, Key(1), vec![2]).unwrap();
    a.post(now, B, vec![3]).unwrap();
    let mut classes: Vec<Class> = std::iter::from_fn(|| a.next(now)).map(|sent| sent.class).collect();
    assert!(classes.is_sorted());
    classes.dedup();
    assert_eq!(classes, CLASSES);
}

#[test]
fn on_a_slow_link_state_is_told_less_often_but_newest_and_commands_do_not_wait() {
    let (mut a, mut b) = (bus(A, 2000.0), bus(B, 1e6));
    a.tell(at(0.0), Key(0), vec![0; 4]).unwrap();
    carry(at(0.0), &mut a, &mut b);
    let (mut told, mut bytes, mut waited) = (0, 0, 0);
    for step in 1..=2000_u32 {
        let now = at(f64::from(step) * 0.01);
        for key in 0..5 {
            a.tell(now, Key(key), [step.to_be_bytes(); 25].concat()).unwrap();
        }
        if step % 100 == 0 {
            a.post(now, B, b"now".to_vec()).unwrap();
            waited += 1;
        }
        while let Some(sent) = a.next(now) {
            bytes += sent.bytes.len();
            for event in b.take(now, &sent.bytes) {
                match event {
                    Event::State { value, .. } => {
                        told += 1;
                        assert_eq!(value[..4], step.to_be_bytes(), "as new as can be");
                    }
                    Event::Command { .. } => waited -= 1,
                    _ => {}
                }
            }
        }
        assert_eq!(waited, 0, "a command waits at step {step}");
        while let Some(sent) = b.next(now) {
            a.take(now, &sent.bytes);
        }
    }
    println!("{told} of 10000 values told in 20 s at 2 kB/s, {bytes} bytes");
    assert!((100..400).contains(&told), "{told}");
    assert!(bytes as f64 <= 2000.0 * 20.0 + 2.0 * 6000.0, "{bytes}");
}

#[test]
fn a_question_is_sent_again_until_its_time_is_up() {
    let (mut a, mut b) = met();
    let begun = at(2.0);
    carry(begun, &mut a, &mut b);
    let deadline = a.ask(begun, B, vec![1], 0.7).map(|_| at(2.7)).unwrap();
    let mut lost = Vec::new();
    let mut now = begun;
    while now <= deadline.plus_seconds(0.02) {
        while let Some(sent) = a.next(now) {
            lost.push(sent);
        }
        let events = a.expire(now);
        if !events.is_empty() {
            assert!(matches!(events[..], [Event::Unanswered { .. }]));
            break;
        }
        now = now.plus_seconds(0.01);
    }
    assert!(now.seconds_since(deadline).abs() < 0.011, "{now:?}");
    assert_eq!(
        lost.iter().filter(|sent| sent.class == Class::Query).count(),
        3,
        "at 0, 0.2, 0.6 s"
    );
}

#[test]
fn what_is_too_large_is_refused_and_the_largest_fits() {
    let (mut a, mut b) = met();
    let most = a.body_bytes();
    let now = at(1.0);
    assert!(matches!(a.post(now, B, vec![0; most + 1]), Err(PostError::TooLarge(_))));
    assert!(matches!(
        a.ask(now, B, vec![0; most + 1], 1.0),
        Err(AskError::TooLarge(_))
    ));
    assert!(matches!(
        a.tell(now, Key(1), vec![0; most]),
        Err(StateError::TooLarge { .. })
    ));
    a.post(now, B, vec![255; most]).unwrap();
    a.ask(now, B, vec![255; most], 1.0).unwrap();
    a.tell(now, Key(u32::MAX), vec![255; most - ENTRY_BYTES]).unwrap();
    a.send(now, B, vec![255; 10 * most]).unwrap();
    let mut sent = 0;
    let mut due = (0..20_u32).flat_map(|step| {
        let now = at(1.0 + f64::from(step) * 0.01);
        std::iter::from_fn(|| a.next(now)).collect::<Vec<Outgoing>>()
    });
    for outgoing in &mut due {
        assert!(
            outgoing.bytes.len() <= BusSettings::default().datagram_bytes,
            "{}",
            outgoing.bytes.len()
        );
        b.take(now, &outgoing.bytes);
        sent += 1;
    }
    assert!(sent >= 13, "{sent}");
    assert_eq!(b.not_understood(), 0);
}

#[test]
fn what_goes_over_a_link_is_counted() {
    let (mut a, mut b) = met();
    let before = a.sent().total_bytes();
    a.post(at(1.0), B, vec![0; 100]).unwrap();
    let sent = a.next(at(1.0)).unwrap();
    b.take(at(1.0), &sent.bytes);
    assert_eq!(a.sent().total_bytes() - before, sent.bytes.len() as u64);
    let received = b.received()[&A];
    assert_eq!(received.datagrams[Class::Command as usize], 1);
    assert_eq!(received.bytes[Class::Command as usize], sent.bytes.len() as u64);
}

#[test]
fn a_frame_of_a_later_version_is_counted_and_passed_over() {
    let (mut a, mut b) = met();
    let unknown = a.seal.seal(To::One(B), Class::State, &[0x82, 0x18, 0x63, 0x80]);
    assert!(b.take(at(1.0), &unknown).is_empty());
    assert_eq!(b.not_understood(), 1);
}

#[test]
fn signs_of_life_are_not_held_up_by_what_was_sent_before() {
    let (mut a, mut b) = (bus(A, 4000.0), bus(B, 4000.0));
    let (mut pulses, mut longest_s, mut last_s) = (0_u32, 0.0_f64, 0.0);
    for step in 0..1000_u32 {
        let now_s = f64::from(step) * 0.01;
        if step % 10 == 0 {
            a.tell(at(now_s), Key(0), step.to_be_bytes().to_vec()).unwrap();
        }
        // Far more than there is room for.
        for one in 1..40 {
            let mut value = vec![0; 200];
            value[..4].copy_from_slice(&step.to_be_bytes());
            a.tell(at(now_s), Key(one), value).unwrap();
        }
        for event in carry(at(now_s), &mut a, &mut b) {
            if matches!(event, Event::State { key: Key(0), .. }) {
                pulses += 1;
                longest_s = longest_s.max(now_s - last_s);
                last_s = now_s;
            }
        }
    }
    assert!(pulses >= 95 && longest_s < 0.15, "{pulses}, {longest_s} s without one");
    let sent = a.sent().total_bytes();
    assert!(sent < 55_000, "{sent}: what is small is paid for");
}
