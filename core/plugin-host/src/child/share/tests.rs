//! Shares over simulated time.

use super::*;

/// Looks once a second; `share` of a core is taken in each. Gives the second in which it was over the limit.
fn first_over(limit: f64, share: impl Fn(u64) -> f64) -> Option<(u64, f64)> {
    let (began, mut used_s) = (Instant::now(), 0.0);
    let mut watch = ShareWatch::new(limit);
    for second in 0..100 {
        let now = began + Duration::from_secs(second);
        assert!(watch.is_due(now));
        if let Some(over) = watch.look(now, used_s) {
            return Some((second, over));
        }
        assert!(!watch.is_due(now + LOOK_EVERY / 2));
        used_s += share(second);
    }
    None
}

#[test]
fn a_share_is_judged_over_ten_seconds() {
    assert_eq!(first_over(0.5, |_| 0.49), None);
    let (second, share) = first_over(0.5, |_| 1.0).expect("is over");
    assert_eq!(second, 10);
    assert!((share - 1.0).abs() < 1e-9);
    // Four seconds of a whole core in each ten are under a half.
    assert_eq!(first_over(0.5, |second| f64::from(u8::from(second % 10 < 4))), None);
    // Later it goes wild.
    let (second, share) = first_over(0.5, |second| f64::from(u8::from(second >= 50))).expect("is over");
    assert_eq!(second, 56);
    assert!((share - 0.6).abs() < 1e-9);
    // Several threads.
    assert_eq!(first_over(1.5, |_| 2.0), Some((10, 2.0)));
}
