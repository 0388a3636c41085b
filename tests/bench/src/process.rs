//! Child processes, and what the system charges them.

use crate::error::BenchError;
use nix::unistd::{SysconfVar, sysconf};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader, Lines};
use tokio::process::{Child, ChildStdin, ChildStdout, Command};

/// How long a child may take for a line that is expected.
const PATIENCE: Duration = Duration::from_secs(30);

/// How the processes of a bench are scheduled. On a machine that does other work too, the ordinary way measures that work as well:
/// it delays setpoints far more than any program does by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scheduling {
    /// As any process.
    #[default]
    Ordinary,
    /// First in, first out, before all ordinary processes; needs the right to it and the system's command `chrt`.
    RealTime {
        /// 1 to 99.
        priority: u8,
    },
}

/// A child process that is killed when this is dropped.
pub(crate) struct Part {
    name: &'static str,
    child: Child,
    input: Option<ChildStdin>,
    lines: Lines<BufReader<ChildStdout>>,
}

impl Part {
    /// Starts `program` with these arguments; what it writes to its standard error goes to `errors`.
    pub fn start(
        name: &'static str,
        program: &Path,
        arguments: &[&str],
        scheduling: Scheduling,
        errors: Stdio,
    ) -> Result<Self, BenchError> {
        let command = match scheduling {
            Scheduling::Ordinary => Command::new(program),
            Scheduling::RealTime { priority } => {
                // It becomes the program, so that the process measured is the right one.
                let mut command = Command::new("chrt");
                command.args(["--fifo", &priority.to_string()]).arg(program);
                command
            }
        };
        Self::start_by(name, command, arguments, errors)
    }

    /// The same by a command that holds the program and its environment.
    pub fn start_by(
        name: &'static str,
        mut command: Command,
        arguments: &[&str],
        errors: Stdio,
    ) -> Result<Self, BenchError> {
        let started = command
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(errors)
            .kill_on_drop(true)
            .spawn();
        let mut child = started.map_err(|source| BenchError::Start {
            program: command.as_std().get_program().into(),
            source,
        })?;
        let gone = || BenchError::Child {
            part: name,
            detail: "has no standard output".into(),
        };
        let lines = BufReader::new(child.stdout.take().ok_or_else(gone)?).lines();
        let input = child.stdin.take();
        Ok(Self {
            name,
            child,
            input,
            lines,
        })
    }

    fn error(&self, detail: impl Into<String>) -> BenchError {
        BenchError::Child {
            part: self.name,
            detail: detail.into(),
        }
    }

    /// Its next line.
    pub async fn line(&mut self) -> Result<String, BenchError> {
        match tokio::time::timeout(PATIENCE, self.lines.next_line()).await {
            Err(_) => Err(self.error(format!("said nothing for {} s", PATIENCE.as_secs()))),
            Ok(Err(e)) => Err(self.error(e.to_string())),
            Ok(Ok(None)) => {
                let ended = self.child.wait().await;
                Err(self.error(ended.map_or_else(|e| e.to_string(), |status| format!("ended ({status})"))))
            }
            Ok(Ok(Some(line))) => Ok(line),
        }
    }

    /// Writes to its standard input.
    pub async fn tell(&mut self, order: &[u8]) -> Result<(), BenchError> {
        let Some(input) = &mut self.input else {
            return Err(self.error("has no standard input"));
        };
        let told = async { input.write_all(order).await.and(input.flush().await) };
        told.await.map_err(|e| self.error(e.to_string()))
    }

    /// What it has used so far.
    pub fn usage(&self) -> Result<Usage, BenchError> {
        let id = self.child.id().ok_or_else(|| self.error("has ended"))?;
        Usage::of(id).ok_or_else(|| self.error("its figures in /proc cannot be read"))
    }

    /// Kills it and waits for its end.
    pub async fn stop(mut self) {
        // One that has ended already is as good.
        let _ = self.child.kill().await;
    }
}

/// What a process has used.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Usage {
    /// Processor time in seconds, all threads.
    pub cpu_s: f64,
    /// Resident memory in MiB.
    pub rss_mib: f64,
    /// Threads.
    pub threads: u32,
}

impl Usage {
    fn of(process: u32) -> Option<Self> {
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
        Self::parse(&stat, &status, ticks_per_s())
    }

    /// From the texts of `stat` and `status`.
    fn parse(stat: &str, status: &str, ticks_per_s: f64) -> Option<Self> {
        // The name, in brackets, may hold anything; after it the fields count from 3.
        let (_, rest) = stat.rsplit_once(')')?;
        let fields: Vec<&str> = rest.split_whitespace().collect();
        let ticks = |field: usize| fields.get(field - 3)?.parse::<f64>().ok();
        let value = |key: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(key))?;
            line.split_whitespace().next()?.parse::<f64>().ok()
        };
        Some(Self {
            cpu_s: (ticks(14)? + ticks(15)?) / ticks_per_s,
            rss_mib: value("VmRSS:")? / 1024.0,
            threads: value("Threads:")? as u32,
        })
    }
}

fn ticks_per_s() -> f64 {
    sysconf(SysconfVar::CLK_TCK)
        .ok()
        .flatten()
        .map_or(100.0, |ticks| ticks as f64)
}

/// What the whole machine has used.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Machine {
    /// Busy processor time in seconds, all processors.
    pub busy_s: f64,
    /// Datagrams dropped because a receive buffer was full.
    pub dropped_datagrams: u64,
}

impl Machine {
    /// Now; zero where the system does not say.
    pub fn now() -> Self {
        let read = |path| std::fs::read_to_string(path).unwrap_or_default();
        Self {
            busy_s: busy_ticks(&read("/proc/stat")).unwrap_or(0.0) / ticks_per_s(),
            dropped_datagrams: receive_buffer_errors(&read("/proc/net/snmp")).unwrap_or(0),
        }
    }
}

/// User, nice, system, interrupts and soft interrupts of all processors; not idle, waiting or stolen time.
fn busy_ticks(stat: &str) -> Option<f64> {
    let line = stat.lines().find_map(|line| line.strip_prefix("cpu "))?;
    let ticks: Vec<f64> = line.split_whitespace().map_while(|field| field.parse().ok()).collect();
    [0, 1, 2, 5, 6].iter().map(|field| ticks.get(*field).copied()).sum()
}

/// The count `RcvbufErrors` of UDP: a line of names, then a line of numbers.
fn receive_buffer_errors(snmp: &str) -> Option<u64> {
    let mut lines = snmp.lines().filter_map(|line| line.strip_prefix("Udp:"));
    let (names, numbers) = (lines.next()?, lines.next()?);
    let mut pairs = names.split_whitespace().zip(numbers.split_whitespace());
    pairs.find(|(name, _)| *name == "RcvbufErrors")?.1.parse().ok()
}

#[cfg(test)]
mod tests;
