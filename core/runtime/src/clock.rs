//! The node's clock: tokio's monotonic one, so that a test with paused time pauses the whole node.

use skein_domain::{Clock, NodeTime};
use tokio::time::Instant;

/// Microseconds since it was made, by tokio's clock.
#[derive(Debug, Clone, Copy)]
pub struct TokioClock {
    started: Instant,
    began_us: u64,
}

impl TokioClock {
    /// A clock that starts now.
    #[must_use]
    pub fn start() -> Self {
        Self::start_at(NodeTime::default())
    }

    /// A clock that starts now and calls this moment so.
    #[must_use]
    pub fn start_at(now: NodeTime) -> Self {
        Self {
            started: Instant::now(),
            began_us: now.0,
        }
    }
}

impl Clock for TokioClock {
    fn now(&self) -> NodeTime {
        let since_us = u64::try_from(self.started.elapsed().as_micros()).unwrap_or(u64::MAX);
        NodeTime(self.began_us.saturating_add(since_us))
    }
}
