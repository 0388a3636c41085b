//! The thread beside the calls.

use super::*;
use crate::worker::Worker;
use std::time::Duration;

/// Asks until it is so. A machine that stands still is waited for.
fn until(what: &str, so: impl Fn() -> bool) {
    for _ in 0..6000 {
        if so() {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("{what} does not come about");
}

#[test]
fn every_picture_is_looked_at_or_counted_and_the_newest_is_never_left_out() {
    let worker = Worker::start(eye("slow")).expect("a thread");
    let mut seen = Vec::new();
    for index in 0..20 {
        let (header, bytes) = frame(index, 80);
        worker.bring(&header, &bytes);
    }
    let newest = frame(19, 80).0.time;
    let looks = std::cell::RefCell::new(&mut seen);
    until("the newest picture", || {
        looks.borrow_mut().extend(worker.take());
        looks.borrow().last().is_some_and(|look| look.found.time == newest)
    });
    assert_eq!(seen.len() as u64 + worker.dropped(), 20);
    assert!(worker.dropped() > 0, "one look takes longer than twenty pictures");
    assert!(seen.is_sorted_by_key(|look| look.found.time));
    assert!(seen.iter().all(|look| look.took_s > 0.0));
    assert_eq!(worker.broken(), None);
}
