//! The scenes of the suite.
//!
//! Must never do: assume that something arrives at the first try, or at a certain time.

use super::{A, B, C, PATIENCE_S, Rig, SECRET, Scene, body, number};
use crate::bus::Event;
use crate::courier::Outcome;
use crate::latest::Key;
use crate::transport::{CLASSES, Class, Datagram, SendError, To, Transport};
use skein_domain::NodeId;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Sends over and over, for a transport may lose; gives what each of the others got.
fn sent_until_there<R: Rig>(
    rig: &mut R,
    nodes: &mut [R::Transport],
    to: To,
    class: Class,
    bytes: &[u8],
) -> Vec<(NodeId, Datagram)> {
    let meant = |node: NodeId| to == To::One(node) || (to == To::All && node != A);
    let (begun, mut got) = (rig.step(), Vec::new());
    loop {
        let now = rig.step();
        let sent = nodes[0].send(now, to, class, bytes);
        assert_eq!(sent, Ok(()));
        for node in nodes.iter_mut() {
            while let Some(datagram) = node.receive(now) {
                // What was sent before may still be on its way.
                if datagram.bytes == bytes {
                    got.push((node.node(), datagram));
                }
            }
        }
        let there = |node: &R::Transport| !meant(node.node()) || got.iter().any(|(at, _)| *at == node.node());
        if nodes.iter().all(there) {
            return got;
        }
        assert!(
            now.seconds_since(begun) < PATIENCE_S,
            "{class:?} to {to:?} does not arrive"
        );
    }
}

/// A datagram reaches whom it is for and nobody else, whole, with its class and sender; one that is too large is refused.
pub(super) fn datagrams_go_where_they_are_meant_to<R: Rig>(rig: &mut R) {
    let mut nodes = [rig.join(A), rig.join(B), rig.join(C)];
    let largest = nodes[0].largest_bytes();
    assert!(largest >= 256, "{largest} bytes carry no command");
    let mut count = 0_u8;
    for to in [To::One(B), To::One(C), To::All] {
        for class in CLASSES {
            count += 1;
            let length = largest / usize::from(count);
            // No two are alike, and none is of one byte only.
            let bytes: Vec<u8> = (0..length).map(|index| (index as u8).wrapping_mul(count)).collect();
            for (at, datagram) in sent_until_there(rig, &mut nodes, to, class, &bytes) {
                assert_eq!((datagram.from, datagram.class), (A, class));
                assert!(
                    to == To::One(at) || (to == To::All && at != A),
                    "{at} got what was for {to:?}"
                );
            }
        }
    }
    let now = rig.step();
    let too_large = nodes[0].send(now, To::One(B), Class::Bulk, &vec![0; largest + 1]);
    assert!(matches!(too_large, Err(SendError::TooLarge { .. })), "{too_large:?}");
    let nobody = nodes[0].send(now, To::One(NodeId(0xdead)), Class::State, b"?");
    assert_eq!(nobody, Ok(()), "that nobody is there is no error");
}

/// Whoever sleeps until something arrives is woken when it does.
pub(super) fn who_waits_is_woken<R: Rig>(rig: &mut R) {
    let (mut a, mut b) = (rig.join(A), rig.join(B));
    let woken = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&woken);
    b.wake_on_arrival(Arc::new(move || flag.store(true, Ordering::Release)));
    let begun = rig.step();
    while !woken.load(Ordering::Acquire) {
        let now = rig.step();
        assert!(now.seconds_since(begun) < PATIENCE_S, "nobody is woken");
        assert_eq!(a.send(now, To::One(B), Class::Command, b"wake up"), Ok(()));
    }
    let now = rig.step();
    assert!(b.receive(now).is_some(), "woken for nothing");
}

/// Values arrive in the order of their versions, some may be passed over, and the last one arrives.
pub(super) fn the_newest_state_is_known<R: Rig>(rig: &mut R) {
    let mut scene = Scene::new(rig, &[A, B, C]);
    scene.meet();
    for value in 1..=200 {
        let now = scene.now;
        for key in [Key(1), Key(2)] {
            assert_eq!(scene.bus(A).tell(now, key, body(value)), Ok(()));
        }
        scene.step();
    }
    let values = |scene: &Scene<R>, at: NodeId, of: Key| -> Vec<u32> {
        let events = scene.events(at).iter();
        let told = events.filter_map(|event| match event {
            Event::State { from: A, key, value } if *key == of => Some(number(value)),
            _ => None,
        });
        told.collect()
    };
    scene.until("the last values are known", |scene| {
        let known = |at| {
            [Key(1), Key(2)]
                .into_iter()
                .all(|key| values(scene, at, key).last() == Some(&200))
        };
        known(B) && known(C)
    });
    for at in [B, C] {
        let seen = values(&scene, at, Key(1));
        assert!(seen.windows(2).all(|pair| pair[0] < pair[1]), "{at}: {seen:?}");
    }
}

