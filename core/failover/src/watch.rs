//! When a coordinator is missed, and whose turn it is to take over.
//!
//! Must never do: count the same pulse twice as a sign of life. Ages are not passed on, because those who pass them on to each other
//! would keep a dead holder alive; the numbers of pulses are.

use crate::{Beacon, Office, Standing, Term};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;

/// Limits of the watch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WatchSettings {
    /// A holder without a new pulse for so long is lost, in seconds. Several periods of beacons.
    pub lost_after_s: f64,
    /// Each less suited candidate waits so much longer than the one before it, in seconds: longer than a claim needs to get around.
    pub stagger_s: f64,
    /// A node that has just started listens for so long before it misses anybody, in seconds.
    pub listen_s: f64,
    /// How many others must be heard to take over. With none, a node that is cut off would coordinate itself alone.
    pub least_others: usize,
}

impl Default for WatchSettings {
    fn default() -> Self {
        Self {
            lost_after_s: 0.5,
            stagger_s: 0.2,
            listen_s: 2.0,
            least_others: 1,
        }
    }
}

/// What a candidate should do now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// A holder is there.
    Held,
    /// None is; others are to take over first, or it can't be said yet.
    Wait,
    /// It is this node's turn to claim the office.
    Claim,
    /// This node coordinates, but some obey another holder of the same number, and go on doing so: it is to take the next number.
    Renew,
    /// None is, and too few others are heard to take over: the node is cut off.
    Alone,
}

#[derive(Debug, Clone, Copy)]
struct Heard {
    at: NodeTime,
    standing: Option<Standing>,
}

/// The watch of one node over the office.
#[derive(Debug, Clone)]
pub struct Watch {
    settings: WatchSettings,
    started: NodeTime,
    others: BTreeMap<NodeId, Heard>,
    /// The obeyed term, its newest pulse, and when that one was first heard of.
    pulse: Option<(Term, u64, NodeTime)>,
    /// Since when others have been heard to obey another holder of the obeyed number.
    divided: Option<NodeTime>,
}

impl Watch {
    /// A watch that begins at `now`.
    #[must_use]
    pub fn new(settings: WatchSettings, now: NodeTime) -> Self {
        Self {
            settings,
            started: now,
            others: BTreeMap::new(),
            pulse: None,
            divided: None,
        }
    }

    /// Takes a beacon of another node in. Call it after [`Office::hear`].
    pub fn hear(&mut self, now: NodeTime, office: &Office, beacon: &Beacon) {
        let heard = Heard {
            at: now,
            standing: beacon.standing,
        };
        self.others.insert(beacon.from, heard);
        self.follow(now, office);
        let same_number = |a: Term, b: Term| a.number == b.number && a.holder.node != b.holder.node;
        if office
            .obeyed()
            .zip(beacon.obeys)
            .is_some_and(|(a, b)| same_number(a, b))
        {
            self.divided.get_or_insert(now);
        }
        if let Some((term, pulse, since)) = self.pulse.as_mut()
            && beacon.obeys == Some(*term)
            && beacon.pulse > *pulse
        {
            (*pulse, *since) = (beacon.pulse, now);
        }
    }

    /// The beacon to send now. A holder's counts its pulse up.
    pub fn beacon(&mut self, now: NodeTime, me: NodeId, office: &Office) -> Beacon {
        self.follow(now, office);
        if let Some((_, pulse, since)) = self.pulse.as_mut().filter(|_| office.acting().is_some()) {
            (*pulse, *since) = (pulse.saturating_add(1), now);
        }
        Beacon {
            from: me,
            obeys: office.obeyed(),
            pulse: self.pulse.map_or(0, |(_, pulse, _)| pulse),
            standing: office.standing(),
        }
    }

    /// How long there has been no new pulse of the obeyed term's holder, in seconds; none before the first term.
    #[must_use]
    pub fn silent_s(&self, now: NodeTime) -> Option<f64> {
        self.pulse.map(|(_, _, since)| now.seconds_since(since))
    }

    /// The others heard lately.
    pub fn present(&self, now: NodeTime) -> impl Iterator<Item = NodeId> {
        let within_s = self.present_within_s();
        self.others
            .iter()
            .filter(move |(_, heard)| now.seconds_since(heard.at) <= within_s)
            .map(|(id, _)| *id)
    }

    /// What a candidate should do now.
    #[must_use]
    pub fn turn(&self, now: NodeTime, office: &Office) -> Turn {
        if office.acting().is_some() {
            // The better suited one renews at once when it hears of it; if none has, the other one is not acting.
            let lasts = self
                .divided
                .is_some_and(|since| now.seconds_since(since) > self.settings.lost_after_s);
            return if lasts { Turn::Renew } else { Turn::Held };
        }
        if self
            .silent_s(now)
            .is_some_and(|silent_s| silent_s <= self.settings.lost_after_s)
        {
            return Turn::Held;
        }
        let missed_s = self.missed_s(now);
        let Some(mine) = office.standing().filter(|_| missed_s > 0.0) else {
            return Turn::Wait;
        };
        if self.present(now).count() < self.settings.least_others {
            return Turn::Alone;
        }
        if missed_s > self.settings.stagger_s * self.better_than(now, office, mine) as f64 {
            Turn::Claim
        } else {
            Turn::Wait
        }
    }

    /// How long the holder has been missed, in seconds. Who has just started misses nobody before it has listened.
    fn missed_s(&self, now: NodeTime) -> f64 {
        let listened_s = now.seconds_since(self.started) - self.settings.listen_s;
        let lost_s = self
            .silent_s(now)
            .map_or(listened_s, |silent_s| silent_s - self.settings.lost_after_s);
        lost_s.min(listened_s)
    }

    /// How many of those heard lately are more suited. The missed holder is none of them: it may still be heard of, not acting.
    fn better_than(&self, now: NodeTime, office: &Office, mine: Standing) -> usize {
        let missed = office.obeyed().map(|term| term.holder.node);
        let within_s = self.present_within_s();
        let present = self
            .others
            .iter()
            .filter(|(_, heard)| now.seconds_since(heard.at) <= within_s);
        present
            .filter(|(id, heard)| Some(**id) != missed && heard.standing.is_some_and(|standing| standing > mine))
            .count()
    }

    /// Somebody not heard for longer is not counted on. As long as a holder's: whoever went with it is then known to have gone.
    fn present_within_s(&self) -> f64 {
        self.settings.lost_after_s
    }

    /// Begins to count anew when another term is obeyed: taking office is a sign of life.
    fn follow(&mut self, now: NodeTime, office: &Office) {
        let Some(obeyed) = office.obeyed() else { return };
        if self.pulse.is_none_or(|(term, ..)| term != obeyed) {
            self.pulse = Some((obeyed, 0, now));
            self.divided = None;
        }
    }
}

#[cfg(test)]
mod tests;
