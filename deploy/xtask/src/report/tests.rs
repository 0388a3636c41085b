//! What a run comes to.

use super::*;
use crate::tally::Runner;
use anyhow::bail;
use std::process::Command;

fn code(report: Report<'_>) -> String {
    format!("{:?}", report.close())
}

#[test]
fn a_failed_step_fails_the_run_and_counts() {
    let mut report = Report::new();
    assert!(report.check("good", "nothing", || Ok(())));
    assert!(!report.check("bad", "mend it", || bail!("broken")));
    assert_eq!(
        report.total(),
        Tally {
            passed: 0,
            failed: 1,
            skipped: 0,
            unsteady: 0
        }
    );
    assert_eq!(code(report), format!("{:?}", ExitCode::FAILURE));
}

#[test]
fn a_run_without_failures_succeeds() {
    let mut report = Report::new();
    report.check("good", "nothing", || Ok(()));
    assert_eq!(report.total(), Tally::default());
    assert_eq!(code(report), format!("{:?}", ExitCode::SUCCESS));
}

fn printing(lines: &[&str], code: u8) -> Step {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("printf '%s\\n' \"$@\"; exit {code}"), "sh"]);
    Step::tests(
        {
            command.args(lines);
            command
        },
        Runner::CargoTest,
    )
}

fn failing_of(ran: usize, names: &[&str]) -> Step {
    let result = format!(
        "test result: FAILED. {} passed; {} failed; 0 ignored",
        ran - names.len(),
        names.len()
    );
    let names: Vec<String> = names.iter().map(|name| format!("    {name}")).collect();
    let mut lines = vec!["running some tests", "failures:"];
    lines.extend(names.iter().map(String::as_str));
    lines.extend(["", &result]);
    printing(&lines, 101)
}

fn failing(names: &[&str]) -> Step {
    failing_of(names.len() + 20, names)
}

fn passing(count: usize) -> Step {
    let result = format!("test result: ok. {count} passed; 0 failed; 0 ignored");
    printing(&["running 9 tests", &result], 0)
}

fn no_second_try(_: &[String]) -> Step {
    panic!("a second try")
}

#[test]
fn a_test_that_passes_when_tried_again_is_unsteady() {
    let mut report = Report::new();
    let passed = report.tests("flights", "", failing(&["one"]), |names| {
        assert_eq!(names, ["one"]);
        passing(1)
    });
    assert!(passed);
    let total = report.total();
    assert_eq!((total.passed, total.failed, total.unsteady), (20, 0, 1));
    assert_eq!(code(report), format!("{:?}", ExitCode::SUCCESS));
}

#[test]
fn their_number_over_a_run_fails_nothing_and_all_are_told() {
    let mut report = Report::new();
    for step in ["air", "browser", "hosts"] {
        assert!(report.tests(step, "", failing(&["a", "b"]), |_| passing(2)));
    }
    assert_eq!(report.total().unsteady, 6);
    let told = report.told_unsteady();
    assert!(told.starts_with("6 unsteady"), "{told}");
    for test in ["air: a", "air: b", "browser: a", "hosts: b"] {
        assert!(told.contains(&format!("unsteady: {test}\n")), "{told}");
    }
    assert_eq!(code(report), format!("{:?}", ExitCode::SUCCESS));
    assert_eq!(Report::new().told_unsteady(), "");
}

#[test]
fn a_test_that_fails_twice_has_failed() {
    let mut report = Report::new();
    assert!(!report.tests("flights", "", failing(&["one"]), |_| failing(&["one"])));
    assert!(!report.tests("flights", "", failing(&["one", "two"]), |_| passing(1)));
    assert_eq!(report.total().failed, 3);
    assert_eq!(report.told_unsteady(), "");
    assert_eq!(
        report.told_failed(),
        "  failed: flights: one\n  failed: flights: one\n  failed: flights: two\n"
    );
    assert_eq!(code(report), format!("{:?}", ExitCode::FAILURE));
}

#[test]
fn many_at_once_are_not_tried_again() {
    let mut report = Report::new();
    let many = ["a", "b", "c", "d", "e", "f", "g"];
    assert!(!report.tests("seven", "", failing_of(100, &many), no_second_try));
    assert!(report.tests("six", "", failing_of(100, &many[..6]), |_| passing(6)));
    assert!(!report.tests("more than a third", "", failing_of(5, &many[..2]), no_second_try));
    assert!(report.tests("a third", "", failing_of(6, &many[..2]), |_| passing(2)));
    assert!(report.tests("the only one", "", failing_of(1, &many[..1]), |_| passing(1)));
}

#[test]
fn only_what_is_named_is_tried_again() {
    let mut report = Report::new();
    let died = printing(&["running 2 tests"], 101);
    assert!(!report.tests("died", "", died, no_second_try));
    let lines = [
        "running 9 tests",
        "failures:",
        "    one",
        "",
        "test result: FAILED. 6 passed; 2 failed; 0 ignored",
        "test result: ok. 1 passed; 0 failed",
        "running 1 test",
    ];
    assert!(!report.tests("one without a name", "", printing(&lines, 101), no_second_try));
}

