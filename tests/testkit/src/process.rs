//! A child process that cannot outlive its test and whose output is kept.
//!
//! Must never do: lose what the child said, or leave it running.

use crate::patience;
use parking_lot::Mutex;
use std::process::{ExitStatus, Stdio};
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncBufReadExt, AsyncRead, BufReader};
use tokio::process::{Child, Command};
use tokio::sync::watch;
use tokio::time::timeout;

/// A running child. Dropped, it is killed; if the test is failing then, its output is printed.
#[derive(Debug)]
pub struct Process {
    name: String,
    child: Child,
    output: Output,
}

/// Every line so far, and a bell that rings with each new one. The bell is gone when both streams have ended.
#[derive(Debug, Clone)]
struct Output {
    lines: Arc<Mutex<Vec<String>>>,
    bell: watch::Receiver<usize>,
}

impl Process {
    /// Starts it with its output collected and no input. Call it within a tokio runtime.
    ///
    /// # Panics
    /// If it cannot be started.
    #[must_use]
    pub fn start(name: &str, mut command: Command) -> Self {
        command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .kill_on_drop(true);
        let mut child = command
            .spawn()
            .unwrap_or_else(|error| panic!("cannot start {name}: {error}"));
        let (ring, bell) = watch::channel(0);
        let lines = Arc::new(Mutex::new(Vec::new()));
        let ring = Arc::new(ring);
        if let Some(stdout) = child.stdout.take() {
            tokio::spawn(collect(stdout, Arc::clone(&lines), Arc::clone(&ring)));
        }
        if let Some(stderr) = child.stderr.take() {
            tokio::spawn(collect(stderr, Arc::clone(&lines), ring));
        }
        Self {
            name: name.to_owned(),
            child,
            output: Output { lines, bell },
        }
    }

    /// The `skein` program with these arguments.
    ///
    /// # Panics
    /// If it does not compile or cannot be started.
    #[must_use]
    pub fn skein(arguments: &[&str]) -> Self {
        let mut command = Command::new(crate::skein_binary());
        command.args(arguments);
        // What it would keep in the home of whoever runs the tests.
        command.env("XDG_STATE_HOME", std::env::temp_dir().join("skein-tests"));
        Self::start(&format!("skein {}", arguments.join(" ")), command)
    }

    /// Its process id; `None` once it has ended.
    #[must_use]
    pub fn id(&self) -> Option<u32> {
        self.child.id()
    }

    /// Everything it has said so far, output and errors in the order in which they came.
    #[must_use]
    pub fn output(&self) -> String {
        self.output.lines.lock().join("\n")
    }

    /// Waits for a line that holds `part`, and returns it; a line that came before counts too.
    ///
    /// # Panics
    /// If the output ends, or the patience, without one.
    pub async fn line(&mut self, part: &str) -> String {
        let found = timeout(patience(), self.output.find(part)).await;
        match found {
            Ok(Some(line)) => line,
            Ok(None) => panic!(
                "{} ended without saying {part:?}; it said:\n{}",
                self.name,
                self.output()
            ),
            Err(_) => panic!(
                "{} did not say {part:?} in time; it said:\n{}",
                self.name,
                self.output()
            ),
        }
    }

    /// Waits for its end.
    ///
    /// # Panics
    /// If it does not end within `within`.
    pub async fn end(&mut self, within: Duration) -> ExitStatus {
        match timeout(within, self.child.wait()).await {
            Ok(status) => {
                let status = status.expect("a child can be waited for");
                // what it said last may still be in the pipe; a grandchild may hold the pipe open for ever
                let _ = timeout(Duration::from_secs(1), self.output.closed()).await;
                status
            }
            Err(_) => panic!(
                "{} did not end within {within:?}; it said:\n{}",
                self.name,
                self.output()
            ),
        }
    }

    /// Waits for its end and returns its exit code.
    ///
    /// # Panics
    /// If it does not end within `within`, or was ended by a signal.
    pub async fn exit_code(&mut self, within: Duration) -> i32 {
        let status = self.end(within).await;
        status
            .code()
            .unwrap_or_else(|| panic!("{} was ended by a signal: {status}", self.name))
    }

    /// Sends it a signal by name, for example `INT` or `TERM`.
    ///
    /// # Panics
    /// If it has ended already.
    pub async fn signal(&self, name: &str) {
        let id = self
            .id()
            .unwrap_or_else(|| panic!("{} has ended before SIG{name}", self.name));
        let status = Command::new("kill")
            .args([&format!("-{name}"), &id.to_string()])
            .status()
            .await;
        assert!(
            status.is_ok_and(|status| status.success()),
            "cannot send SIG{name} to {}",
            self.name
        );
    }

    /// Kills it and waits until it is gone.
    ///
    /// # Panics
    /// If the system does not let it be killed.
    pub async fn kill(&mut self) {
        self.child.kill().await.expect("a child can be killed");
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("--- output of {}:\n{}\n---", self.name, self.output());
        }
    }
}

impl Output {
    async fn find(&mut self, part: &str) -> Option<String> {
        let mut seen = 0;
        loop {
            let found = {
                let lines = self.lines.lock();
                let new = lines.get(seen..).unwrap_or_default();
                seen = lines.len();
                new.iter().find(|line| line.contains(part)).cloned()
            };
            if found.is_some() {
                return found;
            }
            let count = seen;
            if self.bell.wait_for(|rung| *rung > count).await.is_err() && self.lines.lock().len() == seen {
                return None;
            }
        }
    }

    async fn closed(&mut self) {
        while self.bell.changed().await.is_ok() {}
    }
}

async fn collect(stream: impl AsyncRead + Unpin, lines: Arc<Mutex<Vec<String>>>, bell: Arc<watch::Sender<usize>>) {
    let mut stream = BufReader::new(stream);
    let mut line = Vec::new();
    while matches!(stream.read_until(b'\n', &mut line).await, Ok(1..)) {
        let text = String::from_utf8_lossy(&line).trim_end().to_owned();
        let count = {
            let mut lines = lines.lock();
            lines.push(text);
            lines.len()
        };
        // both streams ring: the count never goes back
        bell.send_if_modified(|rung| {
            let more = count > *rung;
            *rung = count.max(*rung);
            more
        });
        line.clear();
    }
}

#[cfg(test)]
mod tests;
