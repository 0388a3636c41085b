//! A log comes whole and in order over a line that loses, doubles and mixes up.

use super::*;
use proptest::prelude::*;

/// An autopilot as PX4's log handler is: it sends what is asked for, piece by piece, until another request comes.
struct Autopilot {
    log: Vec<u8>,
    next: usize,
    end: usize,
}

impl Autopilot {
    fn asked(&mut self, offset: u32, count: u32) {
        self.next = offset as usize;
        self.end = (offset + count) as usize;
    }

    fn piece(&mut self) -> Option<LOG_DATA_DATA> {
        let end = self.end.min(self.log.len());
        let bytes = self
            .log
            .get(self.next..end.min(self.next + PIECE))
            .filter(|bytes| !bytes.is_empty())?;
        let mut data = [0; PIECE];
        data[..bytes.len()].copy_from_slice(bytes);
        let piece = LOG_DATA_DATA {
            ofs: self.next as u32,
            id: 3,
            count: bytes.len() as u8,
            data,
        };
        self.next += bytes.len();
        Some(piece)
    }
}

fn log(size: usize) -> (AutopilotLog, Vec<u8>) {
    let bytes: Vec<u8> = (0..size).map(|at| (at * 31 % 251) as u8).collect();
    let log = AutopilotLog {
        number: 3,
        size_bytes: size as u32,
        written_unix_s: None,
    };
    (log, bytes)
}

/// What comes of it, and how often it was asked.
fn fetched(size: usize, mut lost: impl FnMut(usize) -> bool) -> Option<(Vec<u8>, usize)> {
    let (log, bytes) = log(size);
    let mut autopilot = Autopilot {
        log: bytes,
        next: 0,
        end: 0,
    };
    let (mut transfer, mut got, mut asked, mut sent) = (Transfer::of(log), Vec::new(), 0, 0);
    for step in 0_u64..500_000 {
        let now = NodeTime(step * 20_000);
        match transfer.poll(now) {
            Asked::Range { offset, count } => {
                asked += 1;
                autopilot.asked(offset, count);
            }
            Asked::GiveUp => return None,
            Asked::Nothing => {}
        }
        for _ in 0..40 {
            if let Some(piece) = autopilot.piece() {
                sent += 1;
                if !lost(sent) {
                    transfer.on_data(now, &piece);
                    transfer.on_data(now, &piece);
                }
            }
        }
        got.append(&mut transfer.take_ready());
        if transfer.is_whole() {
            return Some((got, asked));
        }
    }
    None
}

#[test]
fn a_log_comes_with_one_request_for_each_window() {
    for size in [
        0,
        1,
        89,
        90,
        91,
        PIECE * WINDOW - 1,
        PIECE * WINDOW,
        3 * PIECE * WINDOW + 17,
    ] {
        let (got, asked) = fetched(size, |_| false).expect("comes");
        assert_eq!(got, log(size).1, "{size}");
        assert_eq!(asked, size.div_ceil(PIECE * WINDOW), "{size}");
    }
}

#[test]
fn a_line_that_loses_some_needs_few_requests_more() {
    // Of each hundred pieces two are lost.
    let size = 4 * PIECE * WINDOW;
    let (got, asked) = fetched(size, |sent| sent % 50 == 7).expect("comes");
    assert_eq!(got, log(size).1);
    assert!(asked <= 4 * 6, "{asked}");
}

#[test]
fn who_never_answers_is_given_up() {
    assert_eq!(fetched(500, |_| true), None);
}

#[test]
fn pieces_of_other_logs_and_places_are_none() {
    let (log, _) = log(1_000);
    let mut transfer = Transfer::of(log);
    let piece = |ofs, id, count| LOG_DATA_DATA {
        ofs,
        id,
        count,
        data: [7; PIECE],
    };
    for strange in [
        piece(0, 4, 90),
        piece(45, 3, 90),
        piece(0, 3, 10),
        piece(u32::MAX, 3, 90),
        piece(1_080, 3, 90),
    ] {
        transfer.on_data(NodeTime(1), &strange);
    }
    assert!(transfer.there.iter().all(|there| !there));
}

#[test]
fn a_list_is_whole_when_all_of_it_came_and_an_empty_one_at_once() {
    let entry = |id, num_logs| LOG_ENTRY_DATA {
        time_utc: 1_790_000_000,
        size: 100 + u32::from(id),
        id,
        num_logs,
        last_log_num: num_logs,
    };
    let mut listing = Listing::default();
    assert_eq!(listing.poll(NodeTime(0)), Asked::Range { offset: 0, count: 0 });
    listing.on_entry(&entry(1, 2));
    assert_eq!(listing.whole(), None);
    listing.on_entry(&entry(0, 2));
    let sizes = |logs: Vec<AutopilotLog>| logs.iter().map(|log| log.size_bytes).collect::<Vec<_>>();
    assert_eq!(listing.whole().map(sizes), Some(vec![100, 101]));
    let mut none = Listing::default();
    none.on_entry(&entry(0, 0));
    assert_eq!(none.whole(), Some(Vec::new()));
}

proptest! {
    #[test]
    fn a_log_comes_whole_whatever_is_lost(size in 1usize..300_000, losses in proptest::collection::vec(any::<bool>(), 1..50), keeps in 2usize..9) {
        // Never all: a line on which nothing comes is given up.
        let lost = |sent: usize| losses[sent % losses.len()] && !sent.is_multiple_of(keeps);
        let (got, _) = fetched(size, lost).expect("comes");
        prop_assert_eq!(got, log(size).1);
    }
}