#[test]
fn a_plain_step_is_never_tried_again() {
    let mut report = Report::new();
    assert!(!report.step("seeds", "", failing(&["one"])));
    assert!(report.told_failed().starts_with("  failed: seeds: "));
    assert_eq!((report.total().failed, report.total().unsteady), (1, 0));
    assert_eq!(code(report), format!("{:?}", ExitCode::FAILURE));
}

/// As Playwright tells that some passed only when it tried them again itself.
fn in_the_browser(flaky: usize, passed: usize) -> Step {
    let mut lines = vec![format!("  {flaky} flaky")];
    lines.extend((0..flaky).map(|i| format!("    flight.spec.ts:{i}:1 › lands ────")));
    lines.push(format!("  {passed} passed (1.2m)"));
    let mut command = Command::new("sh");
    command.args(["-c", "printf '%s\\n' \"$@\"", "sh"]).args(lines);
    Step::tests(command, Runner::Playwright)
}

#[test]
fn second_tries_of_a_runner_itself_have_the_same_limits() {
    let mut report = Report::new();
    assert!(report.tries_itself("three", "", in_the_browser(3, 9), no_second_try));
    assert!(
        report
            .told_unsteady()
            .contains("unsteady: three: flight.spec.ts:2:1 › lands\n")
    );
    assert!(!report.tries_itself("seven", "", in_the_browser(7, 90), no_second_try));
    assert!(!report.tries_itself("a half", "", in_the_browser(3, 3), no_second_try));
    assert_eq!(code(report), format!("{:?}", ExitCode::FAILURE));
}

#[test]
fn whom_its_runner_has_tried_again_is_not_tried_a_third_time() {
    let mut report = Report::new();
    assert!(!report.tries_itself("one", "", failing(&["one"]), no_second_try));
    assert!(report.tries_itself("stopped", "", failing(&["one"]).with_standstill(), |_| passing(1)));
}

#[test]
fn who_fails_while_the_machine_stands_still_is_tried_until_it_does_not() {
    let tried = parking_lot::Mutex::new(Vec::new());
    let mut report = Report::new();
    let both = || failing_of(2, &["a", "b"]).with_standstill();
    let passed = report.tests("flights", "", both(), |names| {
        tried.lock().push(names.join(" "));
        match names.len() {
            2 => failing_of(2, &["b"]).with_standstill(),
            _ => passing(1),
        }
    });
    assert!(passed, "all of them, more than a third, and one twice");
    assert_eq!(*tried.lock(), ["a b", "b"]);
    assert_eq!((report.total().failed, report.total().unsteady), (0, 2));
    assert!(!report.tests("flights", "", both(), |_| failing_of(2, &["a", "b"])));
}

#[test]
fn what_comes_out_the_same_each_time_is_tried_again_only_after_a_standstill() {
    let mut report = Report::new();
    assert!(!report.same_each_time("seeds", "", failing(&["one"]), no_second_try));
    assert!(report.same_each_time("seeds", "", failing(&["one"]).with_standstill(), |_| passing(1)));
    assert!(!report.same_each_time("seeds", "", failing(&["one"]).with_standstill(), |_| failing(&["one"])));
}

#[test]
fn what_ran_in_the_background_counts() {
    let mut report = Report::new();
    let mut background = report.background();
    report.check("good", "nothing", || Ok(()));
    background.step(
        "one",
        "nothing",
        printing(&["test result: ok. 3 passed; 0 failed; 0 ignored"], 0),
    );
    assert!(!background.check("bad", "mend it", || bail!("broken")));
    report.join(background);
    assert_eq!((report.total().passed, report.total().failed), (3, 1));
    assert_eq!(code(report), format!("{:?}", ExitCode::FAILURE));
}

#[test]
fn who_fails_beside_others_is_tried_again_when_they_have_ended() {
    let ended = std::sync::atomic::AtomicBool::new(false);
    let mut report = Report::new();
    report.defer();
    let mut beside = report.background();
    let again = |_: &[String]| {
        assert!(ended.load(std::sync::atomic::Ordering::SeqCst), "it does not run alone");
        passing(1)
    };
    std::thread::scope(|scope| {
        scope.spawn(|| {
            assert!(!beside.tests("others", "nothing", failing_of(9, &["c::d"]), again));
            assert!(!beside.tests("wrong", "nothing", failing_of(9, &["e::f"]), |_| failing(&["e::f"])));
        });
        assert!(!report.tests("flights", "nothing", failing_of(9, &["a::b"]), again));
    });
    ended.store(true, std::sync::atomic::Ordering::SeqCst);
    report.join(beside);
    report.try_deferred();
    assert_eq!(report.unsteady_tests(), [("flights", "a::b"), ("others", "c::d")]);
    let total = report.total();
    assert_eq!((total.passed, total.failed, total.unsteady), (24, 1, 2));
    assert_eq!(code(report), format!("{:?}", ExitCode::FAILURE));
}
