//! A child process as this one sees it: started, watched, ended and buried.
//!
//! Must never do: leave a process behind, or its remains.

use super::wire::wait;
use crate::PluginError;
use crate::thread_time::starved_of;
use rustix::event::PollFlags;
use rustix::io::Errno;
use rustix::net::{AddressFamily, SocketFlags, SocketType};
use rustix::pipe::PipeFlags;
use rustix::process::{Pid, PidfdFlags};
use skein_realtime::Precedence;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What is kept of what a child wrote to its standard error, in bytes.
const TAIL_BYTES: usize = 4 << 10;
/// The last words in an error are cut at this length in bytes.
const MAX_SAID_BYTES: usize = 300;
/// How long a process whose socket is closed may take to be gone before it is helped along.
const DYING: Duration = Duration::from_millis(100);
/// Variables of the environment that a child keeps: where the system finds shared libraries.
const KEPT_VARIABLES: [&str; 1] = ["LD_LIBRARY_PATH"];

/// A child process. Dropped, it is ended.
#[derive(Debug)]
pub(crate) struct ChildProcess {
    pid: u32,
    child: parking_lot::Mutex<Child>,
    ended: AtomicBool,
}

/// What a child was started with on this side.
#[derive(Debug)]
pub(crate) struct Started {
    pub(crate) process: ChildProcess,
    pub(crate) socket: OwnedFd,
    pub(crate) errors: ErrorTail,
}

impl ChildProcess {
    /// Starts the program as the host of one instance, without our environment and in a process group of its own: a Ctrl-C at the
    /// terminal is not for it. The calling thread must live as long as the child is to.
    pub(crate) fn start(program: &Path) -> std::io::Result<Started> {
        let (ours, theirs) = socket_pair(SocketType::STREAM)?;
        let (read, write) = rustix::pipe::pipe_with(PipeFlags::CLOEXEC)?;
        rustix::fs::fcntl_setfl(&read, rustix::fs::OFlags::NONBLOCK)?;
        let kept = KEPT_VARIABLES
            .iter()
            .filter_map(|name| Some((name, std::env::var_os(name)?)));
        let child = Command::new(program)
            .arg("plugin-host")
            .env_clear()
            .envs(kept)
            .current_dir("/")
            .process_group(0)
            .stdin(theirs)
            .stdout(write.try_clone()?)
            .stderr(write)
            .spawn()?;
        let process = Self {
            pid: child.id(),
            child: parking_lot::Mutex::new(child),
            ended: AtomicBool::new(false),
        };
        let errors = ErrorTail {
            pipe: read,
            tail: Vec::new(),
        };
        Ok(Started {
            process,
            socket: ours,
            errors,
        })
    }

    /// Puts the thread ahead that makes its calls; those that a plugin starts are ordinary ones.
    pub(crate) fn ask_to_be_ahead(&self) {
        skein_realtime::ask_for(self.pid.cast_signed(), Precedence::Plugin);
    }

    /// Its id, while it is there.
    pub(crate) fn pid(&self) -> Option<u32> {
        (!self.ended.load(Ordering::Relaxed)).then_some(self.pid)
    }

    /// Ends it at once. Tells whether it was there.
    pub(crate) fn kill(&self) -> bool {
        let mut child = self.child.lock();
        // One that was buried is not killed again: its id may be another's by now.
        !self.ended.load(Ordering::Relaxed) && child.kill().is_ok()
    }

    /// Whether it has ended by itself; it is buried then.
    pub(crate) fn has_ended(&self) -> Option<ExitStatus> {
        let status = self.child.lock().try_wait().ok().flatten()?;
        self.ended.store(true, Ordering::Relaxed);
        Some(status)
    }

    /// Waits for an end that has begun, helps it along if it takes too long, and buries it.
    pub(crate) fn bury(&self, patience: Duration) -> std::io::Result<ExitStatus> {
        if !patience.is_zero() {
            // Should the system not let us wait, it is ended at once.
            let _ = self.wait_for_end(patience);
        }
        if let Some(status) = self.has_ended() {
            return Ok(status);
        }
        let mut child = self.child.lock();
        child.kill()?;
        let status = child.wait()?;
        self.ended.store(true, Ordering::Relaxed);
        Ok(status)
    }

