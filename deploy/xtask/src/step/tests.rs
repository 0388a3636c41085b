//! A step fails when its command fails, and when it was to run tests and ran none.

use super::*;

fn shell(script: &str) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", script]);
    command
}

fn tests(script: &str) -> (Result<()>, Tally) {
    let mut tally = Tally::default();
    let result = Step::tests(shell(script), Runner::CargoTest).run(&mut tally);
    (result, tally)
}

#[test]
fn tests_that_pass_are_counted() {
    let (result, tally) = tests("echo 'test result: ok. 2 passed; 0 failed; 1 ignored; 0 measured'");
    assert!(result.is_ok());
    assert_eq!(
        tally,
        Tally {
            passed: 2,
            failed: 0,
            skipped: 1,
            unsteady: 0
        }
    );
}

#[test]
fn no_tests_are_a_failure() {
    let (result, _) = tests("echo 'test result: ok. 0 passed; 0 failed; 3 ignored; 0 measured'");
    assert!(result.is_err_and(|error| error.to_string().contains("no test ran")));
    assert!(tests("true").0.is_err());
}

#[test]
fn a_failing_command_is_a_failure_and_its_counts_hold() {
    let (result, tally) = tests("echo 'test result: FAILED. 2 passed; 1 failed; 0 ignored'; exit 101");
    assert!(result.is_err_and(|error| error.to_string().contains("101")));
    assert_eq!(
        tally,
        Tally {
            passed: 2,
            failed: 1,
            skipped: 0,
            unsteady: 0
        }
    );
    assert!(Step::new(shell("kill -KILL $$")).run(&mut Tally::default()).is_err());
    assert!(
        Step::new(Command::new("/no/such/program"))
            .run(&mut Tally::default())
            .is_err()
    );
}

#[test]
fn a_hung_command_is_ended_with_what_it_started() {
    let mut child = shell("sleep 600 & echo $!; wait")
        .process_group(0)
        .stdout(Stdio::piped())
        .spawn()
        .expect("sh starts");
    let mut line = String::new();
    let output = child.stdout.take().expect("piped");
    BufReader::new(output)
        .read_line(&mut line)
        .expect("it says the grandchild's id");
    assert!(wait(&mut child, &Heard::now(), TOTAL, Duration::ZERO, || {}).is_err());
    let running = || {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", line.trim())).unwrap_or_default();
        !stat.is_empty() && !stat.contains(") Z ")
    };
    // the signal is sent; the system takes a moment to act on it
    let deadline = Instant::now() + Duration::from_secs(20);
    while running() {
        assert!(Instant::now() < deadline, "the grandchild outlived its parent");
        std::thread::sleep(LOOK_EVERY);
    }
}

#[test]
fn what_a_command_leaves_behind_is_ended_and_holds_nothing_up() {
    // it has the step's output open
    let script = "sleep 600 & echo $!; echo 'test result: ok. 1 passed; 0 failed; 0 ignored'";
    let began = Instant::now();
    let (result, tally) = tests(script);
    assert!(result.is_ok() && tally.passed == 1);
    assert!(began.elapsed() < Duration::from_secs(300), "it was waited for");
}

#[test]
fn who_hangs_is_named() {
    let script = "echo 'test slow::one has been running for over 60 seconds'; exec sleep 600";
    let step = Step {
        quiet: Duration::from_secs(2),
        ..Step::tests(shell(script), Runner::CargoTest)
    };
    let error = step.run(&mut Tally::default()).expect_err("it is ended");
    let told = format!("{error:#}");
    assert!(told.contains("did not end: slow::one"), "{told}");
}

/// How a step ends that may be quiet and take so long.
fn with_limits(script: &str, quiet: Duration, total: Duration) -> Result<()> {
    let step = Step {
        quiet,
        total,
        ..Step::new(shell(script))
    };
    step.run(&mut Tally::default())
}

#[test]
fn who_is_quiet_for_too_long_is_hung() {
    let error = with_limits("echo begun; exec sleep 600", LOOK_EVERY, TOTAL).expect_err("it is ended");
    assert!(error.to_string().contains("said nothing"), "{error}");
}

#[test]
fn who_goes_on_talking_may_take_its_time() {
    // on either of its outputs; with pauses that are far shorter than the limit, and a whole that is longer
    let quiet = Duration::from_secs(3);
    std::thread::scope(|scope| {
        for to in ["1", "2"] {
            scope.spawn(move || {
                let script = format!("for word in a b c d e f g h; do echo $word >&{to}; sleep 0.5; done");
                let began = Instant::now();
                with_limits(&script, quiet, TOTAL).expect("it is let alone");
                assert!(began.elapsed() > quiet, "it was over before the limit could strike");
            });
        }
    });
}

#[test]
fn who_talks_for_ever_is_hung() {
    let talking = "while :; do echo word; sleep 0.1; done";
    let error = with_limits(talking, TOTAL, Duration::from_millis(500)).expect_err("it is ended");
    assert!(error.to_string().contains("still running"), "{error}");
}

#[test]
fn a_step_has_its_own_patience() {
    let asleep = Step::new(shell("sleep 600")).within(LOOK_EVERY);
    let error = asleep.run(&mut Tally::default()).expect_err("it is ended");
    assert!(error.to_string().contains("hung"), "{error}");
    let step = Step::new(shell("true")).within(TOTAL * 2);
    assert!(step.quiet == TOTAL * 2, "it may be quiet all the while");
}

#[test]
fn a_run_that_was_stopped_for_a_while_is_noticed() {
    let now = Instant::now();
    assert!(
        !is_standstill(now, now + LOOK_EVERY + Duration::from_millis(400)),
        "busy"
    );
    assert!(is_standstill(now, now + Duration::from_secs(2)));
}

#[test]
fn of_several_programs_all_are_run_and_what_failed_in_one_is_named() {
    let result =
        |passed: u32, failed: u32| format!("echo 'test result: x. {passed} passed; {failed} failed; 0 ignored'");
    let failing = format!(
        "echo 'running 3 tests'; echo 'failures:'; echo '    a::b'; {}; exit 101",
        result(2, 1)
    );
    let passing = format!("echo 'running 4 tests'; {}", result(4, 0));
    let (mut tally, mut failures) = (Tally::default(), Failures::default());
    let step = Step::programs(vec![shell(&failing), shell(&passing)], Runner::CargoTest);
    assert!(
        step.run_and_name(&mut tally, &mut failures)
            .is_err_and(|error| error.to_string().contains("101"))
    );
    assert_eq!((tally.passed, tally.failed), (6, 1));
    assert_eq!(failures.names(), ["a::b"]);

    let crashing = shell("echo 'running 3 tests'; kill -ABRT $$");
    let (mut tally, mut failures) = (Tally::default(), Failures::default());
    let step = Step::programs(vec![shell(&failing), crashing], Runner::CargoTest);
    assert!(step.run_and_name(&mut tally, &mut failures).is_err());
    assert!(failures.names().is_empty(), "what else failed is not known");

    assert!(
        Step::programs(Vec::new(), Runner::CargoTest)
            .run(&mut Tally::default())
            .is_err()
    );
}
