//! Something that is due so many times a second. A quarter of a period early is due too: what it waits for comes in periods of its own.
//!
//! Must never do: make up for what was missed.

use std::time::{Duration, Instant};

/// When it is due next.
#[derive(Debug, Clone, Copy)]
pub struct Rate {
    every: Option<Duration>,
    next: Instant,
}

impl Rate {
    /// So many times a second; 0: never.
    #[must_use]
    pub fn new(per_s: f64, now: Instant) -> Self {
        let every = (per_s > 0.0).then(|| Duration::from_secs_f64((1.0 / per_s).min(3_600.0)));
        Self { every, next: now }
    }

    /// Whether it is due now, which makes the next time that of one period later.
    pub fn is_due(&mut self, now: Instant) -> bool {
        let Some(every) = self.every.filter(|every| now + *every / 4 >= self.next) else {
            return false;
        };
        self.next += every;
        if self.next <= now {
            self.next = now + every;
        }
        true
    }
}

#[cfg(test)]
mod tests;
