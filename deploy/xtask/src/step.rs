//! One child process: started, its output shown and counted as it comes, ended when it is taken for hung.
//!
//! Must never do: swallow output, or leave a child behind when its time is over.

#[cfg(test)]
mod tests;

use crate::failures::Failures;
use crate::output::Output;
use crate::processes;
use crate::tally::{Runner, Tally};
use anyhow::{Context, Result, bail, ensure};
use std::io::{BufRead, BufReader, IsTerminal, Read};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Who has said nothing for so long is taken for hung. How long a step takes says nothing of that: on a machine half as fast it takes
/// twice as long, but goes on telling what it does: cargo names each crate, a runner each test. Quiet without being hung is one test
/// that first makes a Python environment (the whole of its tier takes seven minutes), and a cargo that waits for another's lock.
const QUIET: Duration = Duration::from_secs(15 * 60);
/// Who talks for ever is hung too. Four times what the longest step takes on two cores, which is the browser's.
const TOTAL: Duration = Duration::from_secs(60 * 60);
/// How often a running child is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// Who comes to look only after so long was stopped, and the child most likely with it: the machine slept, or all its processes were stopped. A
/// machine that is only busy lets each run more often than that.
const STOOD_STILL: Duration = Duration::from_millis(750);

/// A command to run, or several one after the other.
pub struct Step {
    commands: Vec<Command>,
    runner: Option<Runner>,
    must_run_some: bool,
    quiet: Duration,
    total: Duration,
    output: Output,
    /// In tests: as if the machine had stood still meanwhile.
    #[cfg(test)]
    standstill: bool,
}

impl Step {
    /// A command that counts no tests.
    pub fn new(command: Command) -> Self {
        Self::of(vec![command], None)
    }

    /// A command that runs tests if there are any.
    pub fn perhaps_tests(command: Command, runner: Runner) -> Self {
        Self::of(vec![command], Some(runner))
    }

    /// A command that runs tests; running none is a failure.
    pub fn tests(command: Command, runner: Runner) -> Self {
        Self::programs(vec![command], runner)
    }

    /// Test programs, all of which are run, also after one that fails; no test in any of them is a failure.
    pub fn programs(commands: Vec<Command>, runner: Runner) -> Self {
        Self {
            must_run_some: true,
            ..Self::of(commands, Some(runner))
        }
    }

    fn of(commands: Vec<Command>, runner: Option<Runner>) -> Self {
        Self {
            commands,
            runner,
            must_run_some: false,
            quiet: QUIET,
            total: TOTAL,
            output: Output::default(),
            #[cfg(test)]
            standstill: false,
        }
    }

    /// As if the machine had stood still meanwhile.
    #[cfg(test)]
    pub fn with_standstill(mut self) -> Self {
        self.standstill = true;
        self
    }

    /// It may take this long before it is taken for hung, and be quiet all the while.
    pub fn within(mut self, total: Duration) -> Self {
        (self.quiet, self.total) = (total, total);
        self
    }

    /// Where its lines go.
    pub fn output(mut self, output: &Output) -> Self {
        self.output = output.clone();
        self
    }

    /// Runs it to its end. The tally holds also when the result is an error.
    pub fn run(self, tally: &mut Tally) -> Result<()> {
        self.run_and_name(tally, &mut Failures::default())
    }

    /// The same, and tells which tests failed.
    pub fn run_and_name(mut self, tally: &mut Tally, failures: &mut Failures) -> Result<()> {
        let commands = std::mem::take(&mut self.commands);
        let mut outcomes = Vec::new();
        for command in commands {
            let name = command.get_program().to_string_lossy().into_owned();
            let outcome = self.run_one(&name, command, tally, failures);
            outcomes.extend(outcome.err().map(|error| (name, error)));
        }
        #[cfg(test)]
        if self.standstill {
            failures.note_standstill();
        }
        match outcomes.len() {
            0 if self.must_run_some && tally.ran() == 0 => {
                bail!("no test ran: a tier without tests proves nothing")
            }
            0 => Ok(()),
            1 => Err(outcomes.remove(0).1),
            count => {
                let told: Vec<String> = outcomes.iter().map(|(_, error)| format!("{error:#}")).collect();
                bail!("{count} programs failed: {}", told.join("; "))
            }
        }
    }

