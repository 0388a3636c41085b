//! The summary lines as the runners really print them.

use super::*;

fn read(runner: Runner, lines: &[&str]) -> Tally {
    let mut tally = Tally::default();
    lines.iter().for_each(|line| tally.read(runner, line));
    tally
}

#[test]
fn cargo_test_lines_are_added_up() {
    let lines = [
        "running 3 tests",
        "test tests::a ... ok",
        "test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 2 filtered out; finished in 0.01s",
        "test result: \u{1b}[31mFAILED\u{1b}[0m. 4 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s",
        "the log said: 7 passed",
    ];
    assert_eq!(
        read(Runner::CargoTest, &lines),
        Tally {
            passed: 7,
            failed: 2,
            skipped: 1,
            unsteady: 0
        }
    );
}

#[test]
fn vitest_counts_tests_not_files() {
    let lines = [
        " \u{1b}[2m Test Files \u{1b}[22m \u{1b}[1m\u{1b}[32m2 passed\u{1b}[39m\u{1b}[22m\u{1b}[90m (2)\u{1b}[39m",
        " \u{1b}[2m      Tests \u{1b}[22m \u{1b}[31m1 failed\u{1b}[39m | \u{1b}[32m11 passed\u{1b}[39m | 2 skipped (14)",
    ];
    assert_eq!(
        read(Runner::Vitest, &lines),
        Tally {
            passed: 11,
            failed: 1,
            skipped: 2,
            unsteady: 0
        }
    );
}

#[test]
fn playwright_counts_its_closing_lines_only() {
    let lines = [
        "Running 5 tests using 1 worker",
        "  ✓  1 e2e/flight.spec.ts:4:1 › 3 passed over the page (2.1s)",
        "  1 failed",
        "    e2e/flight.spec.ts:20:1 › lands",
        "  1 skipped",
        "  1 did not run",
        "  1 flaky",
        "  2 passed (12.0s)",
    ];
    assert_eq!(
        read(Runner::Playwright, &lines),
        Tally {
            passed: 2,
            failed: 1,
            skipped: 2,
            unsteady: 1
        }
    );
}
