//! The moment that is shown, as the clock of the node that shows it.
//!
//! Must never do: go on by itself.

use skein_domain::{Clock, NodeTime};
use std::sync::atomic::{AtomicU64, Ordering};

/// The moment that is shown.
#[derive(Debug, Default)]
pub struct Position(AtomicU64);

impl Position {
    /// Another moment is shown from now on.
    pub fn set(&self, at: NodeTime) {
        self.0.store(at.0, Ordering::Release);
    }
}

impl Clock for Position {
    fn now(&self) -> NodeTime {
        NodeTime(self.0.load(Ordering::Acquire))
    }
}