/// A node that comes later is told what was told before it came.
pub(super) fn who_joins_late_learns_what_is_so<R: Rig>(rig: &mut R) {
    let mut scene = Scene::new(rig, &[A, B]);
    let now = scene.now;
    for key in 1..=40 {
        assert_eq!(scene.bus(A).tell(now, Key(key), vec![key as u8; 100]), Ok(()));
    }
    scene.run(3.0);
    scene.join(C, SECRET);
    scene.until("the late one knows everything", |scene| {
        (1..=40).all(|wanted| {
            scene.saw(
                C,
                |event| matches!(event, Event::State { from: A, key, .. } if key.0 == wanted),
            )
        })
    });
}

/// Both ways at once: each command is delivered once, in order, and its sender hears of it.
pub(super) fn commands_come_once_and_in_order<R: Rig>(rig: &mut R) {
    const COMMANDS: u32 = 60;
    let mut scene = Scene::new(rig, &[A, B]);
    scene.meet();
    for command in 1..=COMMANDS {
        let now = scene.now;
        for (from, to) in [(A, B), (B, A)] {
            let posted = scene.bus(from).post(now, to, body(command));
            assert_eq!(posted, Ok(u64::from(command)));
        }
        scene.run(0.02);
    }
    scene.until("all commands have ended", |scene| {
        let ended = |node| {
            let events = scene.events(node).iter();
            events
                .filter(|event| matches!(event, Event::CommandEnded { .. }))
                .count()
        };
        ended(A) == COMMANDS as usize && ended(B) == COMMANDS as usize
    });
    for (at, of) in [(A, B), (B, A)] {
        let got = scene.commands(at, of);
        assert!(got.windows(2).all(|pair| pair[0] < pair[1]), "{at}: {got:?}");
        let delivered = scene.events(of).iter().filter_map(|event| match event {
            Event::CommandEnded {
                number,
                outcome: Outcome::Delivered,
                ..
            } => Some(*number as u32),
            _ => None,
        });
        let delivered: Vec<u32> = delivered.collect();
        assert!(
            delivered.iter().all(|command| got.contains(command)),
            "{of} was told of one that {at} never got"
        );
        assert!(
            delivered.len() * 10 >= COMMANDS as usize * 9,
            "only {} of {COMMANDS} delivered",
            delivered.len()
        );
    }
}

/// The receiver, then the sender, starts again: what follows is delivered, nothing twice.
pub(super) fn who_starts_again_is_served_again<R: Rig>(rig: &mut R) {
    let mut scene = Scene::new(rig, &[A, B]);
    scene.meet();
    for (restarts, first) in [(B, 1), (B, 100), (A, 200)] {
        let now = scene.now;
        assert!(scene.bus(A).post(now, B, body(first)).is_ok());
        scene.until("a command is there", |scene| scene.commands(B, A).contains(&first));
        scene.join(restarts, SECRET);
        scene.meet();
        let before = scene.commands(B, A);
        let now = scene.now;
        assert!(scene.bus(A).post(now, B, body(first + 1)).is_ok());
        scene.until("a command after the start is there", |scene| {
            scene.commands(B, A).contains(&(first + 1))
        });
        scene.run(2.0);
        let after = scene.commands(B, A);
        assert_eq!(after.len(), before.len() + 1, "{before:?}, then {after:?}");
    }
}

/// A question is answered once, or its asker is told that it was not.
pub(super) fn questions_have_one_end<R: Rig>(rig: &mut R) {
    let mut scene = Scene::new(rig, &[A, B]);
    scene.meet();
    let now = scene.now;
    let asked = scene.bus(A).ask(now, B, b"how high?".to_vec(), 20.0);
    let unheard = scene.bus(A).ask(now, NodeId(0xdead), b"anybody?".to_vec(), 1.0);
    let (Ok(asked), Ok(unheard)) = (asked, unheard) else {
        panic!("{asked:?}, {unheard:?}");
    };
    let answered =
        |event: &Event| matches!(event, Event::Answered { id, from: B, body } if *id == asked && body == b"120 m");
    let mut seen = 0;
    let begun = scene.now;
    while !scene.saw(A, answered) {
        assert!(scene.now.seconds_since(begun) < PATIENCE_S, "no answer");
        scene.step();
        let events = scene.events(B).to_vec();
        for event in events.iter().skip(seen) {
            if let Event::Asked { ticket, body } = event {
                assert_eq!((ticket.from, &body[..]), (A, &b"how high?"[..]));
                assert_eq!(scene.bus(B).answer(*ticket, b"120 m".to_vec()), Ok(()));
            }
        }
        seen = events.len();
    }
    scene.until("the other is given up", |scene| {
        scene.saw(
            A,
            |event| matches!(event, Event::Unanswered { id, .. } if *id == unheard),
        )
    });
    scene.run(1.0);
    let ends = scene
        .events(A)
        .iter()
        .filter(|event| matches!(event, Event::Answered { .. } | Event::Unanswered { .. }));
    assert_eq!(ends.count(), 2);
}

