//! The thread that looks at pictures: the newest one that waits, one after another.
//!
//! Must never do: keep whoever brings a picture waiting, let more than one wait, or outlive its detector for longer than one look.

use crate::eye::{Eye, Look};
use parking_lot::{Condvar, Mutex};
use skein_domain::payload::FrameHeader;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A frame with a copy of its bytes.
#[derive(Debug, Default)]
pub(crate) struct Job {
    pub(crate) header: FrameHeader,
    pub(crate) bytes: Vec<u8>,
}

#[derive(Debug, Default)]
struct State {
    waiting: Option<Job>,
    /// A buffer to be used again.
    spare: Vec<u8>,
    looks: Vec<Look>,
    /// Since when a picture is being looked at.
    begun: Option<Instant>,
    dropped: u64,
    closed: bool,
    broken: Option<String>,
}

/// The thread from the side of who brings pictures.
#[derive(Debug)]
pub(crate) struct Worker(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    brought: Condvar,
}

/// Most looks that wait to be taken: who does not take them is not waited for.
const MOST_LOOKS: usize = 8;

impl Worker {
    pub(crate) fn start(mut eye: Eye) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let of_thread = shared.clone();
        std::thread::Builder::new().name("detector".to_owned()).spawn(move || {
            let looking = std::panic::AssertUnwindSafe(|| run(&of_thread, &mut eye));
            if let Err(panic) = std::panic::catch_unwind(looking) {
                let text = panic.downcast_ref::<String>().cloned();
                let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
                of_thread.state.lock().broken = Some(text.unwrap_or_else(|| "it ended".to_owned()));
            }
        })?;
        Ok(Self(shared))
    }

    /// Brings a picture; one that still waits is dropped for it.
    pub(crate) fn bring(&self, header: &FrameHeader, bytes: &[u8]) {
        let mut state = self.0.state.lock();
        let mut job = match state.waiting.take() {
            Some(late) => {
                state.dropped += 1;
                late
            }
            None => Job {
                header: FrameHeader::default(),
                bytes: std::mem::take(&mut state.spare),
            },
        };
        job.header.clone_from(header);
        job.bytes.clear();
        job.bytes.extend_from_slice(bytes);
        state.waiting = Some(job);
        drop(state);
        self.0.brought.notify_one();
    }

    /// What was seen since it was last asked, oldest first.
    pub(crate) fn take(&self) -> Vec<Look> {
        std::mem::take(&mut self.0.state.lock().looks)
    }

    /// Pictures that were not looked at.
    pub(crate) fn dropped(&self) -> u64 {
        self.0.state.lock().dropped
    }

    /// For how long one picture has been looked at by now.
    pub(crate) fn busy_for(&self) -> Duration {
        self.0
            .state
            .lock()
            .begun
            .map(|begun| begun.elapsed())
            .unwrap_or_default()
    }

    /// Why the thread has ended, if it has.
    pub(crate) fn broken(&self) -> Option<String> {
        self.0.state.lock().broken.clone()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.0.state.lock().closed = true;
        self.0.brought.notify_one();
    }
}

fn run(shared: &Shared, eye: &mut Eye) {
    loop {
        let mut state = shared.state.lock();
        let job = loop {
            if state.closed {
                return;
            }
            match state.waiting.take() {
                Some(job) => break job,
                None => shared.brought.wait(&mut state),
            }
        };
        let begun = Instant::now();
        state.begun = Some(begun);
        drop(state);
        let mut look = eye.look(&job.header, &job.bytes);
        look.took_s = begun.elapsed().as_secs_f64();
        let mut state = shared.state.lock();
        state.begun = None;
        state.spare = job.bytes;
        if state.looks.len() >= MOST_LOOKS {
            state.looks.remove(0);
        }
        state.looks.push(look);
    }
}
