//! Tests of reading on a thread: in order, with its error last, and gone when nobody wants it.

use super::*;

fn next<T: Send + 'static, E: Send + From<Ended> + 'static>(feed: &mut Feed<T, E>) -> Result<T, E> {
    loop {
        match feed.take() {
            Ok(Some(item)) => return Ok(item),
            Ok(None) => std::thread::yield_now(),
            Err(error) => return Err(error),
        }
    }
}

/// What a test's thread may say.
#[derive(Debug, PartialEq)]
enum Fault {
    Broken,
    Ended,
}

impl From<Ended> for Fault {
    fn from(_: Ended) -> Self {
        Self::Ended
    }
}

#[test]
fn what_was_read_comes_in_order_then_the_error_then_the_end() {
    let mut feed = Feed::start("test", 1, |outlet| {
        (0..5).for_each(|number| assert!(outlet.give(Ok(number))));
        Err(Fault::Broken)
    })
    .unwrap();
    for number in 0..5 {
        assert_eq!(next(&mut feed), Ok(number));
    }
    assert_eq!(next(&mut feed), Err(Fault::Broken));
    assert_eq!(next(&mut feed), Err(Fault::Ended));
    assert_eq!(next(&mut feed), Err(Fault::Ended));
}

#[test]
fn a_thread_that_waits_for_room_ends_with_it() {
    for taken in 0..4 {
        let mut feed: Feed<u32, Ended> = Feed::start("test", 2, |outlet| {
            while outlet.give(Ok(7)) {}
            Ok(())
        })
        .unwrap();
        for _ in 0..taken {
            next(&mut feed).unwrap();
        }
        let stop = feed.stop.clone();
        drop(feed);
        // The thread holds the other one until it ends.
        while Arc::strong_count(&stop) > 1 {
            std::thread::yield_now();
        }
    }
}