/// Something large comes whole, and commands sent meanwhile come before it.
pub(super) fn bulk_comes_whole_and_is_in_nobodys_way<R: Rig>(rig: &mut R) {
    let thing: Vec<u8> = (0..200_000_u32).map(|index| ((index * 31) >> 3) as u8).collect();
    let mut scene = Scene::new(rig, &[A, B]);
    scene.meet();
    let now = scene.now;
    scene.bus(A).set_bytes_per_s(now, 100_000.0);
    assert!(scene.bus(A).send(now, B, thing.clone()).is_ok());
    for command in 1..=10 {
        let now = scene.now;
        assert!(scene.bus(A).post(now, B, body(command)).is_ok());
        scene.until("a command gets past the bulk", |scene| {
            scene.commands(B, A).contains(&command)
        });
    }
    let whole = |event: &Event| matches!(event, Event::Bulk { from: A, .. });
    assert!(!scene.saw(B, whole), "the bulk was done before the commands");
    scene.until("the bulk is there and its sender knows", |scene| {
        scene.saw(B, whole) && scene.saw(A, |event| matches!(event, Event::BulkEnded { whole: true, .. }))
    });
    let same = |event: &Event| matches!(event, Event::Bulk { body, .. } if *body == thing);
    assert!(scene.saw(B, same), "changed on the way");
    let took_s = scene.now.seconds_since(now);
    assert!(
        took_s > 1.0,
        "200 kB at 100 kB/s in {took_s} s: the budget was not kept"
    );
}

/// A node with another secret is not heard, does not hear, and is counted.
pub(super) fn strangers_are_not_heard<R: Rig>(rig: &mut R) {
    let mut scene = Scene::new(rig, &[A, B]);
    scene.meet();
    scene.join(C, b"a secret of somebody else's swarm");
    let now = scene.now;
    for node in [A, C] {
        assert_eq!(scene.bus(node).tell(now, Key(7), b"here I am".to_vec()), Ok(()));
    }
    assert!(scene.bus(C).post(now, A, b"land".to_vec()).is_ok());
    scene.until("the stranger was refused", |scene| {
        let refused = |node| {
            scene
                .parties
                .get(&node)
                .map_or(0, |party| party.bus.refused().strangers)
        };
        refused(A) > 3 && refused(B) > 0 && refused(C) > 0
    });
    scene.run(3.0);
    assert!(scene.commands(A, C).is_empty());
    let of_c = |event: &Event| matches!(event, Event::Joined { node: C, .. } | Event::State { from: C, .. });
    assert!(!scene.saw(A, of_c) && !scene.saw(B, of_c));
    assert!(scene.events(C).iter().all(|event| matches!(
        event,
        Event::CommandEnded {
            outcome: Outcome::NotAnswered,
            ..
        }
    )));
}

/// What was heard before is sent again by somebody who can't open it: at once, after the receiver has started again, after the sender has.
pub(super) fn what_was_recorded_is_of_no_use<R: Rig>(rig: &mut R) {
    let mut scene = Scene::new(rig, &[A, B]);
    scene.meet();
    let now = scene.now;
    assert!(scene.bus(A).post(now, B, body(1)).is_ok());
    scene.until("the command is there", |scene| scene.commands(B, A) == [1]);
    let recorded = scene.party(B).recorded.clone();
    let mut stranger = scene.rig.join(C);
    for restarts in [None, Some(B), Some(A)] {
        if let Some(node) = restarts {
            scene.join(node, SECRET);
            scene.meet();
        }
        let before = scene.commands(B, A);
        let joined = |scene: &Scene<R>| {
            scene
                .events(B)
                .iter()
                .filter(|event| matches!(event, Event::Joined { .. }))
                .count()
        };
        let joined_before = joined(&scene);
        let refused = |scene: &Scene<R>| {
            let counts = scene
                .parties
                .get(&B)
                .map(|party| party.bus.refused())
                .unwrap_or_default();
            counts.replayed + counts.unproven
        };
        let wanted = refused(&scene) + 20;
        let begun = scene.now;
        while refused(&scene) < wanted {
            for datagram in &recorded {
                let sent = stranger.send(scene.now, To::One(B), datagram.class, &datagram.bytes);
                assert_eq!(sent, Ok(()));
            }
            scene.step();
            assert!(
                scene.now.seconds_since(begun) < PATIENCE_S,
                "what was sent again is not refused"
            );
        }
        scene.run(1.0);
        assert_eq!(scene.commands(B, A), before, "{restarts:?} has started again");
        assert_eq!(joined(&scene), joined_before);
    }
}
