//! Marks on what a vehicle publishes by which its setpoints tell what they knew: its estimator's origin steps to and fro by a metre, the position in that
//! frame with it. To a node this is the same place on Earth, and the setpoint for it has other numbers in the vehicle's frame.
//!
//! Must never do: read a clock; step while the answer to the last step is missing.

use std::time::{Duration, Instant};

/// How far the origin steps northwards, in metres. Less than what a node takes for an estimator that failed.
pub(crate) const STEP_M: f64 = 1.0;
/// The next step comes so long after the answer, at the soonest, and up to `SPREAD` later, so that steps fall on every part of the node's period.
const REST: Duration = Duration::from_millis(60);
const SPREAD: Duration = Duration::from_millis(40);
/// A step that shows in no setpoint for so long has got lost.
const LOST_AFTER: Duration = Duration::from_secs(1);

/// What was found in a window.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Marked {
    /// From the first sample with a step to the first setpoint that knows of it, in microseconds.
    pub reactions_us: Vec<u32>,
    /// Between two setpoints, in microseconds.
    pub intervals_us: Vec<u32>,
    /// Steps that showed in no setpoint.
    pub lost: usize,
}

/// Steps, and the setpoints that come of them.
#[derive(Debug, Default)]
pub(crate) struct Marks {
    /// Northwards, in the frame without a step: what is held in this window.
    held_m: Option<f64>,
    /// Of the last setpoint, northwards; and when it came.
    last: Option<(Instant, f64)>,
    stepped: bool,
    /// Since when the last step is unanswered.
    pending: Option<Instant>,
    next: Option<Instant>,
    steps: u32,
    found: Marked,
}

impl Marks {
    /// Begins a window of a vehicle that holds its place. False if it has got no setpoint yet.
    pub fn begin(&mut self, now: Instant) -> bool {
        self.held_m = self.last.map(|(_, north_m)| north_m);
        self.next = Some(now + REST);
        self.found = Marked::default();
        self.held_m.is_some()
    }

    /// Ends it: the vehicle's frame is without a step from now on.
    pub fn end(&mut self) -> Marked {
        (self.held_m, self.stepped, self.pending) = (None, false, None);
        std::mem::take(&mut self.found)
    }

    /// A sample of the position goes out now: how far north the origin is of where it was.
    pub fn publish(&mut self, now: Instant) -> f64 {
        if self.pending.is_some_and(|since| now - since > LOST_AFTER) {
            self.found.lost += 1;
            self.pending = None;
            self.next = Some(now);
        }
        let due = self.held_m.is_some() && self.pending.is_none() && self.next.is_some_and(|next| now >= next);
        if due {
            self.stepped = !self.stepped;
            self.pending = Some(now);
            self.steps = self.steps.wrapping_add(1);
        }
        f64::from(u8::from(self.stepped)) * STEP_M
    }

    /// A setpoint has come, with so much north in the vehicle's frame.
    pub fn setpoint(&mut self, now: Instant, north_m: f64) {
        let before = self.last.replace((now, north_m));
        if self.held_m.is_none() {
            return;
        }
        if let Some((then, _)) = before {
            self.found.intervals_us.push(microseconds(now - then));
        }
        let knows = (self.origin_of(north_m) > 0.0) == self.stepped;
        if let Some(since) = self.pending.filter(|_| knows) {
            self.found.reactions_us.push(microseconds(now - since));
            self.pending = None;
            // Golden-ratio steps fall evenly over any period.
            let phase = (f64::from(self.steps) * 0.618_033_988_75).fract();
            self.next = Some(now + REST + SPREAD.mul_f64(phase));
        }
    }

    /// Where a setpoint takes the origin to be.
    pub fn origin_of(&self, north_m: f64) -> f64 {
        let off_m = self.held_m.map_or(0.0, |held_m| held_m - north_m);
        if off_m > 0.5 * STEP_M { STEP_M } else { 0.0 }
    }
}

fn microseconds(time: Duration) -> u32 {
    u32::try_from(time.as_micros()).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests;
