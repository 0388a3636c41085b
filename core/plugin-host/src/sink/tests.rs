//! How many lines are let through.

use super::*;

#[test]
fn a_flood_is_cut_off_and_counted() {
    let sink = LogSink::new("p".to_owned(), "vehicle-1".to_owned());
    let began = sink.window.lock().began;
    let let_through = (0..1000).filter(|_| sink.count(began).0).count();
    assert_eq!(let_through, MAX_LINES_PER_WINDOW as usize);
    assert_eq!(sink.dropped(), 1000 - u64::from(MAX_LINES_PER_WINDOW));
    // The next window begins by telling how many were lost.
    assert_eq!(sink.count(began + WINDOW), (true, 1000 - MAX_LINES_PER_WINDOW));
    assert_eq!(sink.count(began + WINDOW), (true, 0));
}

#[test]
fn any_bytes_and_levels_are_taken() {
    let sink = LogSink::new("p".to_owned(), "vehicle-1".to_owned());
    for (level, bytes) in [(0, b"\xff\xfe".as_slice()), (3, b""), (99, &[b'x'; 10_000])] {
        sink.take(LogLevel(level), bytes);
    }
    assert_eq!(sink.window.lock().lines, 3);
}
