//! State at its sender and its receiver, step by step.

use super::*;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

/// Whether a whole value of this key and version is new.
fn is_new(heard: &mut Heard, from: NodeId, boot: Boot, key: u32, version: u64) -> bool {
    let whole = Entry {
        key: Key(key),
        version,
        value: Vec::new(),
    };
    let news = News {
        wholes: vec![whole],
        ..News::default()
    };
    !heard.take(from, boot, news).values.is_empty()
}

#[test]
fn only_the_newest_is_told_and_what_does_not_change_again_later() {
    let mut telling = Telling::new(StateSettings::default());
    for value in 0..5_u8 {
        telling.set(at(1.0), Key(1), vec![value]).unwrap();
    }
    let told = telling.next(at(1.0), 1000, true).wholes;
    assert_eq!(told.len(), 1);
    assert_eq!((told[0].version, &told[0].value[..]), (5, &[4_u8][..]));
    for again_s in [1.15, 1.45, 2.05, 3.05, 4.05] {
        assert!(telling.next(at(again_s - 0.01), 1000, true).is_empty());
        assert_eq!(telling.next(at(again_s), 1000, true).wholes[0].version, 5);
    }
    telling.set(at(4.051), Key(1), vec![9]).unwrap();
    let too_soon = telling.next(at(4.051), 1000, true);
    assert!(too_soon.is_empty(), "no sooner than the least time");
    assert_eq!(telling.next(at(4.07), 1000, true).wholes[0].value, [9]);
}

#[test]
fn with_too_little_room_all_have_their_turn() {
    let mut telling = Telling::new(StateSettings::default());
    let mut told = vec![0_u32; 10];
    for step in 0..300 {
        let now = at(f64::from(step) * 0.02);
        for key in 0..10 {
            telling.set(now, Key(key), vec![0; 100]).unwrap();
        }
        for entry in telling.next(now, 250, true).wholes {
            told[entry.key.0 as usize] += 1;
        }
    }
    assert!(told.iter().all(|times| (55..=65).contains(times)), "{told:?}");
}

#[test]
fn nothing_old_is_handed_out_and_a_new_run_begins_anew() {
    let mut heard = Heard::default();
    let (from, boot) = (NodeId(1), Boot(5));
    let mut new = |from, boot, key, version| is_new(&mut heard, from, boot, key, version);
    assert!(new(from, boot, 1, 3));
    assert!(!new(from, boot, 1, 2) && !new(from, boot, 1, 3));
    assert!(new(from, boot, 2, 1) && new(NodeId(2), boot, 1, 1));
    assert!(new(from, Boot(6), 1, 1));
}

#[test]
fn there_is_a_bound_of_values() {
    let mut telling = Telling::new(StateSettings::default());
    let mut heard = Heard::default();
    for key in 0..MOST_KEYS as u32 {
        telling.set(at(0.0), Key(key), Vec::new()).unwrap();
        assert!(is_new(&mut heard, NodeId(1), Boot(1), key, 1));
    }
    assert_eq!(telling.set(at(0.0), Key(9999), Vec::new()), Err(StateError::TooMany));
    assert!(!is_new(&mut heard, NodeId(1), Boot(1), 9999, 1));
    telling.forget(Key(0));
    assert_eq!(telling.set(at(0.0), Key(9999), Vec::new()), Ok(()));
}

#[test]
fn a_value_told_again_after_it_was_given_up_is_new() {
    let mut telling = Telling::new(StateSettings::default());
    let mut heard = Heard::default();
    for now in [at(0.0), at(1.0)] {
        telling.set(now, Key(1), vec![1]).unwrap();
        let told = telling.next(now, 1000, true);
        assert_eq!(heard.take(NodeId(1), Boot(1), told).values.len(), 1);
        telling.forget(Key(1));
    }
}
