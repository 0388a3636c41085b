//! Bounds of everything that instances of plugins do.
//!
//! Must never do: leave something without a bound.

use std::time::Duration;

/// Bounds of everything that instances do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunnerSettings {
    /// Threads that make calls, at least one. A handful serves hundreds of instances.
    pub threads: usize,
    /// A call that has not returned after this time is given up, with its instance and its thread. It is noticed up to a quarter
    /// later.
    pub call_deadline: Duration,
    /// The same for the creation and the end of an instance, which may have files to read.
    pub create_deadline: Duration,
    /// Longest answer to an event batch in bytes.
    pub max_answer_bytes: usize,
    /// Longest snapshot in bytes.
    pub max_snapshot_bytes: usize,
    /// Most effects of one batch.
    pub max_effects: u64,
    /// A plugin in which so many threads hang gets no more.
    pub max_hanging_threads: u32,
}

impl Default for RunnerSettings {
    fn default() -> Self {
        Self {
            threads: 2,
            call_deadline: Duration::from_millis(50),
            create_deadline: Duration::from_secs(1),
            max_answer_bytes: 64 << 10,
            max_snapshot_bytes: 256 << 10,
            max_effects: 200,
            max_hanging_threads: 8,
        }
    }
}
