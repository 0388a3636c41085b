//! Neither too often nor made up for.

use super::*;

#[test]
fn neither_too_often_nor_made_up_for() {
    let begin = Instant::now();
    let after = |ms| begin + Duration::from_millis(ms);
    let mut rate = Rate::new(10.0, begin);
    let due: Vec<u64> = (0..50).map(|i| i * 10).filter(|ms| rate.is_due(after(*ms))).collect();
    assert_eq!(due, [0, 80, 180, 280, 380, 480]);
    // A second late: once, not ten times.
    assert_eq!((0..10).filter(|_| rate.is_due(after(1_505))).count(), 1);
    assert!(!Rate::new(0.0, begin).is_due(after(9_000)));
}
