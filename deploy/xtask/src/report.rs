//! The run as a whole: a line per step with its time, one summary, one closing line with the counts.
//!
//! Must never do: end in success when a step failed, or say `0 failed` then; keep quiet about a test that passed only when tried again.

#[cfg(test)]
mod tests;

use crate::failures::Failures;
use crate::step::Step;
use crate::tally::Tally;
use anyhow::{Result, ensure};
use std::fmt::Write;
use std::process::ExitCode;
use std::time::Instant;

/// So many tests of a step are tried again at most, and no more than a third of it. A machine that others use too stands still for some
/// tenths of a second now and then, which strikes a flight here and there; what strikes more of them has a cause that can be found.
const MOST_TRIED_AGAIN: u64 = 6;

/// Collects what the steps of a run came to.
pub struct Report {
    started: Instant,
    done: Vec<Done>,
}

struct Done {
    name: String,
    seconds: f64,
    tally: Tally,
    /// Those that failed and passed when tried again.
    unsteady: Vec<String>,
    failure: Option<String>,
}

impl Report {
    /// An empty one; the clock starts.
    pub fn new() -> Self {
        Self {
            started: Instant::now(),
            done: Vec::new(),
        }
    }

    /// Runs a child process as a step. `advice` says what to do if it fails. No test of it is tried again but by its own runner, of whose
    /// second tries the same holds as of ours.
    pub fn step(&mut self, name: &str, advice: &str, step: Step) -> bool {
        self.record(name, advice, |tally, unsteady| {
            let mut failures = Failures::default();
            step.run_and_name(tally, &mut failures)?;
            unsteady.extend_from_slice(failures.unsteady());
            ensure!(
                may_be_noise(tally.unsteady, tally.ran()),
                "{} tests passed only when tried again, of {}: that is no noise",
                tally.unsteady,
                tally.ran()
            );
            Ok(())
        })
    }

    /// Runs tests in real time as a step. Those that fail are tried once more, alone, unless they are many: `again` makes the command
    /// for those named.
    pub fn tests(&mut self, name: &str, advice: &str, step: Step, again: impl FnOnce(&[String]) -> Step) -> bool {
        self.record(name, advice, |tally, unsteady| {
            let mut failures = Failures::default();
            let Err(error) = step.run_and_name(tally, &mut failures) else {
                return Ok(());
            };
            let names = failures.names();
            let count = names.len() as u64;
            if count == 0 || count != tally.failed || !may_be_noise(count, tally.ran()) {
                return Err(error);
            }
            println!("-- {name}: a second try, alone: {}", names.join(", "));
            let mut second = Tally::default();
            again(names).run(&mut second)?;
            ensure!(second.passed >= count, "the second try did not run them all");
            tally.failed = 0;
            tally.unsteady += count;
            unsteady.extend_from_slice(names);
            Ok(())
        })
    }

    /// Runs a check of our own as a step.
    pub fn check(&mut self, name: &str, advice: &str, check: impl FnOnce() -> Result<()>) -> bool {
        self.record(name, advice, |_, _| check())
    }

    /// Notes something that was left out, and why.
    pub fn left_out(&mut self, name: &str, why: &str) {
        println!("-- {name}: left out, {why}");
    }

    fn record(
        &mut self,
        name: &str,
        advice: &str,
        work: impl FnOnce(&mut Tally, &mut Vec<String>) -> Result<()>,
    ) -> bool {
        println!("== {name}");
        let started = Instant::now();
        let mut tally = Tally::default();
        let mut unsteady = Vec::new();
        let failure = work(&mut tally, &mut unsteady).err().map(|error| format!("{error:#}"));
        let seconds = started.elapsed().as_secs_f64();
        if let Some(failure) = &failure {
            // a step that failed before a test could fail (it did not compile, say) counts as one failure
            tally.failed = tally.failed.max(1);
            println!("!! {name} failed after {seconds:.1} s: {failure}\n   what to do: {advice}");
        } else {
            println!(
                "ok {name}, {seconds:.1} s{}",
                if tally.ran() > 0 {
                    format!(", {tally}")
                } else {
                    String::new()
                }
            );
        }
        let ok = failure.is_none();
        self.done.push(Done {
            name: name.to_owned(),
            seconds,
            tally,
            unsteady,
            failure,
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
            let _ = writeln!(summary, "  {mark} {:<42} {:>7.1} s  {counts}", done.name, done.seconds);
        }
        let seconds = self.started.elapsed().as_secs_f64();
        println!("{summary}  {:<49} {seconds:>7.1} s", "all");
        print!("{}", self.told_unsteady());
        println!("{total}");
        if self.done.iter().all(|done| done.failure.is_none()) {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        }
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

/// Whether so many failed of those that ran may have failed because the machine did not let them run. One always may.
fn may_be_noise(failed: u64, ran: u64) -> bool {
    failed <= 1 || (failed <= MOST_TRIED_AGAIN && failed * 3 <= ran)
}
