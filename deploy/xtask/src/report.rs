//! The run as a whole: a line per step with its time, one summary, one closing line with the counts.
//!
//! Must never do: end in success when a step failed, or say `0 failed` then; keep quiet about a test that passed only when tried again.

#[cfg(test)]
mod tests;

use crate::failures::Failures;
use crate::output::Output;
use crate::step::Step;
use crate::tally::Tally;
use anyhow::{Result, bail, ensure};
use std::fmt::Write;
use std::process::ExitCode;
use std::time::Instant;

/// So many tests of a step are tried again at most, and no more than a third of it. A machine that others use too stands still for some
/// tenths of a second now and then, which strikes a flight here and there; what strikes more of them has a cause that can be found.
const MOST_TRIED_AGAIN: u64 = 6;
/// So often those are tried that fail while the machine stands still again and again.
const MOST_TRIES: usize = 10;

/// Collects what the steps of a run came to.
pub struct Report<'r> {
    started: Instant,
    done: Vec<Done>,
    output: Output,
    /// Tests that are tried again when nothing runs beside them any more; none if nothing does at any time.
    deferred: Option<Vec<Deferred<'r>>>,
}

/// Tests that failed and are to be tried again.
struct Deferred<'r> {
    step: String,
    tests: Vec<String>,
    again: Again<'r>,
}

/// Makes the command for tests of these names.
type Again<'r> = Box<dyn Fn(&[String]) -> Step + Send + 'r>;

struct Done {
    name: String,
    seconds: f64,
    tally: Tally,
    /// Those that failed and passed when tried again.
    unsteady: Vec<String>,
    /// The tests that failed, with their reasons.
    failed: Vec<String>,
    failure: Option<String>,
    in_background: bool,
}

impl<'r> Report<'r> {
    /// An empty one; the clock starts.
    pub fn new() -> Self {
        Self {
            started: Instant::now(),
            done: Vec::new(),
            output: Output::default(),
            deferred: None,
        }
    }

    /// From now on steps run beside each other: tests are tried again by [`Self::try_deferred`].
    pub fn defer(&mut self) {
        self.deferred.get_or_insert_default();
    }

    /// One for steps that run in the background of this one's. What they print is shown when each has ended.
    pub fn background(&self) -> Self {
        Self {
            started: Instant::now(),
            done: Vec::new(),
            output: Output::buffered(),
            deferred: self.deferred.as_ref().map(|_| Vec::new()),
        }
    }

    /// Takes in what ran in the background.
    pub fn join(&mut self, background: Self) {
        self.done.extend(background.done);
        self.deferred
            .get_or_insert_default()
            .extend(background.deferred.unwrap_or_default());
    }

    /// Tries those tests again that failed while others ran beside them. Nothing runs beside any from now on.
    pub fn try_deferred(&mut self) {
        for Deferred { step, tests, again } in self.deferred.take().unwrap_or_default() {
            println!("== {step}, once more");
            let outcome = try_again(&step, &tests, again, &Output::Live);
            let Some(done) = self.done.iter_mut().rev().find(|done| done.name == step) else {
                continue;
            };
            match outcome {
                Ok(()) => {
                    println!("ok {step}, when tried again");
                    done.failure = None;
                    done.failed.clear();
                    done.tally.passed_again(tests.len() as u64);
                }
                Err(error) => {
                    println!("!! {step} failed again: {error:#}");
                    done.failure = Some(format!("{error:#}"));
                    done.unsteady.clear();
                }
            }
        }
    }

    fn is_background(&self) -> bool {
        matches!(self.output, Output::Buffered(_))
    }

    /// Runs a child process as a step, once.
    pub fn step(&mut self, name: &str, advice: &str, step: Step) -> bool {
        let step = step.output(&self.output);
        self.record(name, advice, |tally, _| step.run(tally))
    }

    /// Runs tests in real time as a step. Those that fail are tried once more, alone, unless they are many: `again` makes the command
    /// for those named. While the machine stands still in a try, that says nothing of those that fail: they are tried anew, however many.
    pub fn tests(
        &mut self,
        name: &str,
        advice: &str,
        step: Step,
        again: impl Fn(&[String]) -> Step + Send + 'r,
    ) -> bool {
        self.tried_again(name, advice, step, again, |failed, _, ran| may_be_noise(failed, ran))
    }

