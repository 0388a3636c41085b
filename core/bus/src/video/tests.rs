//! Tests of video between nodes: over links that lose, delay and turn around, in time that is an argument.

use super::*;
use crate::envelope::Boot;
use proptest::prelude::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const A: NodeId = NodeId(1);
const B: NodeId = NodeId(2);
const BOOT: Boot = Boot(7);
const RATE: f64 = 1_000_000.0;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(10.0 + seconds)
}

fn push(sending: &mut VideoSending, now: NodeTime, key: bool, body: &[u8]) -> Pushed {
    sending.push(now, (B, 1), (key, body), 1000, RATE)
}

#[test]
fn a_picture_comes_whole_and_in_order() {
    let (mut sending, mut receiving) = (VideoSending::default(), VideoReceiving::default());
    receiving.expect(A, 1);
    let mut got = Vec::new();
    for count in 0..10_u8 {
        let body = vec![count; 2500];
        assert_eq!(push(&mut sending, at(0.0), count == 0, &body), Pushed::Taken);
        while let Some((to, part)) = sending.next_part() {
            assert_eq!(to, B);
            got.extend(receiving.take(at(0.0), A, BOOT, part));
        }
    }
    assert_eq!(got.len(), 10);
    for (count, picture) in got.iter().enumerate() {
        assert_eq!(
            (picture.body.as_slice(), picture.key),
            (&[count as u8; 2500][..], count == 0)
        );
        assert!(!picture.after_gap);
    }
}

#[test]
fn what_nobody_asked_for_is_not_taken_in() {
    let (mut sending, mut receiving) = (VideoSending::default(), VideoReceiving::default());
    push(&mut sending, at(0.0), true, &[1; 10]);
    let (_, part) = sending.next_part().expect("a part");
    assert_eq!(receiving.take(at(0.0), A, BOOT, part), []);
}

#[test]
fn a_link_that_carries_less_leaves_out_whole_groups() {
    let mut sending = VideoSending::default();
    // nothing leaves: 0.3 s of a megabyte a second may wait
    let mut taken = Vec::new();
    for count in 0..85 {
        let pushed = push(&mut sending, at(0.0), count % 30 == 0, &[0; 10_000]);
        taken.push(pushed == Pushed::Taken);
    }
    assert!(taken[..30].iter().all(|taken| *taken));
    let first_left_out = taken.iter().position(|taken| !taken).expect("some are left out");
    let next_taken = first_left_out
        + taken[first_left_out..]
            .iter()
            .position(|taken| *taken)
            .expect("then a key picture");
    assert_eq!(next_taken % 30, 0);
    let waiting: Vec<VideoPart> = std::iter::from_fn(|| sending.next_part())
        .map(|(_, part)| part)
        .collect();
    assert!(waiting[0].key && waiting.len() <= 320, "{}", waiting.len());
}

#[test]
fn a_stream_that_has_ended_makes_room_for_another() {
    let mut sending = VideoSending::default();
    let mut open = |number: u32| sending.push(at(0.0), (B, number), (true, &[1; 10]), 1000, RATE);
    let most = MOST_STREAMS as u32;
    assert!((0..most).all(|number| open(number) == Pushed::Taken));
    assert_eq!(open(most), Pushed::LeftOut);
    sending.end(B, 7);
    assert_eq!(
        sending.push(at(0.0), (B, most), (true, &[1; 10]), 1000, RATE),
        Pushed::Taken
    );
}

#[test]
fn a_sender_that_starts_again_begins_anew() {
    let mut receiving = VideoReceiving::default();
    receiving.expect(A, 1);
    let of = |sending: &mut VideoSending, key| {
        push(sending, at(0.0), key, &[5; 10]);
        sending.next_part().expect("a part").1
    };
    let mut first = VideoSending::default();
    for key in [true, false, false] {
        assert_eq!(receiving.take(at(0.0), A, BOOT, of(&mut first, key)).len(), 1);
    }
    let mut second = VideoSending::default();
    assert_eq!(receiving.take(at(1.0), A, Boot(8), of(&mut second, true)).len(), 1);
}

