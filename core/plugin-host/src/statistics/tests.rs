//! The histogram's quantiles against the exact ones.

use super::*;

#[test]
fn quantiles_are_right_to_a_fifth() {
    let times = CallTimes::default();
    for microseconds in 1..=1000 {
        times.record(Duration::from_micros(microseconds), microseconds == 7);
    }
    let read = times.read(3);
    assert_eq!((read.calls, read.failures, read.dropped_log_lines), (1000, 1, 3));
    assert!((500.0..600.0).contains(&read.p50_us), "{read:?}");
    assert!((990.0..=1000.0).contains(&read.p99_us), "{read:?}");
    assert_eq!(read.max_us, 1000.0);
}

#[test]
fn extremes_have_a_place() {
    let times = CallTimes::default();
    assert_eq!(times.read(0), CallStatistics::default());
    times.record(Duration::ZERO, false);
    times.record(Duration::from_secs(3600), false);
    let read = times.read(0);
    assert_eq!(read.calls, 2);
    assert_eq!(read.p99_us, 3.6e9);
}
