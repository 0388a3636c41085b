//! Bytes per second as a budget: who may send now, and what has been used.
//!
//! Must never do: let bulk take what a more urgent class may need next; refuse a command for what was spent on others.

use crate::transport::{CLASSES, Class};
use serde::{Deserialize, Serialize};
use skein_domain::NodeTime;

/// What a node may send.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetSettings {
    /// In the long run, in bytes per second.
    pub bytes_per_s: f64,
    /// At once after a pause, in bytes: several datagrams.
    pub burst_bytes: f64,
}

impl Default for BudgetSettings {
    /// A good WLAN.
    fn default() -> Self {
        Self {
            bytes_per_s: 1_000_000.0,
            burst_bytes: 64_000.0,
        }
    }
}

/// The share of the burst that video and bulk leave to the others.
const BULK_LEAVES: f64 = 0.5;

/// A bucket of tokens, one per byte. Commands may overdraw it by one burst; what comes after pays.
#[derive(Debug, Clone)]
pub struct Budget {
    settings: BudgetSettings,
    tokens_bytes: f64,
    at: NodeTime,
}

impl Budget {
    /// A full bucket.
    #[must_use]
    pub fn new(settings: BudgetSettings, now: NodeTime) -> Self {
        Self {
            settings,
            tokens_bytes: settings.burst_bytes,
            at: now,
        }
    }

    /// Changes the rate from now on.
    pub fn set_bytes_per_s(&mut self, now: NodeTime, bytes_per_s: f64) {
        self.refill(now);
        self.settings.bytes_per_s = bytes_per_s;
    }

    /// The present rate.
    #[must_use]
    pub fn bytes_per_s(&self) -> f64 {
        self.settings.bytes_per_s
    }

    /// Whether a datagram of this class and size may be sent now.
    pub fn allows(&mut self, now: NodeTime, class: Class, bytes: usize) -> bool {
        self.refill(now);
        self.tokens_bytes - self.floor_bytes(class) >= bytes as f64
    }

    /// Takes the bytes of something that was sent.
    pub fn spend(&mut self, now: NodeTime, bytes: usize) {
        self.refill(now);
        self.tokens_bytes -= bytes as f64;
    }

    /// What must be left after a datagram of this class.
    fn floor_bytes(&self, class: Class) -> f64 {
        match class {
            Class::Command => -self.settings.burst_bytes,
            Class::State | Class::Query => 0.0,
            Class::Video | Class::Bulk => self.settings.burst_bytes * BULK_LEAVES,
        }
    }

    fn refill(&mut self, now: NodeTime) {
        let since_s = now.seconds_since(self.at).max(0.0);
        let full = self.tokens_bytes + since_s * self.settings.bytes_per_s;
        self.tokens_bytes = full.min(self.settings.burst_bytes);
        self.at = self.at.max(now);
    }
}

/// What went over a link in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Traffic {
    /// Datagrams of each class, in the order of [`CLASSES`].
    pub datagrams: [u64; CLASSES.len()],
    /// Bytes of each class as the transport was given them, seal included, its own headers not.
    pub bytes: [u64; CLASSES.len()],
    /// Bytes per second of late: a mean that forgets with a time constant of [`MEAN_OVER_S`].
    pub bytes_per_s: f64,
    at: NodeTime,
}

/// Time constant of the mean rate, in seconds.
pub const MEAN_OVER_S: f64 = 2.0;

impl Traffic {
    /// Counts a datagram.
    pub fn count(&mut self, now: NodeTime, class: Class, bytes: usize) {
        let place = class as usize;
        if let (Some(datagrams), Some(sum)) = (self.datagrams.get_mut(place), self.bytes.get_mut(place)) {
            *datagrams += 1;
            *sum += bytes as u64;
        }
        self.bytes_per_s = self.rate_bytes_per_s(now) + bytes as f64 / MEAN_OVER_S;
        self.at = self.at.max(now);
    }

    /// The mean rate at this moment.
    #[must_use]
    pub fn rate_bytes_per_s(&self, now: NodeTime) -> f64 {
        let since_s = now.seconds_since(self.at).max(0.0);
        self.bytes_per_s * (-since_s / MEAN_OVER_S).exp()
    }

    /// All bytes.
    #[must_use]
    pub fn total_bytes(&self) -> u64 {
        self.bytes.iter().sum()
    }
}

#[cfg(test)]
mod tests;
