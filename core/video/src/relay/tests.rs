//! Tests of who gets which picture next.

use super::*;
use crate::frame::Coding;
use proptest::prelude::*;
use skein_domain::NodeTime;

fn frame(sequence: u64, key: bool, bytes: usize) -> Arc<EncodedFrame> {
    Arc::new(EncodedFrame {
        coding: Coding::H264,
        sequence,
        taken: NodeTime(sequence * 33_000),
        width_px: 640,
        height_px: 480,
        key,
        bytes: vec![0; bytes].into(),
    })
}

#[test]
fn a_viewer_begins_with_the_newest_key_picture() {
    let mut relay = Relay::default();
    let mut cursor = Cursor::default();
    relay.push(frame(1, false, 10));
    assert_eq!(relay.next(&mut cursor), None);
    assert!(relay.waits_for_key(&cursor));
    for sequence in 2..6 {
        relay.push(frame(sequence, sequence == 3, 10));
    }
    let given: Vec<u64> = std::iter::from_fn(|| relay.next(&mut cursor))
        .map(|given| given.frame.sequence)
        .collect();
    assert_eq!(given, [3, 4, 5]);
    assert_eq!(cursor.left_out, 0);
    assert!(!relay.waits_for_key(&cursor));
}

#[test]
fn who_falls_behind_goes_on_with_the_newest_key_picture() {
    let mut relay = Relay::default();
    let mut cursor = Cursor::default();
    for sequence in 0..3 {
        relay.push(frame(sequence, sequence == 0, 10));
    }
    assert_eq!(relay.next(&mut cursor).map(|given| given.frame.sequence), Some(0));
    for sequence in 3..30 {
        relay.push(frame(sequence, sequence % 10 == 0, 10));
    }
    let given = relay.next(&mut cursor).expect("the newest group");
    assert_eq!((given.frame.sequence, given.after_gap), (20, true));
    assert_eq!(cursor.left_out, 19);
    assert_eq!(
        relay
            .next(&mut cursor)
            .map(|given| (given.frame.sequence, given.after_gap)),
        Some((21, false))
    );
}

#[test]
fn who_is_behind_within_the_newest_group_reads_on_and_waits_for_a_key_picture() {
    let mut relay = Relay::default();
    let mut cursor = Cursor::default();
    relay.push(frame(0, true, 10));
    assert!(relay.next(&mut cursor).is_some());
    for sequence in 1..20 {
        relay.push(frame(sequence, false, 10));
    }
    assert!(relay.waits_for_key(&cursor));
    assert_eq!(relay.next(&mut cursor).map(|given| given.frame.sequence), Some(1));
}

#[test]
fn a_stream_without_key_pictures_fills_no_memory() {
    let mut relay = Relay::default();
    let mut cursor = Cursor::default();
    relay.push(frame(0, true, 1 << 20));
    assert!(relay.next(&mut cursor).is_some());
    for sequence in 1..50 {
        relay.push(frame(sequence, false, 1 << 20));
    }
    assert!(relay.bytes <= MOST_KEPT_BYTES);
    // its next picture is gone, and no key picture is there: it has to wait
    assert_eq!(relay.next(&mut cursor), None);
    assert!(relay.waits_for_key(&cursor));
    relay.push(frame(50, true, 10));
    assert!(relay.next(&mut cursor).is_some_and(|given| given.after_gap));
}

proptest! {
    /// Whatever comes and however a viewer reads: it can decode what it gets, nothing comes twice, and what it did not get is counted.
    #[test]
    fn what_a_viewer_gets_can_be_decoded(steps in prop::collection::vec((any::<bool>(), 0_u8..8, 0_u8..8), 1..400)) {
        let mut relay = Relay::default();
        let mut cursor = Cursor::default();
        let (mut sequence, mut given): (u64, Vec<u64>) = (0, Vec::new());
        let mut keys = std::collections::BTreeSet::new();
        for (reads, key_one_in, frames) in steps {
            for _ in 0..frames {
                let key = key_one_in == 0;
                if key {
                    keys.insert(sequence);
                }
                relay.push(frame(sequence, key, 1_000));
                sequence += 1;
            }
            while reads && let Some(next) = relay.next(&mut cursor) {
                let number = next.frame.sequence;
                match given.last() {
                    Some(last) if !next.after_gap => prop_assert_eq!(number, last + 1),
                    Some(last) => prop_assert!(number > last + 1 && keys.contains(&number)),
                    None => prop_assert!(keys.contains(&number)),
                }
                given.push(number);
            }
            prop_assert!(relay.frames.len() <= MOST_KEPT_FRAMES);
        }
        if let (Some(first), Some(last)) = (given.first(), given.last()) {
            prop_assert_eq!(cursor.left_out, last - first + 1 - given.len() as u64);
        }
    }
}

#[test]
fn what_was_forgotten_is_given_to_nobody_and_the_rest_goes_on() {
    let mut relay = Relay::default();
    let (mut before, mut after) = (Cursor::default(), Cursor::default());
    relay.push(frame(1, true, 10));
    assert!(relay.next(&mut before).is_some());
    relay.push(frame(2, false, 10));
    relay.forget();
    assert_eq!((relay.next(&mut before), relay.next(&mut after)), (None, None));
    assert!(relay.waits_for_key(&before) && relay.waits_for_key(&after));
    relay.push(frame(3, true, 10));
    let given = [&mut before, &mut after].map(|cursor| relay.next(cursor).expect("the new one").frame.sequence);
    assert_eq!(given, [3, 3]);
}
