//! Real-time priority: the threads that setpoints wait for run before everything ordinary on the computer, where the system permits it.
//!
//! Nobody inherits it: a thread or process that is started by one of these is an ordinary one, until it asks itself. A program that does not
//! say so (tests, tools) has none. Where it is not permitted, all goes on as before, and `skein doctor` says so.
//!
//! Must never do: fail a caller, or put a thread ahead that plugins, files or clients can hold for long without somebody who watches it.

use std::io;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Whether this program wants it.
static WANTED: AtomicBool = AtomicBool::new(false);
/// Whether it was told already that it is not permitted.
static TOLD: AtomicBool = AtomicBool::new(false);

/// Who goes first among the threads that are ahead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precedence {
    /// Actors, links and the simulator.
    Control,
    /// Calls of plugins, which setpoints wait for too; one that spins must not keep the others from giving it up.
    Plugin,
}

impl Precedence {
    /// Above all that is ordinary, below the system's own threads (50).
    fn priority(self) -> i32 {
        match self {
            Self::Control => 10,
            Self::Plugin => 5,
        }
    }
}

/// This program flies: its threads that ask are put ahead.
pub fn want() {
    WANTED.store(true, Ordering::Relaxed);
}

/// Puts the calling thread ahead of ordinary ones, if the program wants that and the system permits it.
pub fn ask(precedence: Precedence) {
    ask_for(0, precedence);
}

/// The same of another thread, or of a process' first one, by its id.
pub fn ask_for(thread: i32, precedence: Precedence) {
    if !WANTED.load(Ordering::Relaxed) {
        return;
    }
    if let Err(error) = set(thread, libc::SCHED_RR, precedence.priority())
        && !TOLD.swap(true, Ordering::Relaxed)
    {
        tracing::info!(
            "no real-time priority: {error}; under load setpoints may be late (`skein doctor` says how to permit it)"
        );
    }
}

/// What a runtime's hook for new threads is to do: the first of them, which run actors, are put ahead; those that come later do what blocks.
pub fn ask_on_start_of(actors: usize) -> impl Fn() + Send + Sync + 'static {
    let started = AtomicUsize::new(0);
    move || {
        if started.fetch_add(1, Ordering::Relaxed) < actors {
            ask(Precedence::Control);
        }
    }
}

/// From now on this thread runs only when nobody else wants to.
///
/// # Errors
/// When there is no such thread.
pub fn put_behind_all(thread: i32) -> io::Result<()> {
    set(thread, libc::SCHED_IDLE, 0)
}

/// Whether the system permits it.
///
/// # Errors
/// The reason why not.
pub fn is_permitted() -> io::Result<()> {
    let tried = std::thread::spawn(|| set(0, libc::SCHED_RR, Precedence::Control.priority()));
    tried
        .join()
        .unwrap_or_else(|_| Err(io::Error::other("a thread of its own ended")))
}

fn set(thread: i32, policy: i32, priority: i32) -> io::Result<()> {
    let parameters = libc::sched_param {
        sched_priority: priority,
    };
    // SAFETY: the parameters live as long as the call, which writes nothing; an id that is no thread's is an error.
    let done = unsafe { libc::sched_setscheduler(thread, policy | libc::SCHED_RESET_ON_FORK, &raw const parameters) };
    if done == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}

#[cfg(test)]
mod tests {
    //! On the real system; where it permits nothing, nothing must change.

    use super::*;

    /// Policy of the calling thread, without the mark that nobody inherits it.
    fn policy() -> i32 {
        // SAFETY: 0 is the calling thread.
        unsafe { libc::sched_getscheduler(0) & !libc::SCHED_RESET_ON_FORK }
    }

    fn in_thread<T: Send + 'static>(body: impl FnOnce() -> T + Send + 'static) -> T {
        std::thread::spawn(body).join().expect("the thread")
    }

    #[test]
    fn only_who_asks_in_a_program_that_wants_it_is_ahead_and_nobody_inherits_it() {
        assert_eq!(in_thread(|| (ask(Precedence::Control), policy()).1), libc::SCHED_OTHER);
        want();
        let ahead = if is_permitted().is_ok() {
            libc::SCHED_RR
        } else {
            libc::SCHED_OTHER
        };
        let (own, of_child) = in_thread(|| {
            ask(Precedence::Plugin);
            (policy(), in_thread(policy))
        });
        assert_eq!((own, of_child), (ahead, libc::SCHED_OTHER));
        let hook = std::sync::Arc::new(ask_on_start_of(1));
        let again = hook.clone();
        assert_eq!(in_thread(move || (hook(), policy()).1), ahead);
        assert_eq!(in_thread(move || (again(), policy()).1), libc::SCHED_OTHER);
    }

    #[test]
    fn a_thread_is_put_behind_all_and_only_that_thread() {
        assert_eq!(
            in_thread(|| (put_behind_all(0).is_ok(), policy())),
            (true, libc::SCHED_IDLE)
        );
        assert_eq!(policy(), libc::SCHED_OTHER);
        assert!(put_behind_all(i32::MAX).is_err());
    }
}
