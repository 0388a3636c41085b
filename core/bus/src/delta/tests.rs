//! Differences and their bases: any bytes, any losses, doubles, late arrivals and new beginnings.

use super::*;
use crate::envelope::Boot;
use crate::latest::{Heard, News, StateSettings, Telling};
use proptest::prelude::*;
use skein_domain::NodeId;
use std::collections::VecDeque;

const SENDER: NodeId = NodeId(1);

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

/// What a vehicle tells: its number, six slow fields, one that jumps about.
fn state(run: u64, number: u32) -> Vec<u8> {
    let time_s = f64::from(number) * 0.1;
    let fields = (0..6).map(|field| (100.0 + f64::from(field) * 3.0 + time_s.sin() * 0.5) as f32);
    let noise = number.wrapping_mul(2_654_435_761).to_be_bytes();
    let head = run.to_be_bytes().into_iter().chain(number.to_be_bytes());
    head.chain(fields.flat_map(f32::to_be_bytes))
        .chain(noise)
        .chain([0; 12])
        .collect()
}

/// Run and number of such a state.
fn named(value: &[u8]) -> (u64, u32) {
    let run = u64::from_be_bytes(value[..8].try_into().unwrap());
    (run, u32::from_be_bytes(value[8..12].try_into().unwrap()))
}

proptest! {
    #[test]
    fn a_difference_gives_back_the_value(base in prop::collection::vec(any::<u8>(), 0..MOST_BYTES), changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..40), length in 0..MOST_BYTES) {
        let mut value = base.clone();
        value.resize(length, 7);
        for (index, byte) in changes {
            if !value.is_empty() {
                let index = index.index(value.len());
                value[index] = byte;
            }
        }
        let differs = difference(&base, &value);
        prop_assert_eq!(applied(&base, value.len(), &differs), Some(value.clone()));
        prop_assert!(differs.len() <= value.len() + value.len() / 15 + 1, "{} for {}", differs.len(), value.len());
    }

    #[test]
    fn made_up_differences_do_no_harm(base in prop::collection::vec(any::<u8>(), 0..100), length in any::<usize>(), differs in prop::collection::vec(any::<u8>(), 0..200)) {
        let value = applied(&base, length, &differs);
        prop_assert!(value.is_none_or(|value| value.len() == length && length <= MOST_BYTES));
    }

    /// A datagram may be lost, doubled, held back for up to thirty tellings; sender and receiver may begin anew.
    #[test]
    fn nothing_is_handed_out_that_was_not_told_or_that_is_older(fates in prop::collection::vec((0_u8..100, 0_usize..30), 300..600), loss in 0_u8..80, anew in prop::collection::vec((0_usize..600, any::<bool>()), 0..4)) {
        let mut telling = Telling::new(StateSettings::default());
        let mut heard = Heard::default();
        let (mut run, mut number, mut last) = (1_u64, 0_u32, (0_u64, 0_u32));
        let mut flying: VecDeque<(usize, Boot, News)> = VecDeque::new();
        for (step, (fate, late)) in fates.iter().enumerate() {
            let now = at(step as f64 * 0.1);
            for (_, sender) in anew.iter().filter(|(moment, _)| *moment == step) {
                if *sender {
                    run += 1;
                    telling = Telling::new(StateSettings::default());
                    // The seal refuses what is of an earlier run once a later one is known.
                    flying.clear();
                } else {
                    heard = Heard::default();
                    last = (0, 0);
                }
            }
            number += 1;
            telling.set(now, Key(3), state(run, number)).unwrap();
            let news = telling.next(now, 1200, true);
            if *fate >= loss {
                let late = if fate % 3 == 0 { *late } else { 0 };
                flying.push_back((step + late, Boot(run), news.clone()));
                if fate % 7 == 0 {
                    flying.push_back((step + late + 2, Boot(run), news));
                }
            }
            let (arrived, later): (Vec<_>, Vec<_>) = flying.into_iter().partition(|(when, ..)| *when <= step);
            flying = later.into();
            for (_, boot, news) in arrived {
                for value in heard.take(SENDER, boot, news).values.into_values() {
                    let name = named(&value);
                    prop_assert_eq!(&value, &state(name.0, name.1), "it was never told");
                    prop_assert!(name > last && name <= (run, number), "{:?} after {:?}", name, last);
                    last = name;
                }
            }
        }
        // Nothing lost any more: the newest is known at once when it is told whole, as it is when it no longer changes.
        for again in 0..12 {
            let news = telling.next(at(fates.len() as f64 * 0.1 + f64::from(again) * 0.2), 1200, true);
            for value in heard.take(SENDER, Boot(run), news).values.into_values() {
                last = named(&value);
            }
        }
        prop_assert_eq!(last, (run, number));
    }
}

