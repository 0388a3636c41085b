//! Where the log lines of an instance arrive: they go on to `tracing` with the instance's name, not too many of them and not too long.
//!
//! Must never do: let a plugin that writes without end fill the node's log.

use parking_lot::Mutex;
use skein_plugin_abi::LogLevel;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use tokio::time::Instant;

/// Lines of one instance that are let through in each [`WINDOW`].
const MAX_LINES_PER_WINDOW: u32 = 100;
/// Over which lines are counted.
const WINDOW: Duration = Duration::from_secs(1);
/// A line is cut at this length in bytes.
const MAX_LINE_BYTES: usize = 2_000;

/// Where log lines go.
pub(crate) trait TakeLog: Send + Sync + std::fmt::Debug {
    /// Takes one line, whatever its bytes are.
    fn take(&self, level: LogLevel, text: &[u8]);
}

/// The sink of one instance.
#[derive(Debug)]
pub(crate) struct LogSink {
    plugin: String,
    instance: String,
    window: Mutex<Window>,
    dropped: AtomicU64,
}

#[derive(Debug)]
struct Window {
    began: Instant,
    lines: u32,
    dropped: u32,
}

impl LogSink {
    pub(crate) fn new(plugin: String, instance: String) -> Self {
        let window = Window {
            began: Instant::now(),
            lines: 0,
            dropped: 0,
        };
        Self {
            plugin,
            instance,
            window: Mutex::new(window),
            dropped: AtomicU64::new(0),
        }
    }

    /// Lines that were not let through so far.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    fn take_at(&self, level: LogLevel, text: &[u8], now: Instant) {
        let (let_through, dropped_before) = self.count(now);
        let Self { plugin, instance, .. } = self;
        if dropped_before > 0 {
            tracing::warn!(target: "plugin", %plugin, %instance, "{dropped_before} log lines were dropped");
        }
        if !let_through {
            return;
        }
        let text = String::from_utf8_lossy(text.get(..MAX_LINE_BYTES).unwrap_or(text));
        match level {
            LogLevel::WARN => tracing::warn!(target: "plugin", %plugin, %instance, "{text}"),
            LogLevel::INFO => tracing::info!(target: "plugin", %plugin, %instance, "{text}"),
            LogLevel::DEBUG => tracing::debug!(target: "plugin", %plugin, %instance, "{text}"),
            LogLevel::TRACE => tracing::trace!(target: "plugin", %plugin, %instance, "{text}"),
            _ => tracing::error!(target: "plugin", %plugin, %instance, "{text}"),
        }
    }

    /// Counts one line: whether it is let through, and how many were not in the window that ended with it.
    fn count(&self, now: Instant) -> (bool, u32) {
        let mut window = self.window.lock();
        let mut dropped_before = 0;
        if now.duration_since(window.began) >= WINDOW {
            dropped_before = window.dropped;
            *window = Window {
                began: now,
                lines: 0,
                dropped: 0,
            };
        }
        if window.lines < MAX_LINES_PER_WINDOW {
            window.lines += 1;
            return (true, dropped_before);
        }
        window.dropped += 1;
        self.dropped.fetch_add(1, Ordering::Relaxed);
        (false, dropped_before)
    }
}

impl TakeLog for LogSink {
    fn take(&self, level: LogLevel, text: &[u8]) {
        self.take_at(level, text, Instant::now());
    }
}

#[cfg(test)]
mod tests;
