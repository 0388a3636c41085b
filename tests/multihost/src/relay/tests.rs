//! What shares and seeds mean for the fate of frames.

use super::fate::{Quality, Way};

fn arrivals(way: &mut Way, frames: usize) -> Vec<Vec<f64>> {
    (0..frames).map(|_| way.arrivals_s().collect()).collect()
}

#[test]
fn a_good_way_takes_no_time_and_loses_nothing() {
    let mut way = Way::new(1, 1, 2);
    assert!(arrivals(&mut way, 100).iter().all(|copies| copies == &[0.0]));
    way.cut = true;
    assert!(arrivals(&mut way, 100).iter().all(Vec::is_empty));
}

#[test]
fn shares_are_as_asked_for_and_one_seed_is_one_fate() {
    let bad = Quality {
        loss: 0.3,
        delay_s: 0.2,
        jitter_s: 0.05,
        doubled: 0.1,
        overtaken: 0.1,
    };
    let of = |seed| {
        let mut way = Way::new(seed, 1, 2);
        way.quality = bad;
        arrivals(&mut way, 10_000)
    };
    let fates = of(7);
    let count = |wanted: usize| fates.iter().filter(|copies| copies.len() == wanted).count();
    assert!((2800..3200).contains(&count(0)), "{} lost", count(0));
    assert!((600..800).contains(&count(2)), "{} doubled", count(2));
    assert!(fates.iter().flatten().all(|s| (0.2..0.351).contains(s)));
    assert_eq!(fates, of(7));
    assert_ne!(fates, of(8));
}
