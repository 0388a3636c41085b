//! How long the calls of one instance take. Written by the runner thread, read by anyone, without a lock.

use serde::Serialize;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Buckets of the histogram: four per doubling, from under 1 µs to over 16 s.
const BUCKETS: usize = 100;

/// Call times of one instance.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct CallStatistics {
    /// How many calls came back.
    pub calls: u64,
    /// How many of them failed.
    pub failures: u64,
    /// Half of the calls were no slower, in microseconds (to a fifth, upwards).
    pub p50_us: f64,
    /// All but one in a hundred calls were no slower, in microseconds (to a fifth, upwards).
    pub p99_us: f64,
    /// The slowest call in microseconds.
    pub max_us: f64,
    /// Log lines that were dropped because the instance wrote too many.
    pub dropped_log_lines: u64,
}

/// Where the times are collected.
#[derive(Debug)]
pub(crate) struct CallTimes {
    buckets: [AtomicU64; BUCKETS],
    failures: AtomicU64,
    max_ns: AtomicU64,
}

impl Default for CallTimes {
    fn default() -> Self {
        Self {
            buckets: [const { AtomicU64::new(0) }; BUCKETS],
            failures: AtomicU64::new(0),
            max_ns: AtomicU64::new(0),
        }
    }
}

impl CallTimes {
    /// Counts a call. Only by the thread that makes it: nobody else writes.
    pub(crate) fn record(&self, took: Duration, failed: bool) {
        let nanoseconds = u64::try_from(took.as_nanos()).unwrap_or(u64::MAX);
        // One writer needs no locked additions, which cost more than all the rest of this.
        let add = |to: &AtomicU64| to.store(to.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
        if let Some(bucket) = self.buckets.get(bucket(nanoseconds)) {
            add(bucket);
        }
        if failed {
            add(&self.failures);
        }
        if nanoseconds > self.max_ns.load(Ordering::Relaxed) {
            self.max_ns.store(nanoseconds, Ordering::Relaxed);
        }
    }

    pub(crate) fn read(&self, dropped_log_lines: u64) -> CallStatistics {
        let counts = self.buckets.each_ref().map(|bucket| bucket.load(Ordering::Relaxed));
        let calls = counts.iter().sum();
        let max_us = self.max_ns.load(Ordering::Relaxed) as f64 * 1e-3;
        let quantile = |share: f64| {
            let rank = (calls as f64 * share).ceil().max(1.0) as u64;
            let mut seen = 0;
            for (i, count) in counts.iter().enumerate() {
                seen += count;
                if seen >= rank {
                    return upper_bound_us(i).min(max_us);
                }
            }
            0.0
        };
        CallStatistics {
            calls,
            failures: self.failures.load(Ordering::Relaxed),
            p50_us: quantile(0.50),
            p99_us: quantile(0.99),
            max_us,
            dropped_log_lines,
        }
    }
}

/// Bucket 0 holds all up to 1 µs, bucket i all up to 2^(i/4) µs, the last one the rest.
fn bucket(nanoseconds: u64) -> usize {
    if nanoseconds <= 1_000 {
        return 0;
    }
    let microseconds = nanoseconds as f64 * 1e-3;
    ((microseconds.log2() * 4.0).ceil() as usize).min(BUCKETS - 1)
}

fn upper_bound_us(bucket: usize) -> f64 {
    if bucket + 1 >= BUCKETS {
        f64::INFINITY
    } else {
        (bucket as f64 / 4.0).exp2()
    }
}

#[cfg(test)]
mod tests;
