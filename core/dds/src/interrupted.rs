//! The C library's `epoll_wait` for the whole process, without the error that it ends with when the process was stopped and goes on.
//!
//! Must never do: keep from a caller any other error, or an event.
//!
//! A process that is stopped (a container that is paused, a laptop that sleeps, Ctrl-Z, a debugger) has its waiting calls ended with `EINTR`
//! (signal(7), "Interruption of system calls and library functions by stop signals"). RustDDS 0.15.1 takes that for the end: its two threads
//! return, and the participant is deaf and dumb for as long as the process lives, without a word (`dp_event_loop.rs`, `discovery.rs`).
//! mio, through which it waits, asks the C library, and a program's own function of that name comes before the library's.
#![expect(
    unsafe_code,
    reason = "no other way into a library's loop; it goes when RustDDS tries again itself"
)]

use libc::{c_int, epoll_event};

/// Waits as epoll_wait(2) does. When it is interrupted it tells of no event, as it may at any time when it is waited for a limited time.
///
/// # Safety
/// As for epoll_wait(2): room for `most` events at `events`.
// SAFETY: the name is the C library's, and this does what that does
#[unsafe(no_mangle)]
unsafe extern "C" fn epoll_wait(epoll: c_int, events: *mut epoll_event, most: c_int, timeout_ms: c_int) -> c_int {
    loop {
        // SAFETY: the caller has promised what this asks for; without a set of signals it is the same call
        let told = unsafe { libc::epoll_pwait(epoll, events, most, timeout_ms, std::ptr::null()) };
        let interrupted = told < 0 && std::io::Error::last_os_error().kind() == std::io::ErrorKind::Interrupted;
        match (interrupted, timeout_ms) {
            (false, _) => return told,
            // who waits without a limit does not expect to wake for nothing
            (true, ..0) => {}
            (true, _) => return 0,
        }
    }
}
