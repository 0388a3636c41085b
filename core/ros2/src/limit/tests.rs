//! Never more than the bucket holds and what has come into it since.

use super::Limit;
use proptest::prelude::*;

#[test]
fn a_burst_and_then_a_rate() {
    let mut limit = Limit::new(3, 2.0);
    let taken = (0..10).filter(|_| limit.permits(1.0)).count();
    assert_eq!(taken, 3);
    assert!(!limit.permits(1.4));
    assert!(limit.permits(1.6));
}

proptest! {
    #[test]
    fn a_flood_is_bounded(steps in proptest::collection::vec(0.0..0.2f64, 1..300)) {
        let mut limit = Limit::new(5, 4.0);
        let (mut now_s, mut taken) = (0.0, 0.0);
        for step in steps {
            now_s += step;
            if limit.permits(now_s) {
                taken += 1.0;
            }
            prop_assert!(taken <= 5.0 + 4.0 * now_s + 1e-6);
        }
    }
}
