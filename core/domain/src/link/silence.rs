//! How long nothing has been heard of someone, without the time in which nobody here listened.
//!
//! Must never do: take for heard what was not; be longer than the time that has passed.

use crate::NodeTime;

/// Who looks for words at least twice a second, and then not for so long, stood still: its computer slept, or its container was paused.
const STOOD_STILL_S: f64 = 0.75;

/// Since when nothing has been heard. A node that stood still has missed nothing: what was said meanwhile waits for it, or, where all of it
/// is simulated on one computer, was never said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Silence {
    heard: NodeTime,
    since: NodeTime,
    looked: NodeTime,
}

impl Silence {
    /// Something has just been heard.
    #[must_use]
    pub fn new(now: NodeTime) -> Self {
        Self {
            heard: now,
            since: now,
            looked: now,
        }
    }

    /// Something is heard now.
    pub fn heard(&mut self, now: NodeTime) {
        *self = Self::new(now);
    }

    /// Looks whether it has become too long; at least twice a second, before anything is concluded from it.
    pub fn look(&mut self, now: NodeTime) {
        let gap_s = now.seconds_since(self.looked);
        if gap_s > STOOD_STILL_S {
            self.since = self.since.plus_seconds(gap_s);
        }
        self.looked = self.looked.max(now);
    }

    /// When something was last heard.
    #[must_use]
    pub fn last_heard(&self) -> NodeTime {
        self.heard
    }

    /// When it began; later by the time in which nobody listened.
    #[must_use]
    pub fn since(&self) -> NodeTime {
        self.since
    }
}

#[cfg(test)]
mod tests {
    use super::Silence;
    use crate::NodeTime;

    #[test]
    fn time_in_which_nobody_listened_is_left_out() {
        let at = NodeTime::from_seconds;
        let mut silence = Silence::new(at(10.0));
        (1..=3).for_each(|i| silence.look(at(10.0 + 0.5 * f64::from(i))));
        assert_eq!(silence.since(), at(10.0));
        silence.look(at(13.5));
        assert_eq!(silence.since(), at(12.0), "two seconds of it nobody listened");
        assert_eq!(silence.last_heard(), at(10.0));
        silence.look(at(13.0));
        silence.look(at(14.0));
        assert_eq!(silence.since(), at(12.0));
        silence.heard(at(14.1));
        assert_eq!((silence.since(), silence.last_heard()), (at(14.1), at(14.1)));
    }
}
