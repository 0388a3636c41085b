//! One child process: started, its output shown and counted as it comes, ended when its time is over.
//!
//! Must never do: swallow output, or leave a child behind when its time is over.

#[cfg(test)]
mod tests;

use crate::failures::Failures;
use crate::tally::{Runner, Tally};
use anyhow::{Context, Result, bail};
use std::io::{BufRead, BufReader, IsTerminal};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// A step may take this long before it is taken for hung, unless it says otherwise. The whole of CI has 40 minutes.
const PATIENCE: Duration = Duration::from_secs(25 * 60);
/// How often a running child is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// A command to run.
pub struct Step {
    command: Command,
    runner: Option<Runner>,
    must_run_some: bool,
    patience: Duration,
}

impl Step {
    /// A command that counts no tests.
    pub fn new(command: Command) -> Self {
        Self {
            command,
            runner: None,
            must_run_some: false,
            patience: PATIENCE,
        }
    }

    /// A command that runs tests; running none is a failure.
    pub fn tests(command: Command, runner: Runner) -> Self {
        Self {
            command,
            runner: Some(runner),
            must_run_some: true,
            patience: PATIENCE,
        }
    }

    /// A command that runs tests if there are any.
    pub fn perhaps_tests(command: Command, runner: Runner) -> Self {
        Self {
            command,
            runner: Some(runner),
            must_run_some: false,
            patience: PATIENCE,
        }
    }

    /// It may take this long before it is taken for hung.
    pub fn within(mut self, patience: Duration) -> Self {
        self.patience = patience;
        self
    }

    /// Runs it to its end. The tally holds also when the result is an error.
    pub fn run(self, tally: &mut Tally) -> Result<()> {
        self.run_and_name(tally, &mut Failures::default())
    }

    /// The same, and tells which tests failed.
    pub fn run_and_name(mut self, tally: &mut Tally, failures: &mut Failures) -> Result<()> {
        let name = self.command.get_program().to_string_lossy().into_owned();
        self.command.stdin(Stdio::null());
        if std::io::stdout().is_terminal() {
            self.command.env("CARGO_TERM_COLOR", "always");
        }
        let status = match self.runner {
            None => {
                let mut child = self.command.spawn().with_context(|| format!("cannot start {name}"))?;
                wait(&mut child, self.patience)?
            }
            Some(runner) => {
                let mut child = self
                    .command
                    .stdout(Stdio::piped())
                    .spawn()
                    .with_context(|| format!("cannot start {name}"))?;
                let output = child.stdout.take().context("the child's output is piped")?;
                let reader = std::thread::spawn(move || count(BufReader::new(output), runner));
                let status = wait(&mut child, self.patience);
                let (counted, failed) = reader.join().unwrap_or_default();
                *tally += counted;
                *failures = failed;
                status?
            }
        };
        match status.code() {
            Some(0) if self.must_run_some && tally.ran() == 0 => {
                bail!("no test ran: a tier without tests proves nothing")
            }
            Some(0) => Ok(()),
            Some(code) => bail!("{name} ended with exit code {code}"),
            None => bail!("{name} was ended by a signal"),
        }
    }
}

fn count(output: impl BufRead, runner: Runner) -> (Tally, Failures) {
    let mut tally = Tally::default();
    let mut failures = Failures::default();
    for line in output.split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line).into_owned();
        println!("{line}");
        tally.read(runner, &line);
        failures.read(&line);
    }
    (tally, failures)
}

fn wait(child: &mut Child, patience: Duration) -> Result<ExitStatus> {
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if started.elapsed() > patience {
            end_tree(child.id());
            child.wait()?;
            bail!("hung: ended after {} minutes", patience.as_secs() / 60);
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

/// Kills the process and everything it started: a test binary would outlive the cargo that ran it.
fn end_tree(root: u32) {
    let mut pids = vec![root];
    let mut next = 0;
    while let Some(&parent) = pids.get(next) {
        next += 1;
        let tasks = std::fs::read_dir(format!("/proc/{parent}/task"))
            .into_iter()
            .flatten()
            .flatten();
        for task in tasks {
            let children = std::fs::read_to_string(task.path().join("children")).unwrap_or_default();
            pids.extend(children.split_whitespace().filter_map(|pid| pid.parse::<u32>().ok()));
        }
    }
    // nothing is left to do if kill itself is missing
    let _ = Command::new("kill")
        .arg("-KILL")
        .args(pids.iter().map(u32::to_string))
        .status();
}
