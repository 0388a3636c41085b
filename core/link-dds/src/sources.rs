//! Who speaks as a vehicle: one participant of DDS, until it is silent and another one speaks.
//!
//! Must never do: mix what two autopilots say; take an agent that was started anew for a second vehicle.

use skein_domain::NodeTime;

/// A participant, by the part of its identity that all its writers share.
pub type Participant = [u8; 12];

/// A vehicle that is silent for this long while another one speaks in its place has been replaced, in seconds.
const MOVED_AFTER_S: f64 = 0.5;
/// Two are two when the first is still heard this long after the second came up, in seconds.
const BOTH_AFTER_S: f64 = 0.3;

/// Whose a sample is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Speaker {
    /// The vehicle's.
    Known,
    /// The vehicle's from now on: it has to be looked at anew.
    New,
    /// Another one's, which is not to be read.
    Other,
    /// Another one's, and now it is clear that there are two.
    Second,
}

#[derive(Debug, Clone, Copy)]
struct Rival {
    who: Participant,
    first: NodeTime,
    last: NodeTime,
}

/// Who speaks in one namespace.
#[derive(Debug, Default)]
pub struct Sources {
    known: Option<(Participant, NodeTime)>,
    rival: Option<Rival>,
    two: bool,
}

impl Sources {
    /// Somebody has spoken.
    pub fn on_sample(&mut self, now: NodeTime, who: Participant) -> Speaker {
        let Some((known, heard)) = &mut self.known else {
            self.known = Some((who, now));
            return Speaker::New;
        };
        if *known == who {
            *heard = now;
            return Speaker::Known;
        }
        let silent_s = now.seconds_since(*heard);
        if silent_s > MOVED_AFTER_S {
            return self.replace(now, who);
        }
        let heard = *heard;
        let rival = match &mut self.rival {
            Some(rival) if rival.who == who => rival,
            other => other.insert(Rival {
                who,
                first: now,
                last: now,
            }),
        };
        rival.last = now;
        if !self.two && heard.seconds_since(rival.first) > BOTH_AFTER_S {
            self.two = true;
            return Speaker::Second;
        }
        Speaker::Other
    }

    /// The one that spoke so far was none: from now on this one is the vehicle.
    pub fn replace(&mut self, now: NodeTime, who: Participant) -> Speaker {
        *self = Self {
            known: Some((who, now)),
            ..Self::default()
        };
        Speaker::New
    }

    /// Whether two speak, and neither has been silent for long.
    #[must_use]
    pub fn are_two(&self) -> bool {
        self.two
    }

    /// Who speaks as the vehicle, if anybody did.
    #[must_use]
    pub fn known(&self) -> Option<Participant> {
        self.known.map(|(who, _)| who)
    }

    /// Whether there were two and one of them has been silent for so long that it is one again.
    pub fn is_one_again(&mut self, now: NodeTime, clear_s: f64) -> bool {
        let silent = self.rival.is_none_or(|rival| now.seconds_since(rival.last) > clear_s);
        if self.two && silent {
            (self.two, self.rival) = (false, None);
            return true;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    //! One, another one after it, and two at once.

    use super::*;

    const A: Participant = [1; 12];
    const B: Participant = [2; 12];

    fn at(seconds: f64) -> NodeTime {
        NodeTime::from_seconds(seconds)
    }

    #[test]
    fn one_that_comes_after_another_takes_its_place() {
        let mut sources = Sources::default();
        assert_eq!(sources.on_sample(at(1.0), A), Speaker::New);
        assert_eq!(sources.on_sample(at(1.1), A), Speaker::Known);
        assert_eq!(sources.on_sample(at(1.5), B), Speaker::Other, "it may be a stray one");
        assert_eq!(sources.on_sample(at(1.7), B), Speaker::New);
        assert_eq!(sources.on_sample(at(1.8), B), Speaker::Known);
        assert!(!sources.is_one_again(at(9.0), 3.0));
    }

    #[test]
    fn two_at_once_are_told_once_and_end_when_one_is_silent() {
        let mut sources = Sources::default();
        let mut told = Vec::new();
        for i in 0..100 {
            let now = at(1.0 + f64::from(i) * 0.02);
            told.push(sources.on_sample(now, A));
            if i > 10 {
                told.push(sources.on_sample(now, B));
            }
            assert!(!sources.is_one_again(now, 3.0));
        }
        assert_eq!(told.iter().filter(|speaker| **speaker == Speaker::Second).count(), 1);
        assert_eq!(told.iter().filter(|speaker| **speaker == Speaker::New).count(), 1);
        for i in 0..200 {
            assert_eq!(sources.on_sample(at(3.0 + f64::from(i) * 0.02), A), Speaker::Known);
        }
        assert!(sources.is_one_again(at(7.0), 3.0));
        assert!(!sources.is_one_again(at(7.0), 3.0));
    }
}
