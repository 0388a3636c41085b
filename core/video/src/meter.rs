//! How a stream is: pictures and bytes per second, what was lost.

use crate::frame::EncodedFrame;
use skein_domain::NodeTime;
use std::collections::VecDeque;

/// Measured is over so long, in seconds.
const OVER_S: f64 = 2.0;
/// A rate is told of so many pictures at least.
const MOST_FRAMES: usize = 256;
/// A larger step of the numbers is another run of the camera, no loss.
const MOST_LOST: u64 = 1_000;

/// What was measured over the last seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measured {
    /// Pictures per second.
    pub rate_hz: f64,
    /// Bytes per second.
    pub bytes_per_s: f64,
    /// Share of the pictures that were lost, 0 to 1.
    pub lost: f64,
}

#[derive(Debug, Clone, Copy)]
struct Seen {
    at: NodeTime,
    bytes: usize,
    lost: u64,
}

/// Measures one stream.
#[derive(Debug, Default)]
pub struct Meter {
    seen: VecDeque<Seen>,
    last: Option<u64>,
}

impl Meter {
    /// A picture came.
    pub fn count(&mut self, now: NodeTime, frame: &EncodedFrame) {
        let step = self.last.map_or(1, |last| frame.sequence.saturating_sub(last));
        let lost = step.saturating_sub(1);
        self.last = Some(frame.sequence);
        self.seen.push_back(Seen {
            at: now,
            bytes: frame.bytes.len(),
            lost: if lost > MOST_LOST { 0 } else { lost },
        });
        let old = |seen: &Seen| now.seconds_since(seen.at) > OVER_S;
        while self.seen.len() > MOST_FRAMES || self.seen.front().is_some_and(old) {
            self.seen.pop_front();
        }
    }

    /// When the last picture came.
    #[must_use]
    pub fn last_at(&self) -> Option<NodeTime> {
        self.seen.back().map(|seen| seen.at)
    }

    /// What was measured up to now.
    #[must_use]
    pub fn measured(&self, now: NodeTime) -> Measured {
        let young = |seen: &&Seen| now.seconds_since(seen.at) <= OVER_S;
        let seen: Vec<&Seen> = self.seen.iter().filter(young).collect();
        let (Some(first), count) = (seen.first(), seen.len() as f64) else {
            return Measured::default();
        };
        // From the first of them on, so that a stream that has just begun is not told to be slow.
        let over_s = now.seconds_since(first.at).max(1.0 / 120.0);
        let lost = seen.iter().map(|seen| seen.lost).sum::<u64>() as f64;
        let bytes = seen.iter().map(|seen| seen.bytes).sum::<usize>() as f64;
        Measured {
            rate_hz: (count - 1.0).max(0.0) / over_s,
            bytes_per_s: bytes / over_s.max(OVER_S / 2.0),
            lost: lost / (count + lost),
        }
    }
}

#[cfg(test)]
mod tests;
