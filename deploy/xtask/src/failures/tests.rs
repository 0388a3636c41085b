//! The lists as test programs really print them.

use super::*;

const TWO_FAILED: &str = "
running 3 tests
test a_flight ... FAILED
test another ... ok
test third::one ... FAILED

failures:

---- a_flight stdout ----

thread 'a_flight' (7) panicked at tests/a.rs:3:5:
    left: 1
failures:
it said

---- third::one stdout ----
    note


failures:
    a_flight
    third::one

test result: FAILED. 1 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s
";

fn read(texts: &[&str]) -> Failures {
    let mut failures = Failures::default();
    texts
        .iter()
        .flat_map(|text| text.lines())
        .for_each(|line| failures.read(line));
    failures
}

#[test]
fn those_listed_are_named() {
    assert_eq!(read(&[TWO_FAILED]).names(), ["a_flight", "third::one"]);
    assert_eq!(
        read(&["running 1 test", "test result: ok. 1 passed; 0 failed"])
            .names()
            .len(),
        0
    );
}

#[test]
fn each_is_told_with_its_panic() {
    let told = read(&[TWO_FAILED]).told();
    assert_eq!(
        told,
        [
            "a_flight: thread 'a_flight' (7) panicked at tests/a.rs:3:5: | left: 1",
            "third::one"
        ]
    );
}

#[test]
fn none_is_named_where_a_program_died() {
    assert_eq!(read(&[TWO_FAILED, "running 2 tests\ntest x ... "]).names().len(), 0);
}

#[test]
fn those_that_the_browsers_runner_tried_again_are_named() {
    let lines = [
        "  ✘  1 flight.spec.ts:4:1 › lands (2.1s)",
        "  ✓  2 flight.spec.ts:4:1 › lands (retry #1) (2.0s)",
        "  1 failed",
        "    map.spec.ts:9:1 › draws ──────────────",
        "  2 flaky",
        "    flight.spec.ts:4:1 › lands ──────────────",
        "    units.spec.ts:7:3 › feet › of height ────",
        "  12 passed (3.1m)",
        "    flight.spec.ts:5:1 › not listed",
    ];
    assert_eq!(
        read(&lines).unsteady(),
        ["flight.spec.ts:4:1 › lands", "units.spec.ts:7:3 › feet › of height"]
    );
    assert_eq!(read(&lines).names(), ["map.spec.ts:9:1 › draws"]);
}

#[test]
fn who_takes_long_has_not_ended_until_it_has() {
    let long = "test a::slow has been running for over 60 seconds\ntest b::slow has been running for over 60 seconds\n";
    assert_eq!(read(&[long]).unended(), ["a::slow", "b::slow"]);
    assert_eq!(read(&[long, "test a::slow ... ok\n"]).unended(), ["b::slow"]);
}

#[test]
fn where_one_runs_at_a_time_it_has_not_ended_while_its_line_has_not() {
    assert_eq!(
        read(&["running 2 tests\ntest a::quick ... ok\ntest b::hung ... "]).unended(),
        ["b::hung"]
    );
}