    /// The same for tests that their runner has tried again itself: of those that passed then the same holds, and those that did not have
    /// failed, unless the machine stood still.
    pub fn tries_itself(
        &mut self,
        name: &str,
        advice: &str,
        step: Step,
        again: impl Fn(&[String]) -> Step + Send + 'r,
    ) -> bool {
        let may_be = |failed, unsteady, ran| failed == 0 && may_be_noise(unsteady, ran);
        self.tried_again(name, advice, step, again, may_be)
    }

    /// Runs tests as a step that come out the same each time: one that fails has failed. Only where the machine stood still they are tried
    /// again, for some wait for something in real time all the same; one that is wrong fails then, too.
    pub fn same_each_time(
        &mut self,
        name: &str,
        advice: &str,
        step: Step,
        again: impl Fn(&[String]) -> Step + Send + 'r,
    ) -> bool {
        self.tried_again(name, advice, step, again, |failed, _, _| failed == 0)
    }

    fn tried_again(
        &mut self,
        name: &str,
        advice: &str,
        step: Step,
        again: impl Fn(&[String]) -> Step + Send + 'r,
        may_be_noise: impl Fn(u64, u64, u64) -> bool,
    ) -> bool {
        let output = self.output.clone();
        let step = step.output(&output);
        let (defers, mut deferred) = (self.deferred.is_some(), Vec::new());
        let mut told = Vec::new();
        let passed = self.record(name, advice, |tally, unsteady| {
            let mut failures = Failures::default();
            let outcome = step.run_and_name(tally, &mut failures);
            told = failures.told();
            let names = failures.names();
            unsteady.extend([names, failures.unsteady()].concat());
            let count = names.len() as u64;
            let noise = failures.stood_still() || may_be_noise(count, tally.unsteady, tally.ran());
            let Err(error) = outcome else {
                ensure!(noise, "{}: that is no noise", passed_again(tally));
                return Ok(());
            };
            if count == 0 || count != tally.failed || !noise {
                unsteady.clear();
                return Err(error);
            }
            if defers {
                deferred = names.to_vec();
                bail!("{}: tried again at the end, alone", names.join(", "));
            }
            try_again(name, names, &again, &output).inspect_err(|_| unsteady.clear())?;
            tally.passed_again(count);
            Ok(())
        });
        if let (Some(done), false) = (self.done.last_mut(), passed) {
            done.failed = told;
        }
        if let (Some(all), false) = (&mut self.deferred, deferred.is_empty()) {
            all.push(Deferred {
                step: name.to_owned(),
                tests: deferred,
                again: Box::new(again),
            });
        }
        passed
    }

    /// Runs a check of our own as a step.
    pub fn check(&mut self, name: &str, advice: &str, check: impl FnOnce() -> Result<()>) -> bool {
        self.record(name, advice, |_, _| check())
    }

    /// Notes something that was left out, and why.
    pub fn left_out(&mut self, name: &str, why: &str) {
        self.output.line(&format!("-- {name}: left out, {why}"));
        self.output.end();
    }

    fn record(
        &mut self,
        name: &str,
        advice: &str,
        work: impl FnOnce(&mut Tally, &mut Vec<String>) -> Result<()>,
    ) -> bool {
        let in_background = self.is_background();
        if in_background {
            println!("-- {name}: begun in the background, shown when it has ended");
        }
        self.output.line(&format!("== {name}"));
        let started = Instant::now();
        let mut tally = Tally::default();
        let mut unsteady = Vec::new();
        let failure = work(&mut tally, &mut unsteady).err().map(|error| format!("{error:#}"));
        let seconds = started.elapsed().as_secs_f64();
        if let Some(failure) = &failure {
            // a step that failed before a test could fail (it did not compile, say) counts as one failure
            tally.failed = tally.failed.max(1);
            self.output.line(&format!(
                "!! {name} failed after {seconds:.1} s: {failure}\n   what to do: {advice}"
            ));
        } else {
            let counts = if tally.ran() > 0 {
                format!(", {tally}")
            } else {
                String::new()
            };
            self.output.line(&format!("ok {name}, {seconds:.1} s{counts}"));
        }
        self.output.end();
        let ok = failure.is_none();
        self.done.push(Done {
            name: name.to_owned(),
            seconds,
            tally,
            unsteady,
            failed: Vec::new(),
            failure,
            in_background,
        });
        ok
    }

