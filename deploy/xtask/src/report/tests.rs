//! What a run comes to.

use super::*;
use crate::tally::Runner;
use anyhow::bail;
use std::process::Command;

fn code(report: Report) -> String {
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

fn failing(names: &[&str]) -> Step {
    let result = format!("test result: FAILED. 5 passed; {} failed; 0 ignored", names.len());
    let names: Vec<String> = names.iter().map(|name| format!("    {name}")).collect();
    let mut lines = vec!["running 6 tests", "failures:"];
    lines.extend(names.iter().map(String::as_str));
    lines.extend(["", &result]);
    printing(&lines, 101)
}

fn passing(count: usize) -> Step {
    let result = format!("test result: ok. {count} passed; 0 failed; 0 ignored");
    printing(&["running 9 tests", &result], 0)
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
    assert_eq!((total.passed, total.failed, total.unsteady), (5, 0, 1));
    assert_eq!(code(report), format!("{:?}", ExitCode::SUCCESS));
}

#[test]
fn a_test_that_fails_twice_has_failed() {
    let mut report = Report::new();
    assert!(!report.tests("flights", "", failing(&["one"]), |_| failing(&["one"])));
    assert!(!report.tests("flights", "", failing(&["one", "two"]), |_| passing(1)));
    assert_eq!(report.total().failed, 3);
    assert_eq!(code(report), format!("{:?}", ExitCode::FAILURE));
}

#[test]
fn more_than_a_few_are_not_tried_again() {
    let mut report = Report::new();
    assert!(!report.tests("many", "", failing(&["a", "b", "c"]), |_| panic!("a second try")));
    assert!(report.tests("two", "", failing(&["a", "b"]), |_| passing(2)));
    assert!(!report.tests("a third", "", failing(&["c"]), |_| panic!("a second try")));
    let died = printing(&["running 2 tests"], 101);
    assert!(!report.tests("died", "", died, |_| panic!("a second try")));
}