/// Tells a state ten times a second for `steps`; gives the share of those that arrive which are handed out, the longest time without one, and the bytes.
fn shared(steps: u32, arrives: impl Fn(u32) -> bool, back: bool) -> (f64, f64, usize) {
    let mut telling = Telling::new(StateSettings::default());
    let mut heard = Heard::default();
    let (mut came, mut handed, mut bytes, mut last, mut longest) = (0, 0, 0, 0, 0);
    for number in 1..=steps {
        let now = at(f64::from(number) * 0.1);
        telling.set(now, Key(1), state(1, number)).unwrap();
        let news = telling.next(now, 1200, true);
        bytes += minicbor::to_vec(&news).unwrap().len();
        if !arrives(number) {
            continue;
        }
        came += 1;
        let learned = heard.take(SENDER, Boot(1), news);
        if learned.values.is_empty() {
            assert_eq!(learned.lacking, [Key(1)]);
            if back {
                telling.owe(Key(1));
            }
        } else {
            handed += 1;
            longest = longest.max(number - last);
            last = number;
        }
    }
    (f64::from(handed) / f64::from(came), f64::from(longest) * 0.1, bytes)
}

/// Three of ten lost, by a hash of the number.
fn seven_of_ten(number: u32) -> bool {
    let mut mixed = u64::from(number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    (mixed ^ mixed >> 31) % 10 >= 3
}

#[test]
fn three_of_ten_lost_do_not_stop_the_flow() {
    for back in [true, false] {
        let (share, longest_s, bytes) = shared(20_000, seven_of_ten, back);
        println!(
            "{:.2} % of those that arrive are of use, {longest_s:.1} s without one at most, {bytes} bytes",
            share * 100.0
        );
        assert!(share > 0.985, "{share}");
        assert!(longest_s < if back { 1.5 } else { LASTS_S + 1.5 });
    }
    let (share, ..) = shared(20_000, |_| true, false);
    assert!((share - 1.0).abs() < 1e-9, "without losses all are of use");
}

#[test]
fn who_comes_late_knows_the_next_value_and_who_lacks_the_base_soon() {
    let (_, longest_s, _) = shared(400, |number| number > 200, true);
    assert!(longest_s < 20.5, "{longest_s}");
    // Without a way back it is the next base.
    let (_, longest_s, _) = shared(400, |number| number > 207, false);
    assert!(longest_s < 20.8 + LASTS_S, "{longest_s}");
}

#[test]
fn what_has_nothing_in_common_is_told_whole_and_not_tried_for_long() {
    let mut telling = Telling::new(StateSettings::default());
    let mut random = 1_u64;
    let (mut wholes, mut bases) = (0, 0);
    for step in 0..300 {
        let value: Vec<u8> = (0..100)
            .map(|_| {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (random >> 56) as u8
            })
            .collect();
        let now = at(f64::from(step) * 0.1);
        telling.set(now, Key(1), value).unwrap();
        let news = telling.next(now, 1200, true);
        assert!(news.changes.is_empty());
        (wholes, bases) = (wholes + news.wholes.len(), bases + news.bases.len());
    }
    assert!(
        wholes + bases <= 300 + usize::from(TOLD) && bases <= usize::from(TOLD),
        "{wholes}, {bases}"
    );
}

#[test]
fn short_values_and_those_that_rest_are_told_whole() {
    let mut telling = Telling::new(StateSettings::default());
    for step in 0..100_u32 {
        let now = at(f64::from(step) * 0.1);
        telling.set(now, Key(1), vec![step as u8; LEAST_BYTES - 1]).unwrap();
        if step.is_multiple_of(20) {
            telling.set(now, Key(2), state(1, step)).unwrap();
        }
        let news = telling.next(now, 1200, true);
        assert!(news.changes.is_empty() && news.bases.is_empty());
    }
}

#[test]
fn a_receiver_keeps_no_more_than_its_bounds() {
    let mut bases = Bases::default();
    for number in 0..10_000_u64 {
        bases.keep(&Entry {
            key: Key(number as u32 / 5),
            version: number,
            value: vec![0; 100],
        });
    }
    assert!(bases.0.len() <= MOST_KEYS && bases.0.values().all(|of| of.len() <= KEPT));
}
