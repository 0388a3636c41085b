//! All parameters over lines that lose, double and reorder, and from autopilots that say anything.

use super::*;
use proptest::prelude::*;
use std::collections::VecDeque;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

/// What a line does with a frame.
#[derive(Debug, Clone, Copy)]
enum Fate {
    Passes,
    Lost,
    Doubled,
    Late,
}

fn fates() -> impl Strategy<Value = Vec<Fate>> {
    let fate = prop_oneof![
        6 => Just(Fate::Passes),
        2 => Just(Fate::Lost),
        1 => Just(Fate::Doubled),
        1 => Just(Fate::Late),
    ];
    prop::collection::vec(fate, 1..200)
}

/// An autopilot that streams a list at a rate, behind a line.
struct Line {
    count: u16,
    streaming: Option<u16>,
    down: VecDeque<u16>,
    late: Vec<u16>,
    fates: Vec<Fate>,
    frames: usize,
    ticks: usize,
    requests: Vec<(f64, Wanted)>,
}

impl Line {
    fn new(count: u16, fates: Vec<Fate>) -> Self {
        Self {
            count,
            streaming: None,
            down: VecDeque::new(),
            late: Vec::new(),
            fates,
            frames: 0,
            ticks: 0,
            requests: Vec::new(),
        }
    }

    fn fate(&mut self) -> Fate {
        self.frames += 1;
        self.fates[self.frames % self.fates.len()]
    }

    fn send(&mut self, index: u16) {
        match self.fate() {
            Fate::Passes => self.down.push_back(index),
            Fate::Lost => {}
            Fate::Doubled => self.down.extend([index, index]),
            Fate::Late => self.late.push(index),
        }
    }

    /// Lets `listing` run to its end; gives when that was.
    fn run(&mut self, listing: &mut Listing, from_s: f64) -> f64 {
        let mut now_s = from_s;
        while listing.is_running() {
            now_s += 0.01;
            let now = at(now_s);
            if let Some(index) = self.streaming {
                self.send(index);
                self.streaming = Some(index + 1).filter(|next| *next < self.count);
            }
            // What was overtaken comes after something else.
            self.ticks += 1;
            if self.ticks.is_multiple_of(7) {
                self.down.extend(self.late.drain(..));
            }
            while let Some(index) = self.down.pop_front() {
                listing.on_value(now, index, self.count);
            }
            while let Some(wanted) = listing.poll(now) {
                self.requests.push((now_s, wanted));
                match (self.fate(), wanted) {
                    (Fate::Lost, _) => {}
                    (_, Wanted::All) => self.streaming = Some(0),
                    (_, Wanted::Number(index)) => self.send(index),
                }
            }
            assert!(now_s - from_s < READING_MAX_S + 2.0, "it ends");
        }
        now_s - from_s
    }
}

#[test]
fn without_loss_all_come_with_one_request() {
    let mut listing = Listing::default();
    let mut line = Line::new(1_500, vec![Fate::Passes]);
    listing.begin(at(1.0));
    let took_s = line.run(&mut listing, 1.0);
    assert_eq!(listing.state(), ParameterReading::Complete);
    assert_eq!((listing.read(), listing.total()), (1_500, Some(1_500)));
    assert_eq!(line.requests.len(), 1);
    assert!(took_s < 15.5, "{took_s}");
    listing.begin(at(90.0));
    assert_eq!(listing.poll(at(90.0)), None, "what is complete is not read again");
}

#[test]
fn silence_ends_it_after_a_few_requests_and_it_can_be_begun_again_and_stopped() {
    let mut listing = Listing::default();
    let mut line = Line::new(10, vec![Fate::Lost]);
    listing.begin(at(1.0));
    let took_s = line.run(&mut listing, 1.0);
    assert_eq!(line.requests.len(), usize::from(LIST_ATTEMPTS));
    assert!(took_s < 8.0);
    assert!(matches!(listing.state(), ParameterReading::Ended { .. }));
    listing.begin(at(20.0));
    assert_eq!(listing.poll(at(20.0)), Some(Wanted::All));
    listing.on_value(at(20.1), 3, 10);
    listing.stop("it was stopped");
    assert_eq!(listing.poll(at(30.0)), None);
    assert_eq!((listing.due(), listing.read()), (None, 1));
}

#[test]
fn what_was_read_before_a_break_is_not_asked_for_again() {
    let mut listing = Listing::default();
    listing.begin(at(1.0));
    listing.poll(at(1.0)).unwrap();
    for index in 0..90 {
        listing.on_value(at(1.1), index, 100);
    }
    listing.stop("the link was lost");
    let mut line = Line::new(100, vec![Fate::Passes]);
    listing.begin(at(50.0));
    line.run(&mut listing, 50.0);
    assert_eq!(listing.state(), ParameterReading::Complete);
    let numbers: Vec<_> = line.requests.iter().map(|(_, wanted)| *wanted).collect();
    assert_eq!(numbers, (90..100).map(Wanted::Number).collect::<Vec<_>>());
}

