//! Whom a vehicle obeys, from its start until long after its coordinator has gone.

use super::*;
use crate::{Beacon, LeaderMonitorSettings, Standing};
use skein_domain::NodeId;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn term() -> Term {
    let holder = Standing {
        priority: 5,
        node: NodeId(1),
    };
    Term { number: 3, holder }
}

#[test]
fn a_vehicle_knows_whom_it_obeys_at_every_moment() {
    let mut leadership = Leadership::new(NodeId(2), None);
    let mut monitor = LeaderMonitor::new(LeaderMonitorSettings::default(), at(0.0));
    let unled = Unled {
        after_s: 5.0,
        reaction: Reaction::Return,
    };
    assert_eq!(monitor.leader_state(at(1.0), &leadership, &unled), LeaderState::Nobody);
    let beacon = Beacon {
        from: NodeId(1),
        obeys: Some(term()),
        pulse: 7,
        standing: Some(term().holder),
    };
    leadership.hear(&beacon);
    monitor.hear(at(10.0), &leadership, &beacon);
    assert_eq!(
        monitor.leader_state(at(10.4), &leadership, &unled),
        LeaderState::Led { term: term() }
    );
    // The same pulse again is no sign of life.
    monitor.hear(at(12.0), &leadership, &beacon);
    let silent = monitor.leader_state(at(12.0), &leadership, &unled);
    assert!(
        matches!(silent, LeaderState::Awaiting { silent_s, .. } if (silent_s - 2.0).abs() < 1e-6),
        "{silent:?}"
    );
    let gone = monitor.leader_state(at(15.1), &leadership, &unled);
    assert!(
        matches!(gone, LeaderState::Unled { reaction: Reaction::Return, term: of, .. } if of == term()),
        "{gone:?}"
    );
}

#[test]
fn who_starts_again_with_a_stored_term_is_not_led_before_it_hears_something() {
    let leadership = Leadership::new(NodeId(2), Some(term()));
    let monitor = LeaderMonitor::new(LeaderMonitorSettings::default(), at(0.0));
    let unled = Unled::default();
    let early = monitor.leader_state(at(1.0), &leadership, &unled);
    assert!(matches!(early, LeaderState::Awaiting { .. }), "{early:?}");
    let late = monitor.leader_state(at(6.0), &leadership, &unled);
    assert!(matches!(late, LeaderState::Unled { .. }), "{late:?}");
}
