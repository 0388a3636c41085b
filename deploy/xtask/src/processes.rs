//! Processes of this machine as the kernel tells them: who was started by whom, and how all of them are ended.
//!
//! Must never do: end a process that no child of ours has started.

#[cfg(test)]
mod tests;

use nix::sys::signal::{Signal, kill, killpg};
use nix::unistd::Pid;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// One process that is not over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Process {
    /// Its id.
    pub pid: i32,
    /// Its name, of which the kernel keeps fifteen letters.
    pub name: String,
    parent: i32,
    group: i32,
}

impl std::fmt::Display for Process {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({})", self.name, self.pid)
    }
}

/// Everything that this process and its children have started: what descends from it, and what is in a group that one of them leads.
pub fn below(root: u32) -> Vec<Process> {
    let all = running();
    let mut known: BTreeSet<i32> = i32::try_from(root).into_iter().collect();
    loop {
        let new: Vec<i32> = all
            .iter()
            .filter(|process| !known.contains(&process.pid))
            .filter(|process| known.contains(&process.parent) || known.contains(&process.group))
            .map(|process| process.pid)
            .collect();
        if new.is_empty() {
            break;
        }
        known.extend(new);
    }
    let is_below = |process: &Process| known.contains(&process.pid) && i32::try_from(root) != Ok(process.pid);
    all.into_iter().filter(is_below).collect()
}

/// Ends a process whose group is its own, with everything below it, also what starts while this goes on.
pub fn end(root: u32) {
    let Ok(leader) = i32::try_from(root) else { return };
    // who is gone by now needs no signal
    let _ = killpg(Pid::from_raw(leader), Signal::SIGKILL);
    end_below(root);
}

/// Ends everything below this one, also what starts while this goes on.
pub fn end_below(root: u32) {
    for _ in 0..MOST_ROUNDS {
        let left = below(root);
        if left.is_empty() {
            break;
        }
        for process in &left {
            let _ = kill(Pid::from_raw(process.pid), Signal::SIGKILL);
        }
        std::thread::sleep(ROUND);
    }
}

const MOST_ROUNDS: usize = 100;
const ROUND: Duration = Duration::from_millis(20);

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Whether the run is being ended. Whoever starts something then would leave it behind.
pub fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}

/// Does not come back where the run is being ended: that ends this process, when everything else has been put away.
pub fn wait_if_interrupted() {
    while is_interrupted() {
        std::thread::park();
    }
}

/// From now on, SIGINT (Ctrl-C), SIGTERM and SIGHUP end what was started, before they end this process.
pub fn end_all_when_interrupted(and_then: impl FnOnce() + Send + 'static) {
    let mut signals = match Signals::new([SIGINT, SIGTERM, SIGHUP]) {
        Ok(signals) => signals,
        Err(error) => {
            eprintln!("xtask: when it is interrupted, what it has started goes on: {error}");
            return;
        }
    };
    std::thread::spawn(move || {
        let Some(signal) = signals.forever().next() else { return };
        eprintln!("\nxtask: interrupted: ending what was started");
        INTERRUPTED.store(true, Ordering::SeqCst);
        end_below(std::process::id());
        and_then();
        #[expect(
            clippy::disallowed_methods,
            reason = "nothing is left to be dropped, and main waits for this"
        )]
        std::process::exit(128 + signal);
    });
}

/// Every process that is not a zombie.
fn running() -> Vec<Process> {
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
    pids.filter_map(|pid| read(pid, &std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?))
        .collect()
}

/// A line of `/proc/PID/stat` (proc(5)): id, name in brackets, which may hold anything, state, parent, group.
fn read(pid: i32, stat: &str) -> Option<Process> {
    let (before, after) = stat.rsplit_once(')')?;
    let (_, name) = before.split_once('(')?;
    let mut fields = after.split_whitespace();
    let state = fields.next()?;
    let mut number = || fields.next()?.parse().ok();
    let (parent, group) = (number()?, number()?);
    (state != "Z" && state != "X").then(|| Process {
        pid,
        name: name.to_owned(),
        parent,
        group,
    })
}
