//! A script under watch: its lines are shown as they come, those that begin with `REPORT` are read as JSON, and it is
//! ended when its time is up.

use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Shows progress at once, also where the test harness keeps back what is printed.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// A running script. Dropping it ends it.
pub struct Script {
    child: Child,
    input: ChildStdin,
    lines: Receiver<String>,
    end: Instant,
    /// Its last report is to be judged before it goes on.
    waits: bool,
}

impl Script {
    /// Starts `tests/interop/python/<name>` with the environment's Python.
    ///
    /// # Errors
    /// When the environment cannot be made or the script cannot be started.
    pub fn start(name: &str, arguments: &[String], limit: Duration) -> Result<Self> {
        Self::start_by(Command::new(crate::python()?), name, arguments, limit)
    }

    /// The same by another Python, whose command holds its environment.
    ///
    /// # Errors
    /// When the script cannot be started.
    pub fn start_by(mut python: Command, name: &str, arguments: &[String], limit: Duration) -> Result<Self> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("python").join(name);
        let mut child = python
            .arg("-u")
            .arg(&path)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::inherit())
            .spawn()
            .with_context(|| format!("cannot start {}", path.display()))?;
        let output = child.stdout.take().context("the script has no output")?;
        let input = child.stdin.take().context("the script has no input")?;
        let (send, lines) = std::sync::mpsc::channel();
        // Ends by itself when the script does.
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                if send.send(line).is_err() {
                    return;
                }
            }
        });
        Ok(Self {
            child,
            input,
            lines,
            end: Instant::now() + limit,
            waits: false,
        })
    }

    /// The next report; `None` when the script has come to a good end. A report with `waits` holds the script until the next one is asked for: what is
    /// judged by the truth of that moment must not be judged later.
    ///
    /// # Errors
    /// When it failed, or its time is up.
    pub fn report(&mut self) -> Result<Option<Value>> {
        if std::mem::take(&mut self.waits) {
            // One that has ended meanwhile is told of below.
            let _ = writeln!(self.input).and_then(|()| self.input.flush());
        }
        loop {
            let left = self.end.saturating_duration_since(Instant::now());
            match self.lines.recv_timeout(left) {
                Ok(line) => {
                    say(&format!("    {line}"));
                    if let Some(json) = line.strip_prefix("REPORT ") {
                        let report: Value = serde_json::from_str(json).with_context(|| format!("not JSON: {json}"))?;
                        self.waits = report["waits"] == true;
                        return Ok(Some(report));
                    }
                }
                Err(RecvTimeoutError::Timeout) => bail!("the script took too long"),
                Err(RecvTimeoutError::Disconnected) => {
                    let status = self.child.wait().context("cannot wait for the script")?;
                    if !status.success() {
                        bail!("the script failed: {status}");
                    }
                    return Ok(None);
                }
            }
        }
    }
}

impl Drop for Script {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
