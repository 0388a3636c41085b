//! Tests of streams that fail.

use super::*;

#[test]
fn a_file_that_is_none_is_told_and_ends_the_stream() {
    let mut reader = StreamReader::start(Origin::File(PathBuf::from("/nowhere/video.mp4"))).expect("a thread");
    let mut outcome = reader.take(0.0);
    while outcome == Ok(None) {
        std::thread::yield_now();
        outcome = reader.take(0.0);
    }
    assert!(matches!(outcome, Err(StreamFault::File(_))), "{outcome:?}");
    let mut outcome = reader.take(0.0);
    while outcome == Ok(None) {
        std::thread::yield_now();
        outcome = reader.take(0.0);
    }
    assert_eq!(outcome, Err(StreamFault::Ended));
}
