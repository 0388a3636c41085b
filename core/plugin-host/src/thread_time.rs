//! A thread seen from outside: how long it had to wait for a processor, and how to put it behind all others.
//!
//! Must never do: fail a caller. Where the system does not tell, there is nothing to take into account.

use rustix::thread::Pid;
use std::time::Duration;

/// A thread of this process.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ThreadTime(Pid);

impl ThreadTime {
    /// The calling thread.
    pub(crate) fn of_this_thread() -> Self {
        Self(rustix::thread::gettid())
    }

    /// How long it has been ready to run without running, in all its life.
    pub(crate) fn starved(self) -> Option<Duration> {
        starved_of(&format!("/proc/self/task/{}", self.0.as_raw_nonzero()))
    }

    /// From now on it runs only when nobody else wants to.
    pub(crate) fn yield_to_all(self) {
        if let Err(error) = skein_realtime::put_behind_all(self.0.as_raw_nonzero().get()) {
            tracing::debug!(target: "plugin", "the priority of a thread that hangs stays as it is: {error}");
        }
    }
}

/// How long the thread of this directory of `/proc` has been ready to run without running; of a process's directory, its first thread.
pub(crate) fn starved_of(directory: &str) -> Option<Duration> {
    // Time on a processor, time in the queue for one, number of turns; nanoseconds.
    let text = std::fs::read_to_string(format!("{directory}/schedstat")).ok()?;
    text.split_ascii_whitespace()
        .nth(1)?
        .parse()
        .ok()
        .map(Duration::from_nanos)
}

#[cfg(test)]
mod tests;
