//! Properties of the restart policy.

use super::*;
use proptest::prelude::*;

proptest! {
    #[test]
    fn a_delay_is_never_beyond_its_limit(gaps in prop::collection::vec(0.0..20.0f64, 1..60), random in 0.0..1.0f64) {
        let mut history = RestartHistory::default();
        let mut now = NodeTime(0);
        for gap in gaps {
            now = now.plus_seconds(gap);
            if let Decision::RestartAfter(delay) = history.decide(&NODE_LIMITS, now, random) {
                prop_assert!(delay <= NODE_LIMITS.max_delay_s * (1.0 + NODE_LIMITS.jitter));
            } else {
                prop_assert!(false, "parts of the node are tried for ever");
            }
        }
    }

    #[test]
    fn rare_failures_restart_at_once(count in 1usize..50) {
        let mut history = RestartHistory::default();
        for i in 0..count {
            let now = NodeTime::from_seconds(i as f64 * (VEHICLE_LIMITS.window_s + 1.0));
            prop_assert_eq!(history.decide(&VEHICLE_LIMITS, now, 0.5), Decision::RestartAfter(0.0));
        }
    }
}

#[test]
fn a_burst_backs_off_and_then_is_given_up() {
    let mut history = RestartHistory::default();
    let delays: Vec<Decision> = (0..10)
        .map(|i| history.decide(&VEHICLE_LIMITS, NodeTime(i), 0.0))
        .collect();
    assert_eq!(delays[0], Decision::RestartAfter(0.0));
    assert_eq!(delays[1], Decision::RestartAfter(0.05));
    assert_eq!(delays[2], Decision::RestartAfter(0.1));
    assert_eq!(delays[8], Decision::GiveUp);
    history.reset();
    assert_eq!(
        history.decide(&VEHICLE_LIMITS, NodeTime(11), 0.0),
        Decision::RestartAfter(0.0)
    );
}
