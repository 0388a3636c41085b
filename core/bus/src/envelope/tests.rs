//! The seal against strangers, changes, replays and earlier runs.

use super::*;
use proptest::prelude::*;

const A: NodeId = NodeId(1);
const B: NodeId = NodeId(2);

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn seal(node: NodeId, boot: u64) -> SecureEnvelope {
    let key = SwarmKey::derive("geese", b"sixteen bytes or more").unwrap();
    SecureEnvelope::new(key, node, Boot(boot))
}

fn content(seal: &mut SecureEnvelope, to: To) -> Vec<u8> {
    seal.seal(to, Class::State, b"content")
}

/// Lets each prove itself to the other.
fn meet(now: NodeTime, a: &mut SecureEnvelope, b: &mut SecureEnvelope) {
    let hello = content(a, To::All);
    assert_eq!(b.open(now, &hello), Opened::Nothing);
    for _ in 0..3 {
        for (_, reply) in b.take_replies() {
            a.open(now, &reply);
        }
        for (_, reply) in a.take_replies() {
            b.open(now, &reply);
        }
    }
    assert!(a.run_of(b.me) == Some(b.boot) && b.run_of(a.me) == Some(a.boot));
}

fn opens(opened: &Opened) -> bool {
    matches!(opened, Opened::Content { bytes, .. } if bytes == b"content")
}

#[test]
fn what_is_sealed_opens_once_for_whom_it_is_meant() {
    let (mut a, mut b, mut c) = (seal(A, 10), seal(B, 20), seal(NodeId(3), 30));
    meet(at(0.0), &mut a, &mut b);
    meet(at(0.0), &mut a, &mut c);
    let for_b = content(&mut a, To::One(B));
    assert_eq!(c.open(at(1.0), &for_b), Opened::Nothing);
    assert_eq!(c.refused().strangers, 1);
    assert!(opens(&b.open(at(1.0), &for_b)));
    assert_eq!(b.open(at(1.0), &for_b), Opened::Nothing);
    assert_eq!(b.refused().replayed, 1);
    let for_all = content(&mut a, To::All);
    assert!(opens(&b.open(at(1.0), &for_all)) && opens(&c.open(at(1.0), &for_all)));
    assert_eq!(a.open(at(1.0), &for_all), Opened::Nothing);
    assert_eq!(a.refused().own, 1);
}

#[test]
fn an_earlier_run_is_not_heard_whatever_was_recorded_of_it() {
    let (mut a, mut b) = (seal(A, 10), seal(B, 20));
    let hello = content(&mut a, To::All);
    b.open(at(0.0), &hello);
    let mut recorded = vec![hello];
    let challenge = b.take_replies().remove(0).1;
    a.open(at(0.0), &challenge);
    recorded.extend(a.take_replies().into_iter().map(|(_, reply)| reply));
    for reply in recorded.clone() {
        b.open(at(0.0), &reply);
    }
    assert_eq!(b.run_of(A), Some(Boot(10)));
    let said = content(&mut a, To::All);
    assert!(opens(&b.open(at(0.0), &said)));
    recorded.push(said);
    // The receiver starts again, and somebody plays it all that the sender ever said to it.
    let mut again = seal(B, 21);
    for (step, datagram) in recorded.iter().cycle().take(20).enumerate() {
        let opened = again.open(at(step as f64), datagram);
        assert_eq!(opened, Opened::Nothing);
    }
    assert_eq!(again.run_of(A), None);
    // The sender starts again, and is known; its earlier run is not taken for it any more.
    let mut anew = seal(A, 11);
    meet(at(30.0), &mut anew, &mut b);
    assert_eq!(b.run_of(A), Some(Boot(11)));
    for datagram in &recorded {
        assert_eq!(b.open(at(31.0), datagram), Opened::Nothing);
    }
    assert_eq!(b.run_of(A), Some(Boot(11)));
}

#[test]
fn a_proof_may_take_longer_than_the_pause_between_two_questions() {
    let (mut a, mut b) = (seal(A, 10), seal(B, 20));
    let mut questions = Vec::new();
    for step in 0..10 {
        let hello = content(&mut a, To::All);
        b.open(at(f64::from(step) * 0.1), &hello);
        questions.extend(b.take_replies());
    }
    // At 0, 0.2 and 0.5 s: after twice as long each time.
    assert_eq!(questions.len(), 3);
    a.open(at(2.0), &questions[0].1);
    let proof = a.take_replies().remove(0).1;
    assert_eq!(
        b.open(at(3.0), &proof),
        Opened::Joined {
            from: A,
            boot: Boot(10)
        }
    );
}

#[test]
fn another_secret_or_swarm_opens_nothing_and_a_short_secret_is_refused() {
    let mut a = seal(A, 10);
    let others = [
        SwarmKey::derive("ducks", b"sixteen bytes or more").unwrap(),
        SwarmKey::derive("geese", b"sixteen bytes or less").unwrap(),
    ];
    for key in others {
        let mut stranger = SecureEnvelope::new(key, B, Boot(20));
        let hello = content(&mut stranger, To::All);
        assert_eq!(a.open(at(0.0), &hello), Opened::Nothing);
        assert!(a.take_replies().is_empty(), "a stranger is not answered");
    }
    assert_eq!(a.refused().strangers, 2);
    assert_eq!(
        SwarmKey::derive("geese", b"too short").unwrap_err(),
        WeakSecret { bytes: 9 }
    );
}

proptest! {
    #[test]
    fn whatever_is_changed_does_not_open(place in any::<prop::sample::Index>(), by in 1_u8..=255) {
        let (mut a, mut b) = (seal(A, 10), seal(B, 20));
        meet(at(0.0), &mut a, &mut b);
        let mut datagram = content(&mut a, To::One(B));
        let place = place.index(datagram.len());
        datagram[place] ^= by;
        prop_assert_eq!(b.open(at(1.0), &datagram), Opened::Nothing);
    }

    #[test]
    fn noise_is_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert_eq!(seal(A, 10).open(at(0.0), &bytes), Opened::Nothing);
    }
}
