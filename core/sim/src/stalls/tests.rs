//! What counts as a stall of the machine, and what does not.

use super::*;
use proptest::prelude::*;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// A probe that woke at these times, in milliseconds.
fn woken(zero: Instant, at_ms: &[u64]) -> Stalls {
    let mut stalls = Stalls::from(zero);
    at_ms.iter().for_each(|at| stalls.woke(zero + ms(*at)));
    stalls
}

/// What is left of a gap that began and ended at these times, in milliseconds.
fn judged(stalls: &Stalls, zero: Instant, begin_ms: u64, end_ms: u64) -> Duration {
    let end = zero + ms(end_ms);
    let stalled = stalls.until(end, end) - stalls.until(zero + ms(begin_ms), end);
    ms(end_ms - begin_ms) - stalled
}

#[test]
fn a_gap_of_a_sender_that_sleeps_is_counted_whole() {
    let zero = Instant::now();
    let in_time: Vec<u64> = (1..=100).map(|step| step * 5).collect();
    assert_eq!(judged(&woken(zero, &in_time), zero, 90, 410), ms(320));
    // as late as a timer is, and a thread among others
    let nearly: Vec<u64> = (1..=40).map(|step| step * 15).collect();
    assert_eq!(judged(&woken(zero, &nearly), zero, 90, 410), ms(320));
}

#[test]
fn a_gap_in_which_the_probe_was_late_too_is_not_counted() {
    let zero = Instant::now();
    let stalls = woken(zero, &[5, 10, 95, 400, 405, 410]);
    // due at 15 and at 100
    assert_eq!(stalls.until(zero + ms(410), zero + ms(410)), ms(80 + 300));
    assert_eq!(judged(&stalls, zero, 97, 410), ms(13));
    assert_eq!(judged(&stalls, zero, 50, 200), ms(5), "only what lies within");
    assert_eq!(stalls.longest, ms(300));
}

#[test]
fn a_stall_that_lasts_is_known_to_who_wakes_first() {
    let zero = Instant::now();
    let mut stalls = woken(zero, &[5, 15, 25, 35, 45, 55, 65, 75, 85, 95]);
    let at = |stalls: &Stalls, at_ms: u64, now_ms: u64| stalls.until(zero + ms(at_ms), zero + ms(now_ms));
    assert_eq!(at(&stalls, 110, 110), Duration::ZERO, "it is not late yet");
    assert_eq!(at(&stalls, 300, 300), ms(200));
    assert_eq!(at(&stalls, 90, 300), Duration::ZERO, "a moment before it is as it was");
    // another thread tells of a part of it, within and beyond what is known
    stalls.add(zero + ms(150), zero + ms(300));
    assert_eq!(at(&stalls, 300, 300), ms(200));
    stalls.woke(zero + ms(310));
    assert_eq!(at(&stalls, 300, 310), ms(200));
    assert_eq!(stalls.spans.len(), 1, "{stalls:?}");
}

proptest! {
    /// Whatever threads tell, in whatever order: no time counts twice, none counts that nobody told of, and all counts that was told.
    #[test]
    fn stalls_are_the_union_of_what_is_told(told in prop::collection::vec((0_u64..500, 1_u64..60), 0..40), from in 0_u64..500, length in 0_u64..100) {
        let zero = Instant::now();
        let mut stalls = Stalls::from(zero);
        let mut stood = [false; 700];
        for (begin, lasts) in told {
            stalls.add(zero + ms(begin), zero + ms(begin + lasts));
            stood[begin as usize..(begin + lasts) as usize].fill(true);
        }
        let all = stood[from as usize..(from + length) as usize].iter().filter(|stands| **stands).count();
        let until = |at| stalls.until(zero + ms(at), zero);
        prop_assert_eq!(until(from + length) - until(from), ms(all as u64));
    }

    /// What is kept no more counts as part of the sum.
    #[test]
    fn sums_grow_and_never_faster_than_time(wakes in prop::collection::vec(5_u64..60, 1..300)) {
        let (zero, mut now_ms, mut before, mut late) = (Instant::now(), 0, Duration::ZERO, 0);
        let mut stalls = Stalls::from(zero);
        for lasts in wakes {
            now_ms += lasts;
            stalls.woke(zero + ms(now_ms));
            late += if lasts > 15 { lasts - 5 } else { 0 };
            let sum = stalls.until(zero + ms(now_ms), zero + ms(now_ms));
            prop_assert_eq!(sum, ms(late));
            prop_assert!(sum - before <= ms(lasts));
            before = sum;
        }
        prop_assert!(stalls.spans.len() <= KEPT);
    }
}

/// The machine may stand still while this is tried, and then is rightly excused: one try of many in which it does not is enough.
#[test]
fn a_thread_that_sleeps_or_waits_is_excused_nothing() {
    let probe = StallProbe::start().expect("starts");
    let lock = Mutex::new(());
    let tries = std::iter::repeat_with(|| {
        let begin = Instant::now();
        std::thread::scope(|scope| {
            let held = lock.lock();
            scope.spawn(|| drop(lock.lock()));
            std::thread::sleep(ms(100));
            drop(held);
        });
        let end = Instant::now();
        (end - begin, probe.until(end) - probe.until(begin))
    });
    let whole = |(gap, stalled): &(Duration, Duration)| *gap >= ms(100) && *stalled < ms(20);
    let found = tries.take(100).find(whole);
    assert!(found.is_some(), "it was excused each time");
}

const STOPPED: &str = "SKEIN_SIM_TEST_STOPPED";

/// In a process of its own, which is stopped from without, as a machine is that its host does not let run.
#[test]
fn a_process_that_is_not_let_run_knows_it() {
    if std::env::var_os(STOPPED).is_some() {
        let probe = StallProbe::start().expect("starts");
        let begin = Instant::now();
        println!("\nbegun");
        // until it was stopped; whoever started this ends it if it never is
        while probe.longest() < ms(300) {
            std::thread::sleep(ms(1));
        }
        let end = Instant::now();
        assert!(probe.until(end) - probe.until(begin) >= ms(300));
        return;
    }
    let name = "stalls::tests::a_process_that_is_not_let_run_knows_it";
    let mut child = Command::new(std::env::current_exe().expect("this program"))
        .args(["--exact", name, "--nocapture"])
        .env(STOPPED, "1")
        .stdout(Stdio::piped())
        .spawn()
        .expect("starts");
    let mut lines = BufReader::new(child.stdout.take().expect("piped")).lines();
    assert!(lines.any(|line| line.expect("text") == "begun"));
    let send = |signal: &str| {
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(sent.expect("kill runs").success());
    };
    send("-STOP");
    std::thread::sleep(ms(400));
    send("-CONT");
    let deadline = Instant::now() + Duration::from_secs(60);
    let ended = loop {
        match child.try_wait().expect("it is ours") {
            None if Instant::now() > deadline => {
                child.kill().expect("it is ours");
                break child.wait();
            }
            None => std::thread::sleep(ms(20)),
            Some(status) => break Ok(status),
        }
    };
    assert!(ended.expect("ends").success());
}
