//! Reading all parameters: the autopilot is asked for all, streams them at its own rate, and is asked again for those that got lost.
//!
//! Gaps are asked for one by one, at most twenty a second and eight at a time: under a kilobyte a second there and back, which a telemetry radio
//! bears beside the telemetry. PX4 itself keeps the stream to the rate its link is set to.
//!
//! Must never do: believe a count without bound, wait for ever, or take one odd frame for a change of the count.

use skein_domain::{NodeTime, ParameterReading};

/// More parameters than this are not read: PX4 has some 1,500.
pub const COUNT_MAX: u16 = 4_096;
/// How often the whole list is asked for while nothing comes.
const LIST_ATTEMPTS: u8 = 4;
/// How long the beginning of the stream is awaited, in seconds.
const START_S: f64 = 1.5;
/// After this silence the stream is over, in seconds.
const SILENCE_S: f64 = 1.0;
/// After the last one of the list nothing but stragglers comes, in seconds.
const STRAGGLERS_S: f64 = 0.2;
/// Between two requests for gaps, in seconds.
const GAP_S: f64 = 0.05;
/// How long the answer to one is awaited, in seconds.
const GAP_ANSWER_S: f64 = 1.0;
/// Requests for gaps that are open at a time.
const GAPS_OPEN_MAX: usize = 8;
/// How often one gap is asked for.
const GAP_ATTEMPTS: u8 = 10;
/// So many frames in succession have to speak of the same other count before it is believed.
const OTHER_COUNT: u8 = 3;
/// How often a list that changed its length is begun anew.
const RESTARTS_MAX: u8 = 2;
/// How long all of it may take, in seconds.
const READING_MAX_S: f64 = 300.0;

/// What is to be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// All.
    All,
    /// The one with this number.
    Number(u16),
}

#[derive(Debug, Clone, Copy, Default)]
struct Slot {
    read: bool,
    attempts: u8,
    asked: Option<NodeTime>,
}

#[derive(Debug, Clone, Copy)]
struct Run {
    begun: NodeTime,
    next: NodeTime,
    /// The stream is over, or was not asked for.
    gaps: bool,
    /// How often all were asked for.
    attempts: u8,
    /// Something was heard of this run.
    heard: bool,
    restarts: u8,
    /// Another count than ours, and in how many frames in succession.
    other: Option<(u16, u8)>,
    /// Where to look for the next gap.
    cursor: usize,
}

/// How far the reading of all has come.
#[derive(Debug, Default)]
pub struct Listing {
    slots: Vec<Slot>,
    read: usize,
    state: ParameterReading,
    run: Option<Run>,
}

impl Listing {
    /// Begins, if it is neither under way nor done. What was read stays read.
    pub fn begin(&mut self, now: NodeTime) {
        if self.run.is_some() || self.state == ParameterReading::Complete {
            return;
        }
        for slot in &mut self.slots {
            (slot.attempts, slot.asked) = (0, None);
        }
        let missing = self.slots.len() - self.read;
        self.run = Some(Run {
            begun: now,
            next: now,
            // Few are cheaper to ask for one by one.
            gaps: self.read > 0 && missing * 4 < self.slots.len(),
            attempts: 0,
            heard: false,
            restarts: 0,
            other: None,
            cursor: 0,
        });
        self.state = ParameterReading::Reading;
    }

    /// Ends it, if it is under way.
    pub fn stop(&mut self, why: &str) {
        if self.run.take().is_some() {
            self.state = ParameterReading::Ended { why: why.to_owned() };
        }
    }

