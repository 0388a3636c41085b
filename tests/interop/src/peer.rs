//! A script that is spoken with: lines of JSON to it, its reports from it, and the latest truth that it told.
//!
//! Must never do: outlive its test; wait for ever.

use crate::python::{Environment, python_of};
use anyhow::{Context, Result, bail};
use parking_lot::{Condvar, Mutex};
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What it has told.
#[derive(Debug, Default)]
pub struct PeerReport {
    /// The latest truth.
    pub truth: Value,
    /// Everything else, in order.
    pub reports: Vec<Value>,
    ended: bool,
}

/// A running script. Dropping it ends it.
pub struct Peer {
    child: Child,
    input: ChildStdin,
    told: Arc<(Mutex<PeerReport>, Condvar)>,
}

impl Peer {
    /// Starts `tests/interop/python/<name>` with the environment's Python.
    ///
    /// # Errors
    /// When the environment cannot be made or the script cannot be started.
    pub fn start(name: &str, environment: &Environment, variables: &[(&str, &str)]) -> Result<Self> {
        let interpreter = python_of(environment)?;
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("python").join(name);
        let mut child = Command::new(interpreter)
            .arg("-u")
            .arg(&path)
            .envs(variables.iter().copied())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::inherit())
            .spawn()
            .with_context(|| format!("cannot start {}", path.display()))?;
        let output = child.stdout.take().context("the script has no output")?;
        let input = child.stdin.take().context("the script has no input")?;
        let told = Arc::<(Mutex<PeerReport>, Condvar)>::default();
        let telling = Arc::clone(&told);
        // Ends by itself when the script does.
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                take(&telling.0, &line);
                telling.1.notify_all();
            }
            telling.0.lock().ended = true;
            telling.1.notify_all();
        });
        Ok(Self { child, input, told })
    }

    /// Says one line to it.
    ///
    /// # Errors
    /// When it does not hear any more.
    pub fn say(&mut self, what: &Value) -> Result<()> {
        crate::say(&format!("    > {what}"));
        writeln!(self.input, "{what}").context("the script does not hear")?;
        self.input.flush().context("the script does not hear")
    }

    /// Waits until what it has told gives something.
    ///
    /// # Errors
    /// When it does not in time, or the script has ended.
    pub fn wait<T>(&self, limit: Duration, what: &str, mut probe: impl FnMut(&PeerReport) -> Option<T>) -> Result<T> {
        let end = Instant::now() + limit;
        let mut told = self.told.0.lock();
        loop {
            if let Some(found) = probe(&told) {
                return Ok(found);
            }
            if told.ended || Instant::now() >= end {
                let (truth, ended) = (&told.truth, told.ended);
                bail!("waited {limit:?} in vain for {what} (the script has ended: {ended}); {truth}");
            }
            self.told.1.wait_until(&mut told, end);
        }
    }

    /// The truth about one of whom it tells; null if there is none.
    #[must_use]
    pub fn truth(&self, who: &str) -> Value {
        let told = self.told.0.lock();
        told.truth[who].clone()
    }

    /// All reports so far.
    #[must_use]
    pub fn reports(&self) -> Vec<Value> {
        let told = self.told.0.lock();
        told.reports.clone()
    }
}

fn take(told: &Mutex<PeerReport>, line: &str) {
    let json = line.strip_prefix("REPORT ").map(serde_json::from_str::<Value>);
    let Some(Ok(report)) = json else {
        crate::say(&format!("    {line}"));
        return;
    };
    let mut told = told.lock();
    if report["truth"].is_object() {
        told.truth = report["truth"].clone();
    } else {
        crate::say(&format!("    {report}"));
        told.reports.push(report);
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
