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
    fn who_ran_well_before_is_started_at_once(gaps in prop::collection::vec(3.5..20.0f64, 1..50)) {
        let mut history = RestartHistory::default();
        let mut now = NodeTime(0);
        for gap in gaps {
            now = now.plus_seconds(gap);
            prop_assert_eq!(history.decide(&VEHICLE_LIMITS, now, 0.5), Decision::RestartAfter(0.0));
        }
    }

    #[test]
    fn more_than_the_window_allows_are_given_up(gap in 1.0..2.5f64) {
        let mut history = RestartHistory::default();
        let mut decisions = (0..40).map(|i| history.decide(&PAYLOAD_LIMITS, NodeTime::from_seconds(f64::from(i) * gap), 0.0));
        prop_assert!(decisions.any(|decision| decision == Decision::GiveUp));
    }
}

#[test]
fn a_burst_backs_off_and_then_is_given_up() {
    let mut history = RestartHistory::default();
    let delays: Vec<Decision> = (0..8)
        .map(|i| history.decide(&VEHICLE_LIMITS, NodeTime(i), 0.0))
        .collect();
    assert_eq!(delays[0], Decision::RestartAfter(0.0));
    assert_eq!(delays[1], Decision::RestartAfter(0.05));
    assert_eq!(delays[2], Decision::RestartAfter(0.1));
    assert_eq!(delays[7], Decision::GiveUp);
    history.reset();
    assert_eq!(
        history.decide(&VEHICLE_LIMITS, NodeTime(11), 0.0),
        Decision::RestartAfter(0.0)
    );
}

#[test]
fn a_crashing_model_is_given_up_before_its_link_stops_holding() {
    let (mut history, mut now) = (RestartHistory::default(), NodeTime(0));
    while let Decision::RestartAfter(delay_s) = history.decide(&VEHICLE_LIMITS, now, 1.0) {
        now = now.plus_seconds(delay_s + 0.05);
    }
    assert!(now.as_seconds() < 5.0, "{now:?}");
}