    /// Sleeps until it has ended; at the end of this time that is an error.
    fn wait_for_end(&self, patience: Duration) -> std::io::Result<()> {
        let until = Instant::now() + patience;
        let pid = Pid::from_child(&self.child.lock());
        let process = rustix::process::pidfd_open(pid, PidfdFlags::empty())?;
        while self.has_ended().is_none() {
            wait(&[process.as_fd()], PollFlags::IN, Some(until))?;
        }
        Ok(())
    }

    /// How it ended, after its socket was closed.
    pub(crate) fn end(&self, errors: &mut ErrorTail) -> PluginError {
        let how = match self.bury(DYING) {
            Ok(status) => describe(status),
            Err(error) => format!("nobody knows how: {error}"),
        };
        errors.drain(|_| {});
        PluginError::ProcessEnded {
            how,
            said: errors.last_words(),
        }
    }

    /// Processor time it has used so far, in seconds.
    pub(crate) fn processor_s(&self) -> Option<f64> {
        let pid = self.pid()?;
        let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        // The name in brackets may hold anything.
        let mut fields = text.rsplit(')').next()?.split_ascii_whitespace().skip(11);
        let mut ticks = || fields.next()?.parse::<f64>().ok();
        Some((ticks()? + ticks()?) / rustix::param::clock_ticks_per_second() as f64)
    }

    /// How long its first thread has been ready to run without running, in all its life.
    pub(crate) fn starved(&self) -> Option<Duration> {
        starved_of(&format!("/proc/{}", self.pid()?))
    }
}

impl Drop for ChildProcess {
    fn drop(&mut self) {
        if self.pid().is_some()
            && let Err(error) = self.bury(Duration::ZERO)
        {
            tracing::error!(target: "plugin", "process {} was not ended: {error}", self.pid);
        }
    }
}

/// Two connected sockets that no other program inherits.
pub(crate) fn socket_pair(kind: SocketType) -> rustix::io::Result<(OwnedFd, OwnedFd)> {
    rustix::net::socketpair(AddressFamily::UNIX, kind, SocketFlags::CLOEXEC, None)
}

/// The end of what a child wrote to its standard error.
#[derive(Debug)]
pub(crate) struct ErrorTail {
    pipe: OwnedFd,
    tail: Vec<u8>,
}

impl ErrorTail {
    pub(crate) fn file(&self) -> BorrowedFd<'_> {
        self.pipe.as_fd()
    }

    /// Takes what is there, not more than a bearable amount; shows it to `see` as it comes. Tells whether there may be more one day.
    pub(crate) fn drain(&mut self, mut see: impl FnMut(&[u8])) -> bool {
        let mut chunk = [0; TAIL_BYTES];
        for _ in 0..16 {
            match rustix::io::read(&self.pipe, &mut chunk) {
                Ok(0) => return false,
                Ok(len) => {
                    let new = chunk.get(..len).unwrap_or_default();
                    see(new);
                    self.tail.extend_from_slice(new);
                    let excess = self.tail.len().saturating_sub(TAIL_BYTES);
                    self.tail.drain(..excess);
                }
                Err(Errno::INTR) => {}
                Err(_) => return true,
            }
        }
        true
    }

    /// The last line that says something; the hint of how to get a backtrace does not.
    fn last_words(&self) -> String {
        let text = String::from_utf8_lossy(&self.tail);
        let line = text
            .lines()
            .map(str::trim)
            .rfind(|line| !line.is_empty() && !line.starts_with("note: "))
            .unwrap_or_default();
        line.get(..line.floor_char_boundary(MAX_SAID_BYTES))
            .unwrap_or_default()
            .to_owned()
    }
}

/// How a process ended, in words.
fn describe(status: ExitStatus) -> String {
    if let Some(signal) = status.signal() {
        let name = match signal {
            4 => " (SIGILL)",
            6 => " (SIGABRT)",
            7 => " (SIGBUS)",
            8 => " (SIGFPE)",
            9 => " (SIGKILL)",
            11 => " (SIGSEGV)",
            13 => " (SIGPIPE)",
            15 => " (SIGTERM)",
            31 => " (SIGSYS)",
            _ => "",
        };
        return format!("killed by signal {signal}{name}");
    }
    status
        .code()
        .map_or_else(|| "nobody knows how".to_owned(), |code| format!("exit code {code}"))
}

#[cfg(test)]
mod tests;
