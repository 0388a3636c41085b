//! Whom a vehicle obeys, from its start until long after its coordinator has gone.

use super::*;
use crate::{Beacon, Standing, WatchSettings};
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
    let mut office = Office::new(NodeId(2), None);
    let mut watch = Watch::new(WatchSettings::default(), at(0.0));
    let unled = Unled {
        after_s: 5.0,
        reaction: Reaction::Return,
    };
    assert_eq!(watch.allegiance(at(1.0), &office, &unled), Allegiance::Nobody);
    let beacon = Beacon {
        from: NodeId(1),
        obeys: Some(term()),
        pulse: 7,
        standing: Some(term().holder),
    };
    office.hear(&beacon);
    watch.hear(at(10.0), &office, &beacon);
    assert_eq!(
        watch.allegiance(at(10.4), &office, &unled),
        Allegiance::Led { term: term() }
    );
    // The same pulse again is no sign of life.
    watch.hear(at(12.0), &office, &beacon);
    let silent = watch.allegiance(at(12.0), &office, &unled);
    assert!(
        matches!(silent, Allegiance::Awaiting { silent_s, .. } if (silent_s - 2.0).abs() < 1e-6),
        "{silent:?}"
    );
    let gone = watch.allegiance(at(15.1), &office, &unled);
    assert!(
        matches!(gone, Allegiance::Unled { reaction: Reaction::Return, term: of, .. } if of == term()),
        "{gone:?}"
    );
}

#[test]
fn who_starts_again_with_a_stored_term_is_not_led_before_it_hears_something() {
    let office = Office::new(NodeId(2), Some(term()));
    let watch = Watch::new(WatchSettings::default(), at(0.0));
    let unled = Unled::default();
    let early = watch.allegiance(at(1.0), &office, &unled);
    assert!(matches!(early, Allegiance::Awaiting { .. }), "{early:?}");
    let late = watch.allegiance(at(6.0), &office, &unled);
    assert!(matches!(late, Allegiance::Unled { .. }), "{late:?}");
}