    /// As if nothing had ever been read.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// Whether it is under way.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.run.is_some()
    }

    /// How it stands.
    #[must_use]
    pub fn state(&self) -> ParameterReading {
        self.state.clone()
    }

    /// How many were read.
    #[must_use]
    pub fn read(&self) -> usize {
        self.read
    }

    /// How many there are, once that is known.
    #[must_use]
    pub fn total(&self) -> Option<usize> {
        Some(self.slots.len()).filter(|total| *total > 0)
    }

    /// When [`Self::poll`] has something to do next.
    #[must_use]
    pub fn due(&self) -> Option<NodeTime> {
        self.run.map(|run| run.next)
    }

    /// What is to be asked for now.
    pub fn poll(&mut self, now: NodeTime) -> Option<Wanted> {
        let run = self.run.as_mut().filter(|run| now >= run.next)?;
        if now.seconds_since(run.begun) >= READING_MAX_S {
            let why = format!(
                "{} of {} were read within {READING_MAX_S:.0} s",
                self.read,
                self.slots.len()
            );
            self.stop(&why);
            return None;
        }
        if !run.gaps && run.heard {
            run.gaps = true;
        }
        if run.gaps {
            return self.poll_gaps(now);
        }
        if run.attempts >= LIST_ATTEMPTS {
            self.stop("the autopilot does not answer");
            return None;
        }
        run.attempts += 1;
        run.next = now.plus_seconds(START_S);
        Some(Wanted::All)
    }

    fn poll_gaps(&mut self, now: NodeTime) -> Option<Wanted> {
        let is_open = |slot: &Slot| !slot.read && slot.asked.is_some_and(|at| now.seconds_since(at) < GAP_ANSWER_S);
        let open = self.slots.iter().filter(|slot| is_open(slot)).count();
        let run = self.run.as_mut()?;
        run.next = now.plus_seconds(GAP_S);
        if open >= GAPS_OPEN_MAX {
            return None;
        }
        let total = self.slots.len();
        let wanted = (0..total).map(|step| (run.cursor + step) % total).find(|index| {
            self.slots
                .get(*index)
                .is_some_and(|slot| !slot.read && slot.attempts < GAP_ATTEMPTS && !is_open(slot))
        });
        if let Some(index) = wanted {
            run.cursor = index + 1;
            if let Some(slot) = self.slots.get_mut(index) {
                slot.attempts += 1;
                slot.asked = Some(now);
            }
            return u16::try_from(index).ok().map(Wanted::Number);
        }
        if open == 0 {
            let why = format!("{} of {total} did not come", total - self.read);
            self.stop(&why);
        }
        None
    }

    /// Takes in that one was heard: its number, and how many there are.
    pub fn on_value(&mut self, now: NodeTime, index: u16, count: u16) {
        // An answer by name has no number.
        if index == u16::MAX || count == 0 {
            return;
        }
        let Some(run) = self.run.as_mut() else { return };
        let known = self.slots.len();
        if usize::from(count) != known && (known > 0 || count > COUNT_MAX) {
            self.on_other_count(now, count);
            return;
        }
        run.other = None;
        if known == 0 {
            self.slots = vec![Slot::default(); usize::from(count)];
        }
        let Some(slot) = self.slots.get_mut(usize::from(index)) else {
            return;
        };
        if !slot.read {
            slot.read = true;
            self.read += 1;
        }
        run.heard = true;
        if self.read == self.slots.len() {
            self.run = None;
            self.state = ParameterReading::Complete;
        } else if !run.gaps {
            let is_last = usize::from(index) + 1 == self.slots.len();
            let more = now.plus_seconds(if is_last { STRAGGLERS_S } else { SILENCE_S });
            // Whatever goes on coming, the end is looked at in time.
            run.next = more.min(run.begun.plus_seconds(READING_MAX_S));
        }
    }

    /// PX4 counts the parameters that are in use: with one more of them all numbers after it are others.
    fn on_other_count(&mut self, now: NodeTime, count: u16) {
        let Some(run) = self.run.as_mut() else { return };
        let times = match run.other {
            Some((other, times)) if other == count => times + 1,
            _ => 1,
        };
        run.other = Some((count, times));
        if times < OTHER_COUNT {
            return;
        }
        if count > COUNT_MAX {
            let why = format!("the autopilot speaks of {count} parameters; at most {COUNT_MAX} are read");
            self.stop(&why);
            return;
        }
        if run.restarts >= RESTARTS_MAX {
            self.stop("the number of the autopilot's parameters keeps changing");
            return;
        }
        *run = Run {
            next: now,
            gaps: false,
            attempts: 0,
            heard: false,
            restarts: run.restarts + 1,
            other: None,
            cursor: 0,
            ..*run
        };
        self.slots = vec![Slot::default(); usize::from(count)];
        self.read = 0;
    }
}

#[cfg(test)]
mod tests;