    fn run_one(&self, name: &str, mut command: Command, tally: &mut Tally, failures: &mut Failures) -> Result<()> {
        ensure!(!processes::is_interrupted(), "interrupted");
        if std::io::stdout().is_terminal() {
            command.env("CARGO_TERM_COLOR", "always");
        }
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // so that everything it starts is found, also when those in between are gone
            .process_group(0)
            .spawn()
            .with_context(|| format!("cannot start {name}"))?;
        let output = child.stdout.take().context("the child's output is piped")?;
        let complaints = child.stderr.take().context("the child's complaints are piped")?;
        let heard = Arc::new(Heard::now());
        let (of_output, of_complaints) = (heard.clone(), heard.clone());
        let runner = self.runner;
        let (shown, shown_too) = (self.output.clone(), self.output.clone());
        let reader = std::thread::spawn(move || count(output, runner, &of_output, &shown));
        let passer = std::thread::spawn(move || pass_on(complaints, &of_complaints, &shown_too));
        let status = wait(&mut child, &heard, self.quiet, self.total, || {
            failures.note_standstill()
        });
        // who still holds an end of the outputs would keep the readers for ever
        let left = processes::below(child.id());
        if !left.is_empty() && status.is_ok() {
            self.output
                .line(&format!("-- {name} has left behind, now ended: {}", list(&left)));
        }
        processes::end(child.id());
        let (counted, failed) = reader.join().unwrap_or_default();
        // it has nothing to tell but what it has shown
        let _ = passer.join();
        *tally += counted;
        let unended = failed.unended();
        failures.add(failed);
        let status = match status {
            Ok(status) => status,
            Err(error) if unended.is_empty() => return Err(error),
            Err(error) => return Err(error.context(format!("did not end: {}", unended.join(", ")))),
        };
        match status.code() {
            Some(0) => Ok(()),
            Some(code) => bail!("{name} ended with exit code {code}"),
            None => bail!("{name} was ended by a signal"),
        }
    }
}

/// When the child was last heard of.
struct Heard {
    started: Instant,
    /// In milliseconds since then.
    last: AtomicU64,
}

impl Heard {
    fn now() -> Self {
        Self {
            started: Instant::now(),
            last: AtomicU64::new(0),
        }
    }

    fn again(&self) {
        let now = u64::try_from(self.started.elapsed().as_millis()).unwrap_or(u64::MAX);
        // the two outputs are read by a thread each, and one may be slow to say when it heard
        self.last.fetch_max(now, Ordering::Relaxed);
    }

    fn quiet_for(&self) -> Duration {
        let last = Duration::from_millis(self.last.load(Ordering::Relaxed));
        self.started.elapsed().saturating_sub(last)
    }
}

/// Line by line, as text, until the other side is closed.
fn lines(from: impl Read, heard: &Heard) -> impl Iterator<Item = String> {
    let lines = BufReader::new(from).split(b'\n').map_while(Result::ok);
    lines.map(|line| {
        heard.again();
        String::from_utf8_lossy(&line).into_owned()
    })
}

fn count(output: impl Read, runner: Option<Runner>, heard: &Heard, shown: &Output) -> (Tally, Failures) {
    let mut tally = Tally::default();
    let mut failures = Failures::default();
    for line in lines(output, heard) {
        shown.line(&line);
        if let Some(runner) = runner {
            tally.read(runner, &line);
            failures.read(&line);
        }
    }
    (tally, failures)
}

fn pass_on(complaints: impl Read, heard: &Heard, shown: &Output) {
    lines(complaints, heard).for_each(|line| shown.complaint(&line));
}

/// Whether the time between two looks says that this run was stopped.
fn is_standstill(looked: Instant, now: Instant) -> bool {
    now.duration_since(looked) > STOOD_STILL
}

fn wait(
    child: &mut Child,
    heard: &Heard,
    quiet: Duration,
    total: Duration,
    mut stood_still: impl FnMut(),
) -> Result<ExitStatus> {
    let mut looked = Instant::now();
    loop {
        let now = Instant::now();
        if is_standstill(looked, now) {
            stood_still();
        }
        looked = now;
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        let hung = if heard.quiet_for() > quiet {
            format!("said nothing for {} minutes", quiet.as_secs() / 60)
        } else if heard.started.elapsed() > total {
            format!("still running after {} minutes", total.as_secs() / 60)
        } else {
            std::thread::sleep(LOOK_EVERY);
            continue;
        };
        let running = list(&processes::below(child.id()));
        processes::end(child.id());
        child.wait()?;
        bail!("hung: {hung}, and was ended with {running}");
    }
}

fn list(processes: &[processes::Process]) -> String {
    let names: Vec<String> = processes.iter().map(ToString::to_string).collect();
    if names.is_empty() {
        "nothing below it".to_owned()
    } else {
        names.join(", ")
    }
}
