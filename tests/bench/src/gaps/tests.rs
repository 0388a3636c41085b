//! Percentiles, windows, and streams that stop.

use super::*;

const MS: i64 = 1_000_000;

#[test]
fn percentiles_are_nearest_ranks() {
    let all: Vec<u32> = (1..=1000).map(|i| i * 1000).collect();
    let figures: Vec<f64> = [0.5, 0.99, 0.999, 1.0]
        .iter()
        .map(|share| percentile_ms(&all, *share))
        .collect();
    assert_eq!(figures, [500.0, 990.0, 999.0, 1000.0]);
    assert_eq!(percentile_ms(&[], 0.5), 0.0);
    assert_eq!(percentile_ms(&[7000], 0.01), 7.0);
}

#[test]
fn gaps_are_per_vehicle_and_the_first_of_a_window_counts() {
    let mut log = GapLog::new(2);
    log.received(0, 0);
    log.received(1, 5 * MS);
    log.received(0, 100 * MS);
    log.begin();
    assert_eq!((log.count(), log.streaming()), (0, 0));
    for i in 0..10 {
        log.received(0, (120 + i * 20) * MS);
    }
    assert_eq!((log.count(), log.streaming()), (10, 1));
    log.received(1, 305 * MS);
    let figures = log.figures(306 * MS);
    assert_eq!((figures.p50_ms, figures.max_ms, figures.over_60_ms), (20.0, 300.0, 1));
    assert_eq!(figures.worst_vehicle_p99_ms, 300.0);
}

#[test]
fn a_stream_that_stopped_is_a_gap() {
    let mut log = GapLog::new(1);
    for i in 0..5 {
        log.received(0, i * 20 * MS);
    }
    assert_eq!(log.figures(90 * MS).max_ms, 20.0);
    assert_eq!(log.figures(1080 * MS).max_ms, 1000.0);
    log.received(7, 0);
}
