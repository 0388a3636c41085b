//! The node's clock: tokio's monotonic one, so that a test with paused time pauses the whole node.

use skein_domain::{Clock, NodeTime};
use tokio::time::Instant;

/// Microseconds since it was made, by tokio's clock.
#[derive(Debug, Clone, Copy)]
pub struct TokioClock {
    started: Instant,
}

impl TokioClock {
    /// A clock that starts now.
    #[must_use]
    pub fn start() -> Self {
        Self {
            started: Instant::now(),
        }
    }
}

impl Clock for TokioClock {
    fn now(&self) -> NodeTime {
        NodeTime(u64::try_from(self.started.elapsed().as_micros()).unwrap_or(u64::MAX))
    }
}
