//! What is asked for next of an autopilot's logs: a window of one at a time, and of that what did not come.
//!
//! Must never do: read a clock, or hold more than one window.

use mavlink::dialects::common::{LOG_DATA_DATA, LOG_ENTRY_DATA};
use skein_domain::{AutopilotLog, NodeTime};
use std::collections::BTreeMap;

/// Bytes of one message.
const PIECE: usize = 90;
/// Pieces that are asked for at once: 92 kB.
const WINDOW: usize = 1_024;
/// An answer begins within this time, in seconds; after that it is asked again.
const BEGINS_S: f64 = 0.6;
/// An answer that has begun is over when nothing has come for so long, in seconds.
const ENDS_S: f64 = 0.15;
/// Asked so often in vain, it is given up.
const ATTEMPTS: u32 = 12;

/// What is to be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    /// Nothing now.
    Nothing,
    /// A request for these bytes; of a list, for all of it.
    Range {
        /// From where.
        offset: u32,
        /// How many.
        count: u32,
    },
    /// Nobody answers.
    GiveUp,
}

/// Asks, and asks again.
#[derive(Debug, Default)]
struct Patience {
    /// When it was asked last, or something came.
    heard: Option<NodeTime>,
    /// Something came since it was asked.
    answered: bool,
    attempts: u32,
}

impl Patience {
    /// Something came.
    fn progress(&mut self, now: NodeTime) {
        (self.heard, self.answered, self.attempts) = (Some(now), true, 0);
    }

    /// Whether to ask now; `None` to give up.
    fn asks(&mut self, now: NodeTime) -> Option<bool> {
        let wait_s = if self.answered { ENDS_S } else { BEGINS_S };
        if self.heard.is_some_and(|heard| now.seconds_since(heard) < wait_s) {
            return Some(false);
        }
        if self.attempts >= ATTEMPTS {
            return None;
        }
        (self.heard, self.answered, self.attempts) = (Some(now), false, self.attempts + 1);
        Some(true)
    }

    fn waited_s(&self) -> f64 {
        f64::from(self.attempts) * BEGINS_S
    }
}

/// The list of all logs.
#[derive(Debug, Default)]
pub struct Listing {
    found: BTreeMap<u16, AutopilotLog>,
    count: Option<u16>,
    patience: Patience,
}

impl Listing {
    /// One of them, or that there is none.
    pub fn on_entry(&mut self, entry: &LOG_ENTRY_DATA) {
        self.count = Some(entry.num_logs);
        if entry.num_logs == 0 {
            return;
        }
        let log = AutopilotLog {
            number: entry.id,
            size_bytes: entry.size,
            written_unix_s: Some(entry.time_utc).filter(|at| *at > 0),
        };
        self.found.insert(entry.id, log);
    }

    /// All of them, once they are there.
    #[must_use]
    pub fn whole(&self) -> Option<Vec<AutopilotLog>> {
        let count = usize::from(self.count?);
        (self.found.len() >= count).then(|| self.found.values().copied().collect())
    }

    /// What to send now.
    pub fn poll(&mut self, now: NodeTime) -> Asked {
        match self.patience.asks(now) {
            Some(true) => Asked::Range { offset: 0, count: 0 },
            Some(false) => Asked::Nothing,
            None => Asked::GiveUp,
        }
    }

    /// How long was waited in vain, in seconds.
    #[must_use]
    pub fn waited_s(&self) -> f64 {
        self.patience.waited_s()
    }
}

/// A log on its way.
#[derive(Debug)]
pub struct Transfer {
    log: AutopilotLog,
    /// Where the window begins in the log.
    begin: usize,
    bytes: Vec<u8>,
    /// Which pieces of the window are there.
    there: Vec<bool>,
    ready: Vec<u8>,
    /// When the first piece of the window came, and how many have since.
    pace: Option<(NodeTime, u32)>,
    patience: Patience,
}

impl Transfer {
    /// Of this log, from its beginning.
    #[must_use]
    pub fn of(log: AutopilotLog) -> Self {
        let mut transfer = Self {
            log,
            begin: 0,
            bytes: Vec::new(),
            there: Vec::new(),
            ready: Vec::new(),
            pace: None,
            patience: Patience::default(),
        };
        transfer.open();
        transfer
    }

    fn size(&self) -> usize {
        self.log.size_bytes as usize
    }

    fn open(&mut self) {
        let length = (self.size() - self.begin).min(PIECE * WINDOW);
        self.bytes = vec![0; length];
        self.there = vec![false; length.div_ceil(PIECE)];
        self.pace = None;
        self.patience = Patience::default();
    }

    /// Takes a piece. One that is not of this window, or that begins between two, is none.
    pub fn on_data(&mut self, now: NodeTime, data: &LOG_DATA_DATA) {
        let (offset, count) = (data.ofs as usize, usize::from(data.count));
        let Some(within) = offset.checked_sub(self.begin).filter(|_| data.id == self.log.number) else {
            return;
        };
        let piece = within / PIECE;
        let whole = PIECE.min(self.bytes.len().saturating_sub(within));
        let is_new = self.there.get(piece) == Some(&false);
        if !is_new || !within.is_multiple_of(PIECE) || count < whole {
            return;
        }
        let from = data.data.get(..whole).unwrap_or_default();
        if let Some(to) = self.bytes.get_mut(within..within + from.len())
            && let Some(there) = self.there.get_mut(piece)
        {
            to.copy_from_slice(from);
            *there = true;
            self.patience.progress(now);
            self.pace.get_or_insert((now, 0)).1 += 1;
        }
        if self.there.iter().all(|there| *there) {
            self.begin += self.bytes.len();
            self.ready.append(&mut self.bytes);
            self.open();
        }
    }

    /// Bytes that are there in order, and were not taken yet.
    pub fn take_ready(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.ready)
    }

    /// Whether everything came and was taken.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.begin >= self.size() && self.ready.is_empty()
    }

    /// Pieces that come in the time in which it is known that no more do: so many are rather sent twice than asked around.
    fn worth_twice(&self, now: NodeTime) -> usize {
        let rate_hz = self.pace.map_or(0.0, |(since, count)| {
            f64::from(count) / now.seconds_since(since).max(ENDS_S)
        });
        (rate_hz * ENDS_S) as usize
    }

    /// What to send now: the whole window, then its first gap with those that are near behind it.
    pub fn poll(&mut self, now: NodeTime) -> Asked {
        let mut missing = self
            .there
            .iter()
            .enumerate()
            .filter(|(_, there)| !**there)
            .map(|(at, _)| at);
        let Some(first) = missing.next() else {
            return Asked::Nothing;
        };
        let near = self.worth_twice(now) + 1;
        let last = missing.try_fold(first, |last, at| if at - last <= near { Ok(at) } else { Err(last) });
        let (Ok(last) | Err(last)) = last;
        match self.patience.asks(now) {
            Some(true) => {
                let length = ((last + 1 - first) * PIECE).min(self.bytes.len() - first * PIECE);
                Asked::Range {
                    offset: (self.begin + first * PIECE) as u32,
                    count: length as u32,
                }
            }
            Some(false) => Asked::Nothing,
            None => Asked::GiveUp,
        }
    }

    /// How long was waited in vain, in seconds.
    #[must_use]
    pub fn waited_s(&self) -> f64 {
        self.patience.waited_s()
    }
}

#[cfg(test)]
mod tests;
