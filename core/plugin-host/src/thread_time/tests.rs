//! A thread's times and priority.

use super::*;

#[test]
fn a_thread_is_put_behind_the_others_and_only_that_thread() {
    let niceness = |thread: ThreadTime| rustix::process::getpriority_process(Some(thread.0)).expect("is told");
    let (send, receive) = std::sync::mpsc::channel();
    let (end, ended) = std::sync::mpsc::channel::<()>();
    let other = std::thread::spawn(move || {
        send.send(ThreadTime::of_this_thread()).expect("is awaited");
        ended.recv()
    });
    let (this, hangs) = (ThreadTime::of_this_thread(), receive.recv().expect("is told"));
    let before = niceness(this);
    hangs.yield_to_all();
    assert_eq!((niceness(hangs), niceness(this)), (NICEST, before));
    end.send(()).expect("is awaited");
    other.join().expect("ends").expect("was told to");
}

#[test]
fn the_time_in_the_queue_only_grows() {
    let this = ThreadTime::of_this_thread();
    let Some(before) = this.starved() else { return };
    std::thread::yield_now();
    assert!(this.starved().is_some_and(|now| now >= before));
}