    /// Those that failed and passed when tried again: step and test.
    pub fn unsteady_tests(&self) -> Vec<(&str, &str)> {
        let all = self.done.iter().flat_map(|done| {
            let tests = done.unsteady.iter();
            tests.map(|test| (done.name.as_str(), test.as_str()))
        });
        all.collect()
    }

    fn total(&self) -> Tally {
        let mut total = Tally::default();
        self.done.iter().for_each(|done| total += done.tally);
        total
    }

    /// Prints the summary and the closing line.
    pub fn close(self) -> ExitCode {
        let mut summary = String::from("\nSummary\n");
        let total = self.total();
        for done in &self.done {
            let mark = if done.failure.is_none() { "ok    " } else { "FAILED" };
            let counts = if done.tally.ran() > 0 {
                done.tally.to_string()
            } else {
                String::new()
            };
            // writing to a String cannot fail
            let background = if done.in_background { "background  " } else { "" };
            let _ = writeln!(
                summary,
                "  {mark} {:<42} {:>7.1} s  {background}{counts}",
                done.name, done.seconds
            );
        }
        let seconds = self.started.elapsed().as_secs_f64();
        println!("{summary}  {:<49} {seconds:>7.1} s", "all");
        print!("{}{}", self.told_failed(), self.told_unsteady());
        println!("{total}");
        if self.done.iter().all(|done| done.failure.is_none()) {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        }
    }

    /// What failed, a line for each test: who reads only the end of a long output finds the reason there.
    fn told_failed(&self) -> String {
        let failed = self.done.iter().filter(|done| done.failure.is_some());
        let mut text = String::new();
        for done in failed {
            if done.failed.is_empty() {
                let reason = done.failure.as_deref().unwrap_or_default();
                // writing to a String cannot fail
                let _ = writeln!(text, "  failed: {}: {reason}", done.name);
            }
            for test in &done.failed {
                let _ = writeln!(text, "  failed: {}: {test}", done.name);
            }
        }
        text
    }

    /// What the reader is told of unsteady tests, a line for each; nothing where there are none.
    fn told_unsteady(&self) -> String {
        let count = self.total().unsteady;
        if count == 0 {
            return String::new();
        }
        let mut text = format!(
            "{count} unsteady: failed above, passed when tried again. Such a test has a fault, or the program: to be looked into.\n"
        );
        for (step, test) in self.unsteady_tests() {
            // writing to a String cannot fail
            let _ = writeln!(text, "  unsteady: {step}: {test}");
        }
        text
    }
}

fn passed_again(tally: &Tally) -> String {
    let (unsteady, ran) = (tally.unsteady, tally.ran());
    format!("{unsteady} tests passed only when tried again, of {ran}")
}

/// Tries these again, alone, until each has passed once.
fn try_again(name: &str, names: &[String], again: impl Fn(&[String]) -> Step, output: &Output) -> Result<()> {
    let mut left = names.to_vec();
    for _ in 0..MOST_TRIES {
        output.line(&format!("-- {name}: another try, alone: {}", left.join(", ")));
        let (mut tally, mut failures) = (Tally::default(), Failures::default());
        let outcome = again(&left).run_and_name(&mut tally, &mut failures);
        match outcome {
            Ok(()) => {
                ensure!(tally.passed >= left.len() as u64, "the other try did not run them all");
                return Ok(());
            }
            Err(_) if failures.stood_still() && !failures.names().is_empty() => {
                output.line("-- the machine stood still meanwhile: that says nothing of those that failed");
                left = failures.names().to_vec();
            }
            Err(error) => return Err(error),
        }
    }
    bail!(
        "the machine stood still in each of {MOST_TRIES} tries: {}",
        left.join(", ")
    )
}

/// Whether so many failed of those that ran may have failed because the machine did not let them run. One always may.
fn may_be_noise(failed: u64, ran: u64) -> bool {
    failed <= 1 || (failed <= MOST_TRIED_AGAIN && failed * 3 <= ran)
}
