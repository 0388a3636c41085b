//! When the machine did not let this process run, so that a referee does not lay to the program what others on the machine did.
//!
//! A thread of its own sleeps in short steps and notes how late it woke. It waits for nothing else: a program that blocks its own control
//! loop wakes it in time and is excused nothing. It runs in the simulator's process, which in the demonstration and in most tests is the
//! node's too; where they are two, it knows of what befell the machine, not of what befell the other process alone.
//!
//! One thread, which may run on any core, and not the delays of the sending threads (`/proc/self/task/*/schedstat`), nor a thread tied to
//! each core. A setpoint goes through several threads whose delays overlap, and their delays say neither whose work they waited for, so
//! that a program that keeps the cores busy itself would be excused, nor that the whole machine was stopped from without. Tied to the
//! cores, threads are late for two thirds of all time on two cores with eight busy programs beside them, while a sender that wakes 50
//! times a second has no gap of 0.1 s: that would hide faults. The one thread is late for a seventh of the time then, and for a fortieth
//! where six threads of the process itself are busy.
//!
//! Must never do: count a time in which it could have run.

use parking_lot::Mutex;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long the probe sleeps at a time.
const STEP: Duration = Duration::from_millis(5);
/// Who wakes no later than this was let run: timers and a fair share of the cores are no better.
pub const LATE: Duration = Duration::from_millis(10);
/// So many stalls are kept one by one. Nobody asks for what lies further back but as part of a sum.
const KEPT: usize = 64;

/// The thread that notes the stalls. Dropping it ends it.
#[derive(Debug)]
pub struct StallProbe {
    stalls: Arc<Mutex<Stalls>>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl StallProbe {
    /// Starts it.
    ///
    /// # Errors
    /// When there can be no further thread.
    pub fn start() -> std::io::Result<Self> {
        let stalls = Arc::new(Mutex::new(Stalls::from(Instant::now())));
        let ends = Arc::new(AtomicBool::new(false));
        let (noted, told) = (stalls.clone(), ends.clone());
        let watch = move || {
            while !told.load(Ordering::Relaxed) {
                std::thread::sleep(STEP);
                let now = Instant::now();
                noted.lock().woke(now);
            }
        };
        let thread = std::thread::Builder::new()
            .name("skein-stalls".to_owned())
            .spawn(watch)?;
        Ok(Self {
            stalls,
            ends,
            thread: Some(thread),
        })
    }

    /// Another thread that waits for nothing but the time was late.
    pub fn add(&self, begin: Instant, end: Instant) {
        self.stalls.lock().add(begin, end);
    }

    /// How long the process had stood still in all at a moment that has passed: the difference of two is what lies between them.
    #[must_use]
    pub fn until(&self, at: Instant) -> Duration {
        let stalls = self.stalls.lock();
        stalls.until(at, Instant::now())
    }

    /// The longest stall that is over.
    #[must_use]
    pub fn longest(&self) -> Duration {
        self.stalls.lock().longest
    }
}

impl Drop for StallProbe {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the thread that notes stalls panicked");
        }
    }
}

/// What has been noted. A clock of its own it has not.
#[derive(Debug)]
struct Stalls {
    /// Begin and end of each, apart from each other and in their order.
    spans: VecDeque<(Instant, Instant)>,
    /// How long those lasted that are not kept.
    before: Duration,
    longest: Duration,
    /// When the probe last woke.
    woke: Instant,
}

impl Stalls {
    fn from(now: Instant) -> Self {
        Self {
            spans: VecDeque::new(),
            before: Duration::ZERO,
            longest: Duration::ZERO,
            woke: now,
        }
    }

    /// The probe woke.
    fn woke(&mut self, now: Instant) {
        if let Some(due) = self.stalls_since(now) {
            self.add(due, now);
        }
        self.woke = now;
    }

    /// When the probe should have woken that has not, and is late for it.
    fn stalls_since(&self, now: Instant) -> Option<Instant> {
        let due = self.woke + STEP;
        (now.saturating_duration_since(due) > LATE).then_some(due)
    }

    /// Several threads may tell of one stall, each of its part: together they make one.
    fn add(&mut self, mut begin: Instant, mut end: Instant) {
        self.spans.retain(|&(from, to)| {
            let apart = to < begin || from > end;
            if !apart {
                (begin, end) = (begin.min(from), end.max(to));
            }
            apart
        });
        let place = self.spans.partition_point(|&(from, _)| from < begin);
        self.spans.insert(place, (begin, end));
        self.longest = self.longest.max(end.saturating_duration_since(begin));
        if self.spans.len() > KEPT
            && let Some((from, to)) = self.spans.pop_front()
        {
            self.before += to - from;
        }
    }

    /// The time stalled until `at`. A stall that lasts still counts too: whoever woke before the probe must know why it heard nothing.
    fn until(&self, at: Instant, now: Instant) -> Duration {
        let known = self.stalls_since(now).map_or(at, |since| since.min(at));
        let part = |&(from, to): &(Instant, Instant)| to.min(known).saturating_duration_since(from);
        self.before + self.spans.iter().map(part).sum::<Duration>() + (at - known)
    }
}

#[cfg(test)]
mod tests;