/// A link with loss, delay and turned order, and back; gives when each picture was handed out, in seconds.
fn over_a_poor_link(seed: u64, loss: f64, delay_s: f64, pictures: u64) -> Vec<(f64, VideoPicture)> {
    let mut chance = ChaCha8Rng::seed_from_u64(seed);
    let (mut sending, mut receiving) = (VideoSending::default(), VideoReceiving::default());
    receiving.expect(A, 1);
    let mut there: Vec<(f64, VideoPart)> = Vec::new();
    let mut back: Vec<(f64, VideoLost)> = Vec::new();
    let (mut got, mut next, mut wants_key) = (Vec::new(), 0, false);
    let arrives = |chance: &mut ChaCha8Rng, now_s: f64| {
        let jitter_s = 0.004 * f64::from(chance.next_u32() % 1000) / 1000.0;
        (!chance.random_bool(loss)).then_some(now_s + delay_s + jitter_s)
    };
    for step in 0..(pictures * 33 + 1000) {
        let now_s = step as f64 * 1e-3;
        let now = at(now_s);
        if step % 33 == 0 && next < pictures {
            let key = next % 60 == 0 || std::mem::take(&mut wants_key);
            let mut body = vec![0; if key { 25_000 } else { 3_000 }];
            body[..8].copy_from_slice(&next.to_be_bytes());
            push(&mut sending, now, key, &body);
            next += 1;
        }
        while let Some((_, part)) = sending.next_part() {
            there.extend(arrives(&mut chance, now_s).map(|at_s| (at_s, part)));
        }
        let (come, later): (Vec<_>, Vec<_>) = there.into_iter().partition(|(at_s, _)| *at_s <= now_s);
        there = later;
        for (_, part) in come {
            got.extend(
                receiving
                    .take(now, A, BOOT, part)
                    .into_iter()
                    .map(|picture| (now_s, picture)),
            );
        }
        got.extend(receiving.expire(now).into_iter().map(|(_, picture)| (now_s, picture)));
        while let Some((_, lost)) = receiving.next_lost(now) {
            back.extend(arrives(&mut chance, now_s).map(|at_s| (at_s, lost)));
        }
        let (come, later): (Vec<_>, Vec<_>) = back.into_iter().partition(|(at_s, _)| *at_s <= now_s);
        back = later;
        for (_, lost) in come {
            wants_key |= sending.lost(now, B, &lost);
        }
    }
    got
}

fn number(picture: &VideoPicture) -> u64 {
    u64::from_be_bytes(picture.body[..8].try_into().expect("eight bytes"))
}

#[test]
fn at_two_per_cent_of_loss_nothing_stands_for_half_a_second() {
    for seed in 0..4 {
        let got = over_a_poor_link(seed, 0.02, 0.05, 1_800);
        let longest_s = got.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(0.0, f64::max);
        assert!(longest_s < 0.5, "seed {seed}: {longest_s} s");
        assert!(got.len() > 1_790, "seed {seed}: {} of 1800", got.len());
        let oldest_s = got
            .iter()
            .map(|(at_s, picture)| at_s - number(picture) as f64 * 0.033)
            .fold(0.0, f64::max);
        assert!(oldest_s < 0.6, "seed {seed}: {oldest_s} s old");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// However poor the link: what is handed out is whole, in order, and can be decoded.
    #[test]
    fn what_is_handed_out_can_be_decoded(seed in any::<u64>(), loss in 0.0..0.4, delay_ms in 0_u32..200) {
        can_be_decoded(&over_a_poor_link(seed, loss, f64::from(delay_ms) * 1e-3, 200));
    }
}

fn can_be_decoded(got: &[(f64, VideoPicture)]) {
    let mut last: Option<u64> = None;
    for (_, picture) in got {
        let this = number(picture);
        match last {
            None => assert!(picture.key),
            Some(last) if picture.after_gap => assert!(picture.key && this > last),
            Some(last) => assert_eq!(this, last + 1),
        }
        last = Some(this);
    }
}

/// So much was missing that what waited for it was dropped.
#[test]
fn a_stream_that_was_broken_off_says_so() {
    let got = over_a_poor_link(1_063_015_697_233_693_584, 0.392_674_913_288_533_8, 0.027, 200);
    assert!(got.iter().any(|(_, picture)| picture.after_gap));
    can_be_decoded(&got);
}
