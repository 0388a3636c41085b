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

/// So many tests of a run may fail and pass when tried again. Flights are in real time, and a machine that others use too stands still
/// for some tenths of a second now and then; more than these few are the program's fault or the tests'.
const MOST_UNSTEADY: u64 = 2;

/// Collects what the steps of a run came to.
pub struct Report {
    started: Instant,
    done: Vec<Done>,
}

struct Done {
    name: String,
    seconds: f64,
    tally: Tally,
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

    /// Runs a child process as a step. `advice` says what to do if it fails.
    pub fn step(&mut self, name: &str, advice: &str, step: Step) -> bool {
        self.record(name, advice, |tally| step.run(tally))
    }

    /// Runs tests as a step. If few fail they are tried once more, alone: `again` makes the command for those named.
    pub fn tests(&mut self, name: &str, advice: &str, step: Step, again: impl FnOnce(&[String]) -> Step) -> bool {
        let may_be_unsteady = MOST_UNSTEADY.saturating_sub(self.total().unsteady);
        self.record(name, advice, |tally| {
            let mut failures = Failures::default();
            let Err(error) = step.run_and_name(tally, &mut failures) else {
                return Ok(());
            };
            let names = failures.names();
            let count = names.len() as u64;
            if count == 0 || count > may_be_unsteady {
                return Err(error);
            }
            println!("-- {name}: a second try, alone: {}", names.join(", "));
            let mut second = Tally::default();
            again(names).run(&mut second)?;
            ensure!(second.passed >= count, "the second try did not run them all");
            tally.failed = tally.failed.saturating_sub(count);
            tally.unsteady += count;
            Ok(())
        })
    }

    /// Runs a check of our own as a step.
    pub fn check(&mut self, name: &str, advice: &str, check: impl FnOnce() -> Result<()>) -> bool {
        self.record(name, advice, |_| check())
    }

    /// Notes something that was left out, and why.
    pub fn left_out(&mut self, name: &str, why: &str) {
        println!("-- {name}: left out, {why}");
    }

    fn record(&mut self, name: &str, advice: &str, work: impl FnOnce(&mut Tally) -> Result<()>) -> bool {
        println!("== {name}");
        let started = Instant::now();
        let mut tally = Tally::default();
        let failure = work(&mut tally).err().map(|error| format!("{error:#}"));
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
            failure,
        });
        ok
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
        if total.unsteady > 0 {
            let count = total.unsteady;
            println!(
                "{count} unsteady (at most {MOST_UNSTEADY}): failed above, passed when tried again. Such a test has a fault, or the program."
            );
        }
        println!("{total}");
        if self.done.iter().all(|done| done.failure.is_none()) && total.unsteady <= MOST_UNSTEADY {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        }
    }
}
