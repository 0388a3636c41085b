//! Thousands of drawn flights, each judged by the truth. A seed that fails is flown again with `skein replay-seed N`.
//!
//! `SKEIN_SEEDS=from..to` flies others than the ones of every run.

use skein_seeded::fly_seed;
use std::ops::Range;

/// The seeds of every run: half a minute on one core.
const SEEDS: Range<u64> = 1_000..1_040;

fn seeds() -> Range<u64> {
    let Ok(asked) = std::env::var("SKEIN_SEEDS") else {
        return SEEDS;
    };
    let (from, to) = asked.split_once("..").expect("SKEIN_SEEDS is from..to");
    from.parse().expect("a number")..to.parse().expect("a number")
}

#[test]
fn every_drawn_flight_keeps_its_distances_and_fences_and_arrives() {
    let seeds = seeds();
    let mut failed = Vec::new();
    for seed in seeds.clone() {
        let outcome = fly_seed(seed, false);
        if !outcome.is_passed() {
            for failure in &outcome.failures {
                println!("seed {seed}: {failure}");
            }
            println!("skein replay-seed {seed}");
            failed.push(seed);
        }
    }
    assert!(
        failed.is_empty(),
        "{} of {} seeds failed: {failed:?}",
        failed.len(),
        seeds.end - seeds.start
    );
}

#[test]
fn a_seed_gives_the_same_flight_again() {
    let (once, again) = (fly_seed(7, false), fly_seed(7, false));
    assert_eq!(once, again);
    assert!(!once.story.is_empty() && once.filter.calls > 0);
}
