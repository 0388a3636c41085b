//! What waits and what is dropped.

use super::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

#[test]
fn the_most_urgent_comes_first_and_a_full_class_drops_its_own_oldest() {
    let arrivals = Arrivals::default();
    for index in 0..=MOST_WAITING {
        arrivals.put(NodeId(1), Class::Bulk, vec![(index % 256) as u8]);
    }
    arrivals.put(NodeId(1), Class::State, b"state".to_vec());
    arrivals.put(NodeId(1), Class::Command, b"command".to_vec());
    assert_eq!(arrivals.overflowed(), 1);
    let classes: Vec<Class> = std::iter::from_fn(|| arrivals.next())
        .map(|datagram| datagram.class)
        .collect();
    assert_eq!(classes[..3], [Class::Command, Class::State, Class::Bulk]);
    assert_eq!(classes.len(), MOST_WAITING + 2);
}

#[test]
fn whoever_waits_is_woken() {
    let arrivals = Arrivals::default();
    let woken = Arc::new(AtomicU32::new(0));
    let counter = Arc::clone(&woken);
    arrivals.wake_on(Arc::new(move || {
        counter.fetch_add(1, Ordering::Relaxed);
    }));
    arrivals.put(NodeId(1), Class::State, Vec::new());
    assert_eq!(woken.load(Ordering::Relaxed), 1);
}
