//! A thread's times and priority.

use super::*;

#[test]
fn the_time_in_the_queue_only_grows() {
    let this = ThreadTime::of_this_thread();
    let Some(before) = this.starved() else { return };
    std::thread::yield_now();
    assert!(this.starved().is_some_and(|now| now >= before));
}
