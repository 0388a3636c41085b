//! The transport within one process passes the suite.

use super::*;
use crate::conformance::{self, Rig};

#[derive(Default)]
struct OneProcess {
    hub: Hub,
    now: NodeTime,
}

impl Rig for OneProcess {
    type Transport = Local;

    fn join(&mut self, node: NodeId) -> Local {
        self.hub.join(node)
    }

    fn step(&mut self) -> NodeTime {
        self.now = self.now.plus_seconds(0.01);
        self.now
    }
}

#[test]
fn the_suite_is_passed() {
    conformance::all(OneProcess::default);
}

#[test]
fn who_has_left_gets_nothing_and_a_later_run_is_not_sent_away_by_the_end_of_an_earlier_one() {
    let hub = Hub::default();
    let mut a = hub.join(NodeId(1));
    let earlier = hub.join(NodeId(2));
    let mut later = hub.join(NodeId(2));
    drop(earlier);
    a.send(NodeTime(0), To::All, Class::State, b"x").unwrap();
    assert!(later.receive(NodeTime(0)).is_some());
    drop(later);
    assert_eq!(a.send(NodeTime(0), To::One(NodeId(2)), Class::State, b"x"), Ok(()));
}
