//! How much of a core a child takes, over the last ten seconds.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Over which time the share is taken.
pub(crate) const WINDOW: Duration = Duration::from_secs(10);
/// How often it is looked at.
pub(crate) const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Looks at processor times and judges them.
#[derive(Debug)]
pub(crate) struct ShareWatch {
    limit: f64,
    /// When it was looked, and the processor time used by then in seconds.
    looks: VecDeque<(Instant, f64)>,
}

impl ShareWatch {
    pub(crate) fn new(limit: f64) -> Self {
        Self {
            limit,
            looks: VecDeque::new(),
        }
    }

    /// Whether it is time to look.
    pub(crate) fn is_due(&self, now: Instant) -> bool {
        self.looks
            .back()
            .is_none_or(|(last, _)| now.duration_since(*last) >= LOOK_EVERY)
    }

    /// Takes a look; gives the share if it is over the limit. A whole window must have been seen.
    pub(crate) fn look(&mut self, now: Instant, processor_s: f64) -> Option<f64> {
        self.looks.push_back((now, processor_s));
        // The newest of those that are a window old is the one to compare with.
        while self
            .looks
            .get(1)
            .is_some_and(|(at, _)| now.duration_since(*at) >= WINDOW)
        {
            self.looks.pop_front();
        }
        let (since, before_s) = *self.looks.front()?;
        let over = now.duration_since(since);
        if over < WINDOW {
            return None;
        }
        let share = (processor_s - before_s) / over.as_secs_f64();
        (share > self.limit).then_some(share)
    }
}

#[cfg(test)]
mod tests;