#[test]
fn a_count_beyond_all_reason_ends_it_at_once_and_takes_no_room() {
    let mut listing = Listing::default();
    listing.begin(at(1.0));
    listing.poll(at(1.0)).unwrap();
    for index in 0..3 {
        assert!(listing.is_running());
        listing.on_value(at(1.1), index, u16::MAX - 1);
    }
    assert!(matches!(listing.state(), ParameterReading::Ended { why } if why.contains("65534")));
    assert!(listing.slots.is_empty());
}

#[test]
fn one_odd_count_changes_nothing_and_a_lasting_one_begins_anew_a_few_times() {
    let mut listing = Listing::default();
    listing.begin(at(1.0));
    listing.poll(at(1.0)).unwrap();
    listing.on_value(at(1.1), 0, 3);
    for _ in 0..50 {
        listing.on_value(at(1.2), 1, 4);
        listing.on_value(at(1.2), 1, 3);
    }
    assert_eq!((listing.read(), listing.total()), (2, Some(3)));
    let mut counts = 4..;
    while listing.is_running() {
        let count = counts.next().unwrap();
        for _ in 0..OTHER_COUNT {
            listing.on_value(at(1.3), 0, count);
        }
    }
    assert_eq!(counts.start, 4 + u16::from(RESTARTS_MAX) + 1);
    assert!(matches!(listing.state(), ParameterReading::Ended { why } if why.contains("keeps changing")));
}

#[test]
fn a_list_that_grew_meanwhile_is_read_from_its_beginning() {
    let mut listing = Listing::default();
    listing.begin(at(1.0));
    listing.poll(at(1.0)).unwrap();
    for index in 0..5 {
        listing.on_value(at(1.1), index, 10);
    }
    for index in 5..5 + u16::from(OTHER_COUNT) {
        listing.on_value(at(1.2), index, 11);
    }
    assert_eq!((listing.read(), listing.total()), (0, Some(11)));
    assert_eq!(listing.poll(at(1.2)), Some(Wanted::All));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Over a line that loses a fifth both ways, doubles and reorders, all come; gaps are asked for no faster than a radio bears.
    #[test]
    fn all_come_over_a_bad_line(count in 1_u16..400, fates in fates()) {
        let lost = fates.iter().filter(|fate| matches!(fate, Fate::Lost)).count();
        let mut listing = Listing::default();
        let mut line = Line::new(count, fates.clone());
        listing.begin(at(1.0));
        line.run(&mut listing, 1.0);
        prop_assert!(listing.read() <= usize::from(count));
        for pair in line.requests.windows(2) {
            prop_assert!(pair[1].0 - pair[0].0 > GAP_S - 0.001, "{pair:?}");
        }
        let asked = |index: u16| line.requests.iter().filter(|(_, wanted)| *wanted == Wanted::Number(index)).count();
        for index in 0..count {
            prop_assert!(asked(index) <= usize::from(GAP_ATTEMPTS));
        }
        if lost == 0 {
            prop_assert_eq!(listing.state(), ParameterReading::Complete);
        }
        if listing.state() != ParameterReading::Complete {
            // It ended by itself: begun again, it asks for what is missing, until a line that loses nothing gives it.
            line.fates = vec![Fate::Passes];
            listing.begin(at(1_000.0));
            line.run(&mut listing, 1_000.0);
            prop_assert_eq!(listing.state(), ParameterReading::Complete);
            prop_assert_eq!(listing.read(), usize::from(count));
        }
    }

    /// Whatever is said, it takes no more room than the bound, ends in time, and counts nothing twice.
    #[test]
    fn nonsense_ends(frames in prop::collection::vec((any::<u16>(), prop_oneof![any::<u16>(), 1_u16..9], 0.0..2.0_f64), 0..400)) {
        let mut listing = Listing::default();
        listing.begin(at(1.0));
        let (mut now_s, mut polls) = (1.0, 0);
        for (index, count, wait_s) in frames {
            now_s += wait_s;
            listing.on_value(at(now_s), index, count);
            while listing.poll(at(now_s)).is_some() {
                polls += 1;
            }
            prop_assert!(listing.slots.len() <= usize::from(COUNT_MAX));
            prop_assert_eq!(listing.read(), listing.slots.iter().filter(|slot| slot.read).count());
        }
        while let Some(due) = listing.due() {
            now_s = now_s.max(due.as_seconds());
            polls += usize::from(listing.poll(at(now_s)).is_some());
            prop_assert!(now_s < 1.0 + READING_MAX_S + 900.0);
        }
        let runs = usize::from(RESTARTS_MAX) + 1;
        prop_assert!(polls <= runs * (usize::from(COUNT_MAX) * usize::from(GAP_ATTEMPTS) + usize::from(LIST_ATTEMPTS)));
    }
}
