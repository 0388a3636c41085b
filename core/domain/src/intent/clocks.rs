//! The same intent as told by another node's clock. Every moment in it is moved by the same amount.
//!
//! Must never do: change anything but moments.

use super::{AnchorPlan, AnchorReference, Intent, Keeping, SlotMove, Task, Trajectory};

impl Intent {
    /// Puts it on a clock that is ahead by so many microseconds.
    pub fn put_on_clock_ahead_by(&mut self, ahead_us: i64) {
        for task in self.tasks.values_mut() {
            task.task.put_on_clock_ahead_by(ahead_us);
        }
        if let Some(anchor) = &mut self.anchor {
            anchor.put_on_clock_ahead_by(ahead_us);
        }
    }
}

impl AnchorPlan {
    /// Puts it on a clock that is ahead by so many microseconds.
    pub fn put_on_clock_ahead_by(&mut self, ahead_us: i64) {
        match self {
            Self::Path { start, .. } => *start = start.on_clock_ahead_by(ahead_us),
            Self::Reference { .. } | Self::Place { .. } => {}
        }
    }
}

impl Task {
    /// Puts it on a clock that is ahead by so many microseconds.
    pub fn put_on_clock_ahead_by(&mut self, ahead_us: i64) {
        match self {
            Self::Follow { slot, .. } => slot.put_on_clock_ahead_by(ahead_us),
            Self::Keep(keeping) => keeping.put_on_clock_ahead_by(ahead_us),
            Self::Fly(trajectory) => trajectory.put_on_clock_ahead_by(ahead_us),
            Self::Lead { .. } | Self::Hold => {}
        }
    }
}

impl SlotMove {
    /// Puts it on a clock that is ahead by so many microseconds.
    pub fn put_on_clock_ahead_by(&mut self, ahead_us: i64) {
        self.start = self.start.on_clock_ahead_by(ahead_us);
    }
}

impl Keeping {
    /// Puts it on a clock that is ahead by so many microseconds.
    pub fn put_on_clock_ahead_by(&mut self, ahead_us: i64) {
        self.start = self.start.on_clock_ahead_by(ahead_us);
    }
}

impl Trajectory {
    /// Puts it on a clock that is ahead by so many microseconds.
    pub fn put_on_clock_ahead_by(&mut self, ahead_us: i64) {
        self.start = self.start.on_clock_ahead_by(ahead_us);
    }
}

impl AnchorReference {
    /// Puts it on a clock that is ahead by so many microseconds.
    pub fn put_on_clock_ahead_by(&mut self, ahead_us: i64) {
        self.time = self.time.on_clock_ahead_by(ahead_us);
    }
}

#[cfg(test)]
mod tests;
