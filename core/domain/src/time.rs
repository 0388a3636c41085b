//! Node time: microseconds on this node's monotonic clock since the node started. It is passed in, never read here.

use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// A moment on the node's monotonic clock, in microseconds since the node started; of a node in a swarm, since long before, so that it can
/// tell of what others did before it was there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(transparent)]
#[cbor(transparent)]
pub struct NodeTime(
    #[n(0)]
    #[schemars(range(max = 9_007_199_254_740_991_u64))]
    pub u64,
);

impl NodeTime {
    /// A moment `seconds` after the node started.
    #[must_use]
    pub fn from_seconds(seconds: f64) -> Self {
        Self((seconds.max(0.0) * 1e6).round() as u64)
    }

    /// Seconds since the node started.
    #[must_use]
    pub fn as_seconds(self) -> f64 {
        self.0 as f64 * 1e-6
    }

    /// Seconds from `earlier` to this moment; negative if `earlier` is later.
    #[must_use]
    pub fn seconds_since(self, earlier: Self) -> f64 {
        (self.0 as i128 - i128::from(earlier.0)) as f64 * 1e-6
    }

    /// The same moment on a clock that is ahead of this one by so many microseconds, not below zero.
    #[must_use]
    pub fn on_clock_ahead_by(self, ahead_us: i64) -> Self {
        Self(self.0.saturating_add_signed(ahead_us))
    }

    /// This moment moved by `seconds`, not below zero.
    #[must_use]
    pub fn plus_seconds(self, seconds: f64) -> Self {
        let moved = self.0 as i128 + (seconds * 1e6).round() as i128;
        Self(moved.clamp(0, i128::from(u64::MAX)) as u64)
    }
}

/// A source of node time. The node's is tokio's clock, which tests can pause; pure code is given a [`NodeTime`] instead.
pub trait Clock: Send + Sync + 'static {
    /// Now.
    fn now(&self) -> NodeTime;
}
